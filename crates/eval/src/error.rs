//! Errors of evaluating a twin.

use bendtwin_core::{Category, Problem};
use bendtwin_engine::backend;

/// An error that ends an evaluation.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Error {
    /// The twin was made from another kind of capture.
    #[error(
        "the twin does not fit the capture: {0}; evaluate it against the capture that it was fitted to"
    )]
    Mismatch(String),
    /// The capture contradicts itself.
    #[error("the capture contradicts itself: {0}; write it again with arrays of matching shapes")]
    Inconsistent(String),
    /// The simulation failed.
    #[error(transparent)]
    Backend(#[from] backend::Error),
    /// A state could not be corrected.
    #[error(transparent)]
    Register(#[from] bendtwin_register::Error),
    /// The picture could not be drawn.
    #[error("the picture could not be drawn: {0}")]
    Picture(String),
}

impl From<bendtwin_picture::Error> for Error {
    fn from(error: bendtwin_picture::Error) -> Self {
        Self::Picture(error.to_string())
    }
}

impl Problem for Error {
    fn category(&self) -> Category {
        match self {
            Self::Mismatch(_) | Self::Inconsistent(_) => Category::InvalidArgument,
            Self::Backend(e) => e.category(),
            Self::Register(e) => e.category(),
            Self::Picture(_) => Category::Internal,
        }
    }

    fn reason(&self) -> &'static str {
        match self {
            Self::Mismatch(_) => "TWIN_DOES_NOT_FIT_CAPTURE",
            Self::Inconsistent(_) => "CAPTURE_INCONSISTENT",
            Self::Backend(e) => e.reason(),
            Self::Register(e) => e.reason(),
            Self::Picture(_) => "PICTURE_FAILED",
        }
    }
}
