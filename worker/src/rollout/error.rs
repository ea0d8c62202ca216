//! Why a rollout is refused or fails.

use bendtwin_core::{Category, Problem, ids::TwinId, twin::format::FormatError};
use bendtwin_engine::backend;
use bendtwin_proto::tensor::TensorError;

use crate::artifact::FetchError;

/// Why a rollout is refused or fails.
#[derive(Debug, thiserror::Error)]
pub(crate) enum Error {
    /// A field is wrong.
    #[error("{field}: {fault}")]
    Field {
        /// Path of the field in the request.
        field: String,
        /// What is wrong with it and what to do.
        fault: String,
    },
    /// A tensor is malformed.
    #[error(transparent)]
    Tensor(#[from] TensorError),
    /// It exceeds what one request may take.
    #[error("{what} would be {asked}, the most for one request is {limit}: {advice}")]
    TooLarge {
        /// What is too large.
        what: &'static str,
        /// How much was asked for.
        asked: u128,
        /// How much there may be.
        limit: u128,
        /// What to do.
        advice: &'static str,
    },
    /// As many rollouts as this worker takes are in flight.
    #[error("{limit} rollouts are in flight on this worker: try again in a moment")]
    Busy {
        /// How many it takes.
        limit: usize,
    },
    /// Twin or capture cannot be fetched.
    #[error(transparent)]
    Fetch(#[from] FetchError),
    /// The stored twin cannot be read.
    #[error("the stored twin cannot be used: {0}")]
    StoredTwin(FormatError),
    /// The twin has no fast variant.
    #[error(
        "{twin} has no fast variant, as it was made before there were any or diverged where that is measured: fit its capture again, or ask for EXACT"
    )]
    NoFastVariant {
        /// The twin.
        twin: TwinId,
    },
    /// The capture cannot be replayed.
    #[error("the capture cannot be replayed with this twin: {0}")]
    Capture(String),
    /// The replay of the capture left the finite numbers.
    #[error(
        "the twin diverges in frame {frame} of the capture's replay: start at an earlier frame"
    )]
    ReplayDiverged {
        /// Frame of the capture.
        frame: usize,
    },
    /// The engine refuses or fails.
    #[error(transparent)]
    Engine(#[from] backend::Error),
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
        Self::Field { field: field.into(), fault: fault.into() }
    }
}

impl Problem for Error {
    fn category(&self) -> Category {
        match self {
            Self::Field { .. } | Self::Tensor(_) => Category::InvalidArgument,
            Self::TooLarge { .. } | Self::Busy { .. } => Category::ResourceExhausted,
            Self::Fetch(e) => e.category(),
            Self::StoredTwin(_) => Category::DataLoss,
            Self::NoFastVariant { .. } | Self::Capture(_) | Self::ReplayDiverged { .. } => {
                Category::FailedPrecondition
            }
            Self::Engine(e) => e.category(),
            Self::Deadline => Category::DeadlineExceeded,
            Self::Panicked => Category::Internal,
        }
    }
    fn reason(&self) -> &'static str {
        match self {
            Self::Field { .. } => "INVALID_ROLLOUT",
            Self::Tensor(_) => "INVALID_TENSOR",
            Self::TooLarge { .. } => "ROLLOUT_TOO_LARGE",
            Self::Busy { .. } => "WORKER_BUSY",
            Self::Fetch(e) => e.reason(),
            Self::StoredTwin(_) => "TWIN_DAMAGED",
            Self::NoFastVariant { .. } => "FAST_VARIANT_UNKNOWN",
            Self::Capture(_) => "CAPTURE_NOT_REPLAYABLE",
            Self::ReplayDiverged { .. } => "REPLAY_DIVERGED",
            Self::Engine(e) => e.reason(),
            Self::Deadline => "DEADLINE_EXCEEDED",
            Self::Panicked => "WORKER_PANICKED",
        }
    }
}
