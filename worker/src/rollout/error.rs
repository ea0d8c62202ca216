//! Why a call to this worker is refused or fails: what the work itself says, or what the worker lacks.

use bendtwin_budget::Exhausted;
use bendtwin_contract::{registration, rollout as contract};
use bendtwin_core::{Category, Problem, twin::format::FormatError};
use bendtwin_engine::backend;

use crate::{artifact::FetchError, budget::is_passing};

/// Reason why a call is refused or fails.
#[derive(Debug, thiserror::Error)]
pub(crate) enum Error {
    /// The work is refused or fails.
    #[error(transparent)]
    Rollout(#[from] bendtwin_rollout::Error),
    /// As many rollouts as this worker takes are in flight.
    #[error("{limit} rollouts are in flight on this worker: try again in a moment")]
    Busy {
        /// Number of rollouts that it takes.
        limit: usize,
    },
    /// There is no memory for it.
    #[error("{exhausted}, for {purpose}{}", if is_passing(.exhausted) { ", or retry" } else { "" })]
    Memory {
        /// Purpose of the memory, and advice.
        purpose: &'static str,
        /// The refusal.
        exhausted: Exhausted,
    },
    /// Twin or capture cannot be fetched.
    #[error(transparent)]
    Fetch(#[from] FetchError),
    /// The stored twin cannot be read.
    #[error("the stored twin cannot be used: {0}")]
    StoredTwin(FormatError),
    /// The caller's deadline passed.
    #[error(
        "the deadline passed while the rollout ran: give it more time, fewer instances or a shorter horizon"
    )]
    Deadline,
    /// The thread that served the request ended in a panic.
    #[error("the rollout failed for a reason inside the worker")]
    Panicked,
}

impl Error {
    /// A wrong field.
    pub(super) fn field(field: impl Into<String>, fault: impl Into<String>) -> Self {
        bendtwin_rollout::Error::field(field, fault).into()
    }
}

impl From<contract::Error> for Error {
    fn from(error: contract::Error) -> Self {
        Self::Rollout(error.into())
    }
}

impl From<registration::Error> for Error {
    fn from(error: registration::Error) -> Self {
        Self::Rollout(error.into())
    }
}

impl From<backend::Error> for Error {
    fn from(error: backend::Error) -> Self {
        Self::Rollout(error.into())
    }
}

impl Problem for Error {
    fn category(&self) -> Category {
        match self {
            Self::Rollout(e) => e.category(),
            // Sent again, it would be refused again.
            Self::Memory { exhausted: Exhausted::TooLarge { .. }, .. } => Category::InvalidArgument,
            Self::Busy { .. } | Self::Memory { .. } => Category::ResourceExhausted,
            Self::Fetch(e) => e.category(),
            Self::StoredTwin(_) => Category::DataLoss,
            Self::Deadline => Category::DeadlineExceeded,
            Self::Panicked => Category::Internal,
        }
    }
    fn reason(&self) -> &'static str {
        match self {
            Self::Rollout(e) => e.reason(),
            Self::Busy { .. } => "WORKER_BUSY",
            Self::Memory { exhausted: Exhausted::TooLarge { .. }, .. } => "MEMORY_TOO_SMALL",
            Self::Memory { .. } => "MEMORY_IN_USE",
            Self::Fetch(e) => e.reason(),
            Self::StoredTwin(_) => "TWIN_DAMAGED",
            Self::Deadline => "DEADLINE_EXCEEDED",
            Self::Panicked => "WORKER_PANICKED",
        }
    }
}
