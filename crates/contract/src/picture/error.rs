//! Reasons to refuse pictures.

use bendtwin_core::Problem;

use crate::rollout;

/// Reason to refuse pictures before anything is drawn.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error, Problem)]
pub enum Error {
    /// A field of a camera, a prop or the light is wrong.
    #[error("{0}")]
    #[problem(InvalidArgument, "INVALID_PICTURE")]
    Picture(rollout::Error),
    /// More is asked for than one request may have.
    #[error(transparent)]
    Size(rollout::Error),
}

impl Error {
    /// A wrong field.
    pub fn field(field: impl Into<String>, fault: impl Into<String>) -> Self {
        Self::Picture(rollout::Error::field(field, fault))
    }
}

impl From<rollout::Error> for Error {
    fn from(error: rollout::Error) -> Self {
        match error {
            rollout::Error::TooLarge { .. } => Self::Size(error),
            other => Self::Picture(other),
        }
    }
}
