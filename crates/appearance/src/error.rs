//! Errors of appearance.

use bendtwin_core::{Category, Problem};

/// The reason for which an appearance cannot be made or measured.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Error {
    /// Gaussians cannot be drawn.
    #[error(transparent)]
    Splat(#[from] bendtwin_splat::Error),
    /// A picture cannot be drawn or written.
    #[error(transparent)]
    Picture(#[from] bendtwin_picture::Error),
    /// No device to draw with.
    #[error("{0}")]
    Device(String),
    /// Images cannot be compared.
    #[error("a rendering cannot be compared with its view: {0}")]
    Compare(String),
    /// No view shows the object in a frame that may be used.
    #[error("no camera that may be used sees the object in the training frames")]
    NoViews,
    /// A checkpoint that is damaged or of another training.
    #[error("the checkpoint of the training of Gaussians cannot be read: {0}")]
    Checkpoint(String),
}

impl Problem for Error {
    fn category(&self) -> Category {
        match self {
            Self::Splat(error) => error.category(),
            Self::Picture(error) => error.category(),
            Self::Compare(_) | Self::Device(_) => Category::Internal,
            Self::NoViews | Self::Checkpoint(_) => Category::FailedPrecondition,
        }
    }

    fn reason(&self) -> &'static str {
        match self {
            Self::Splat(error) => error.reason(),
            Self::Picture(error) => error.reason(),
            Self::Device(_) => "DEVICE_FAILED",
            Self::Compare(_) => "APPEARANCE_NOT_MEASURED",
            Self::NoViews => "APPEARANCE_NOT_SEEN",
            Self::Checkpoint(_) => "CHECKPOINT_UNREADABLE",
        }
    }
}
