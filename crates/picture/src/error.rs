//! Errors of drawing.

use bendtwin_core::Problem;

/// The reason for which a picture cannot be drawn.
#[derive(Clone, Debug, PartialEq, thiserror::Error, Problem)]
#[problem(Internal, "PICTURE_FAILED")]
pub enum Error {
    /// No memory can hold it, or it is empty.
    #[error("a picture of {width} x {height} pixels cannot be drawn")]
    Size {
        /// Columns.
        width: f32,
        /// Rows.
        height: f32,
    },
    /// The encoder failed.
    #[error("the PNG encoder failed: {0}")]
    Encoding(String),
    /// The file cannot be written: the disk is full, for example.
    #[error("the picture cannot be written: {0}; free disk space or choose another folder")]
    #[problem(ResourceExhausted, "PICTURE_NOT_WRITTEN")]
    Write(String),
}
