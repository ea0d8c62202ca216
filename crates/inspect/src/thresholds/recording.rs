//! Numbers for the judge of the recording as a whole.

use std::ops::RangeInclusive;

/// Length, frame rate, damaged files.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct RecordingThresholds {
    /// Frames of the shortest recording without a warning. Half a second at 30 frames a second;
    /// shorter ones do not show how a motion dies away.
    pub(crate) min_frames: usize,
    /// Frame rates that cameras have [1/s]. Chosen by hand, so that the time of a frame in seconds
    /// or milliseconds, given by mistake, lies outside.
    pub(crate) usual_fps: RangeInclusive<f64>,
    /// More damaged files than one in this many frames are an error, fewer a warning. Chosen by
    /// hand.
    pub(crate) max_damaged_one_in: usize,
}

impl Default for RecordingThresholds {
    fn default() -> Self {
        Self { min_frames: 15, usual_fps: 5.0..=1000.0, max_damaged_one_in: 10 }
    }
}
