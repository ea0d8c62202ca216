//! Errors of tracking.

use bendtwin_core::Problem;

/// The reason for which a recording cannot be tracked.
#[derive(Debug, thiserror::Error, Problem)]
pub enum Error {
    /// Settings out of range.
    #[error("the tracker's settings are wrong: {}", .0.join("; "))]
    #[problem(InvalidArgument, "FLOW_SETTINGS_INVALID")]
    Settings(Vec<String>),
    /// The recording is inconsistent.
    #[error(transparent)]
    Recording(#[from] bendtwin_capture::Error),
    /// An image has another size than its camera says.
    #[error(
        "{what} of camera `{camera}`, frame {frame}, has {found:?} pixels where its calibration says {expected:?}: \
         export colour, depth and masks on one grid"
    )]
    #[problem(InvalidArgument, "IMAGE_SIZE_MISMATCH")]
    ImageSize {
        /// Name of the camera.
        camera: String,
        /// Number of the frame.
        frame: usize,
        /// The image: colour, depth, or whose mask.
        what: &'static str,
        /// Columns and rows found.
        found: (usize, usize),
        /// Columns and rows of the camera.
        expected: (usize, usize),
    },
    /// Stopped on request.
    #[error("tracking was cancelled")]
    #[problem(Cancelled, "CANCELLED")]
    Cancelled,
}
