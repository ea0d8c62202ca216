//! Why a recording cannot be inspected at all. What is wrong with one that can is a finding, not an error.

use bendtwin_core::{Category, Problem};

/// Why there is no report.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// Somebody asked to stop.
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
