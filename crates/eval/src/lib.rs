//! How good a twin is: Chamfer distance, track error, free baselines, pictures. Knows no optimiser.

mod error;
mod evaluate;
mod trajectory;

pub use error::Error;
pub use evaluate::{EvaluateOptions, evaluate};
pub use trajectory::{Trajectory, check_capture, initial_state, instance, predict, slice_len};
