//! Progress of lifting.

use serde::{Deserialize, Serialize};

/// A step of lifting.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Step {
    /// Tracking points through the colour images, where the recording has no tracks.
    Track,
    /// Reading frames, cleaning masks, lifting tracks.
    Lift,
    /// Filtering motion, thinning, control points.
    Assemble,
    /// Aligning and sampling the mesh.
    Complete,
}

/// Progress of lifting.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Progress {
    /// The step under way.
    pub step: Step,
    /// Share of the whole work that is done, 0..=1.
    pub fraction: f64,
}
