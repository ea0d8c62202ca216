//! Reasons to refuse a registration or a correction.

use bendtwin_core::Problem;

use crate::rollout;

/// Reason to refuse a registration or a correction before anything is computed.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error, Problem)]
pub enum Error {
    /// A field of the observation or of the options is wrong.
    #[error("{0}")]
    #[problem(InvalidArgument, "INVALID_OBSERVATION")]
    Observation(rollout::Error),
    /// A fault of the parts that a rollout has as well: initial state, world, work or memory.
    #[error(transparent)]
    Rollout(#[from] rollout::Error),
}

impl Error {
    /// A wrong field.
    pub fn field(field: impl Into<String>, fault: impl Into<String>) -> Self {
        Self::Observation(rollout::Error::field(field, fault))
    }
}
