//! What a fit has so far, to be looked at while it runs.

use super::Stage;
use crate::{Point, quality::Measure};

/// Predicted motion of the best parameters so far, thinned to what a picture needs, and its errors.
#[derive(Clone, Debug, PartialEq)]
pub struct Preview {
    /// Stage that found the parameters.
    pub stage: Stage,
    /// Model, as in [`Progress::variant`](super::Progress::variant).
    pub variant: String,
    /// Iterations of the stage that were done.
    pub iteration: u32,
    /// Index of the predicted sequence among those of the capture.
    pub sequence: u32,
    /// Frames of the sequence, ascending, shape [F].
    pub frames: Vec<u32>,
    /// Points of the skin in these frames [m], shape [F, P, 3].
    pub positions: Vec<Point>,
    /// Errors of the prediction.
    pub errors: PreviewErrors,
}

/// Errors of a preview, in the measure that the twin will be judged by.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PreviewErrors {
    /// The kind of error.
    pub measure: Measure,
    /// Over the frames that the parameters are fitted to [m].
    pub error_m: f64,
    /// Over training frames that are held back to choose among starts [m]; none where none are.
    pub held_back_m: Option<f64>,
    /// The same for an object that stands still, over the frames of `error_m` [m].
    pub baseline_m: f64,
}

impl Preview {
    /// Most frames of a preview.
    pub const MOST_FRAMES: usize = 24;
    /// Most points of a preview.
    pub const MOST_POINTS: usize = 400;

    /// Number of points P.
    pub fn point_count(&self) -> usize {
        self.positions.len() / self.frames.len().max(1)
    }
}
