//! Quality of a twin: Chamfer distance, track error, free baselines, pictures. Independent of how a
//! twin was fitted.

mod assess;
mod baselines;
mod branches;
mod correction;
mod distance;
mod error;
mod evaluate;
mod fidelity;
mod metrics;
mod motion;
pub mod picture;
mod placement;
#[cfg(test)]
mod scene;
mod spread;
mod surface;
mod table;
mod training;
mod trajectory;

pub use assess::{Scale, assess, differ};
pub use correction::{CorrectionPlan, CorrectionScore, corrections};
pub use error::Error;
pub use evaluate::{EvaluateOptions, evaluate, evaluate_with_motion, score};
pub use fidelity::fast_variant;
pub use motion::Motion;
pub use placement::{Grip, Placement, in_recording, is_own_capture};
pub use table::{TableStyle, format_table, predictor_name};
pub use training::{TrainingErrors, stand_still, training_errors};
pub use trajectory::{Trajectory, check_capture, initial_state, instance, predict, slice_len};
