//! Benchmarks of backends: named scenes of the sizes that are usual for twins, rollouts and
//! gradients of batches of them, and whole fits; each time is given with the least time that the
//! device's instruction issue allows. Everything goes through [`bendtwin_engine::Backend`], so all
//! backends are measured alike. This crate prints nothing and reads no files; the command line
//! does.

pub mod bound;
mod clock;
mod error;
pub mod fit;
mod measure;
mod memory;
pub mod report;
mod run;
pub mod scene;
mod timed;

pub use bound::IssueBound;
pub use error::Error;
pub use fit::{FitPlan, Scheme};
pub use memory::{DeviceMemory, MemoryProbe};
pub use report::Report;
pub use run::{Plan, Setup, run};
pub use scene::{Scene, SceneName};
