//! Errors of evaluating a twin.

use bendtwin_core::Problem;
use bendtwin_engine::backend;

/// An error that ends an evaluation.
#[derive(Clone, Debug, PartialEq, thiserror::Error, Problem)]
pub enum Error {
    /// The twin was made from another kind of capture.
    #[error(
        "the twin does not fit the capture: {0}; evaluate it against the capture that it was fitted to"
    )]
    #[problem(InvalidArgument, "TWIN_DOES_NOT_FIT_CAPTURE")]
    Mismatch(String),
    /// The capture contradicts itself.
    #[error("the capture contradicts itself: {0}; write it again with arrays of matching shapes")]
    #[problem(InvalidArgument, "CAPTURE_INCONSISTENT")]
    Inconsistent(String),
    /// The simulation failed.
    #[error(transparent)]
    Backend(#[from] backend::Error),
    /// A state could not be corrected.
    #[error(transparent)]
    Register(#[from] bendtwin_register::Error),
    /// The picture could not be drawn.
    #[error("the picture could not be drawn: {0}")]
    #[problem(Internal, "PICTURE_FAILED")]
    Picture(String),
}

impl From<bendtwin_picture::Error> for Error {
    fn from(error: bendtwin_picture::Error) -> Self {
        Self::Picture(error.to_string())
    }
}
