//! Fitting: a zeroth-order search over global variables (CMA-ES), then a first-order refinement of every
//! spring and triplet (Adam on the adjoint gradient), over any backend.

mod error;
mod job;

pub use error::{Error, ObserverError};
pub use job::{FitJob, Observer, Outcome};
