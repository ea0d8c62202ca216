//! What a backend is timed on: named scenes of the sizes that are usual for twins, rollouts and gradients
//! of batches of them, and whole fits; beside each time stands the least time that the device's
//! instruction issue allows. Everything goes through [`bendtwin_engine::Backend`], so all backends are
//! measured alike. Prints nothing and reads no files: that is for the command line.

pub mod bound;
mod clock;
mod clocked;
mod error;
pub mod fit;
mod measure;
mod memory;
pub mod report;
mod run;
pub mod scene;

pub use bound::IssueBound;
pub use error::Error;
pub use fit::{FitPlan, Scheme};
pub use memory::{DeviceMemory, MemoryProbe};
pub use report::Report;
pub use run::{Plan, Subject, run};
pub use scene::{Scene, SceneName};
