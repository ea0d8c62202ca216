//! Reasons for which a call to this worker is refused or fails: those of the work itself, and resources that the
//! worker lacks.

use std::str::FromStr;

use bendtwin_budget::Exhausted;
use bendtwin_contract::{picture, registration, rollout as contract};
use bendtwin_core::{Problem, ids::InvalidName, twin::format::FormatError};
use bendtwin_engine::backend;

use crate::artifact::FetchError;

/// Reason why a call is refused or fails.
#[derive(Debug, thiserror::Error, Problem)]
pub(crate) enum Error {
    /// The work is refused or fails.
    #[error(transparent)]
    Rollout(#[from] bendtwin_rollout::Error),
    /// The limit of rollouts in flight on this worker is reached.
    #[error("{limit} rollouts are in flight on this worker: try again in a moment")]
    #[problem(ResourceExhausted, "WORKER_BUSY")]
    Busy {
        /// Number of rollouts that it takes.
        limit: usize,
    },
    /// Not enough memory.
    #[error("{exhausted}, for {purpose}{}", if .exhausted.is_passing() { ", or retry" } else { "" })]
    #[problem(ResourceExhausted, "MEMORY_IN_USE", if exhausted.is_passing())]
    // Sent again, it would be refused again.
    #[problem(InvalidArgument, "MEMORY_TOO_SMALL")]
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
    #[problem(DataLoss, "TWIN_DAMAGED")]
    StoredTwin(FormatError),
    /// The caller's deadline passed.
    #[error(
        "the deadline passed while the rollout ran: give it more time, fewer instances or a shorter horizon"
    )]
    #[problem(DeadlineExceeded, "DEADLINE_EXCEEDED")]
    Deadline,
    /// The thread that served the request ended in a panic.
    #[error("the rollout failed for a reason inside the worker")]
    #[problem(Internal, "WORKER_PANICKED")]
    Panicked,
}

impl Error {
    /// A wrong field.
    pub(super) fn field(field: impl Into<String>, fault: impl Into<String>) -> Self {
        bendtwin_rollout::Error::field(field, fault).into()
    }

    /// The resource that a field names.
    pub(super) fn parsed<T: FromStr<Err = InvalidName>>(
        field: &str,
        name: &str,
    ) -> Result<T, Self> {
        name.parse().map_err(|e: InvalidName| Self::field(field, e.to_string()))
    }
}

impl From<contract::Error> for Error {
    fn from(error: contract::Error) -> Self {
        Self::Rollout(error.into())
    }
}

impl From<picture::Error> for Error {
    fn from(error: picture::Error) -> Self {
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
