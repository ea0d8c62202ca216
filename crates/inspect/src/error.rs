//! Errors: reasons for which a recording cannot be inspected at all. Faults of one that can are
//! findings, not errors.

use bendtwin_core::{Category, Problem};

/// The reason for which there is no report.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// Stopped on request.
    #[error("the inspection was cancelled")]
    Cancelled,
    /// The recording could not be opened.
    #[error(transparent)]
    Capture(#[from] bendtwin_capture::Error),
    /// A document is no report, or of a newer version.
    #[error("this is no capture report that can be read: {0}; write it again with this version")]
    Document(String),
}

impl Problem for Error {
    fn category(&self) -> Category {
        match self {
            Self::Cancelled => Category::Cancelled,
            Self::Capture(e) => e.category(),
            Self::Document(_) => Category::InvalidArgument,
        }
    }

    fn reason(&self) -> &'static str {
        match self {
            Self::Cancelled => "CANCELLED",
            Self::Capture(e) => e.reason(),
            Self::Document(_) => "INVALID_REPORT",
        }
    }
}
