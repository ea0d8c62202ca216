//! Errors: reasons for which a recording cannot be inspected at all. Faults of one that can are
//! findings, not errors.

use bendtwin_core::Problem;

/// The reason for which there is no report.
#[derive(Debug, thiserror::Error, Problem)]
pub enum Error {
    /// Stopped on request.
    #[error("the inspection was cancelled")]
    #[problem(Cancelled, "CANCELLED")]
    Cancelled,
    /// The recording could not be opened.
    #[error(transparent)]
    Capture(#[from] bendtwin_capture::Error),
    /// A document is no report, or of a newer version.
    #[error("this is no capture report that can be read: {0}; write it again with this version")]
    #[problem(InvalidArgument, "INVALID_REPORT")]
    Document(String),
}
