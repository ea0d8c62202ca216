//! Fitting: a zeroth-order search over global variables (CMA-ES), then a first-order refinement of
//! every spring and triplet (Adam on the adjoint gradient), over any backend.
//!
//! **Models.** The twin and the axial-only model that it is compared with go through all stages
//! side by side, so that a batch holds the candidates of both. **Repeatability.** Every random
//! number follows from the seed and the iteration, every sum has a fixed order: the same capture,
//! settings, build and device give the same twin, and a fit continued from a checkpoint ends in the
//! same twin as one that was never interrupted.

mod built_graph;
mod distill;
mod error;
mod job;
mod look;
pub mod memory;
mod progress;
mod refine;
mod search;
mod submit;
mod task;

pub use bendtwin_appearance::ComparedPair;
pub use bendtwin_splat::OpenRasteriser;
pub use distill::{Budget, Choice, Distillation};
pub use error::Error;
pub use job::{FitJob, Outcome};
pub use look::{Look, LookInput, OpenVideo};
