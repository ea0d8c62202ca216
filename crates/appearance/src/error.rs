//! Errors of appearance.

use bendtwin_core::Problem;

/// The reason for which an appearance cannot be made or measured.
#[derive(Clone, Debug, PartialEq, thiserror::Error, Problem)]
pub enum Error {
    /// Gaussians cannot be drawn.
    #[error(transparent)]
    Splat(#[from] bendtwin_splat::Error),
    /// A picture cannot be drawn or written.
    #[error(transparent)]
    Picture(#[from] bendtwin_picture::Error),
    /// No device to draw with.
    #[error("{0}")]
    #[problem(Internal, "DEVICE_FAILED")]
    Device(String),
    /// Images cannot be compared.
    #[error("a rendering cannot be compared with its view: {0}")]
    #[problem(Internal, "APPEARANCE_NOT_MEASURED")]
    Compare(String),
    /// No view shows the object in a frame that may be used.
    #[error("no camera that may be used sees the object in the training frames")]
    #[problem(FailedPrecondition, "APPEARANCE_NOT_SEEN")]
    NoViews,
    /// A checkpoint that is damaged or of another training.
    #[error("the checkpoint of the training of Gaussians cannot be read: {0}")]
    #[problem(FailedPrecondition, "CHECKPOINT_UNREADABLE")]
    Checkpoint(String),
}
