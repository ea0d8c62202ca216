//! Predicted motion of one sequence with the errors of its frames, for players.

use bendtwin_core::{Capture, Sequence, quality::ErrorSummary};

use crate::{Trajectory, metrics::Reference};

/// A prediction beside the sequence that it is compared with.
#[derive(Clone, Debug, PartialEq)]
pub struct Motion {
    /// Name of the recording.
    pub recording: String,
    /// Name of the sequence.
    pub sequence: String,
    /// Frames per second.
    pub fps: f64,
    /// Number of frames T of the sequence.
    pub frame_count: usize,
    /// Frames before this one were for fitting; 0 if the twin was fitted to none.
    pub train_frame_count: usize,
    /// The prediction, from its start to the end of the sequence.
    pub prediction: Trajectory,
    /// Errors at the skin in each frame of the prediction.
    pub errors: Vec<ErrorSummary>,
}

impl Motion {
    /// `on_skin` is the prediction at the points that `reference` is about.
    pub(crate) fn new(
        recording: &Capture,
        sequence: &Sequence,
        reference: &Reference<'_>,
        prediction: &Trajectory,
        on_skin: &Trajectory,
    ) -> Self {
        let frames = prediction.start_frame..sequence.frame_count;
        let error = |frame| on_skin.at(frame).map(|at| reference.measure(frame, at));
        Self {
            recording: recording.name.clone(),
            sequence: sequence.name.clone(),
            fps: recording.fps,
            frame_count: sequence.frame_count,
            train_frame_count: reference.train_frame_count(),
            prediction: prediction.clone(),
            errors: frames.map(|frame| error(frame).unwrap_or_default()).collect(),
        }
    }
}
