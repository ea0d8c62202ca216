//! Reasons for which nothing can be calibrated at all. Faults of a board in a recording are findings.

use bendtwin_core::{CancelToken, Problem};

/// Why a calibration fails.
#[derive(Debug, thiserror::Error, Problem)]
pub enum Error {
    /// A board that cannot exist.
    #[error("the board is not as described: {0}")]
    #[problem(InvalidArgument, "INVALID_BOARD")]
    Board(String),
    /// Frames cannot be read.
    #[error(transparent)]
    Recording(#[from] bendtwin_capture::Error),
    /// A calibration of another program that cannot be read.
    #[error("`{at}` is no calibration that can be read: {fault}")]
    #[problem(InvalidArgument, "CALIBRATION_UNREADABLE")]
    File {
        /// The file or folder.
        at: String,
        /// The fault, and what to do.
        fault: String,
    },
    /// A calibration that belongs to other cameras.
    #[error("the calibration does not suit the recording: {0}")]
    #[problem(InvalidArgument, "CALIBRATION_OF_OTHER_CAMERAS")]
    Unsuited(String),
    /// The search for corners failed.
    #[error("corners cannot be searched in these images: {0}")]
    #[problem(InvalidArgument, "CORNERS_NOT_SEARCHED")]
    Detector(String),
    /// Cancelled on request.
    #[error("the calibration was cancelled")]
    #[problem(Cancelled, "CANCELLED")]
    Cancelled,
}

/// Ends the work if cancellation was requested.
pub(crate) fn check(cancel: &CancelToken) -> Result<(), Error> {
    if cancel.is_cancelled() { Err(Error::Cancelled) } else { Ok(()) }
}
