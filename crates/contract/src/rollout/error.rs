//! Reasons to refuse a request.

use bendtwin_core::{Category, Problem};
use bendtwin_proto::tensor::TensorError;

/// Reason to refuse a rollout request.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Error {
    /// A field is wrong.
    #[error("`{field}` {fault}")]
    Field {
        /// Path of the field in the request, `costs[0].weight` say.
        field: String,
        /// The fault, and what to do.
        fault: String,
    },
    /// The request exceeds one of the [`Limits`](super::Limits).
    #[error("{what} would be {asked}, the most for one request is {limit}: {advice}")]
    TooLarge {
        /// Quantity that is too large.
        what: &'static str,
        /// Quantity asked for.
        asked: u64,
        /// Largest quantity that is allowed.
        limit: u64,
        /// Advice on what to do.
        advice: &'static str,
    },
    /// The twin has no fast variant.
    #[error(
        "{twin} has no fast variant, as it was made before there were any or diverged where that is measured: fit its capture again, or ask for EXACT"
    )]
    NoFastVariant {
        /// twins/{uuid}
        twin: String,
    },
    /// The twin has no planner's twin.
    #[error(
        "{twin} has no planner's twin: make one with `bendtwin twin planner`, fit its capture with planner.nodes, or ask for FAST or EXACT"
    )]
    NoPlannersTwin {
        /// twins/{uuid}
        twin: String,
    },
}

impl Error {
    /// A wrong field.
    pub fn field(field: impl Into<String>, fault: impl Into<String>) -> Self {
        Self::Field { field: field.into(), fault: fault.into() }
    }
}

impl From<TensorError> for Error {
    fn from(TensorError { name, fault }: TensorError) -> Self {
        Self::Field { field: name, fault }
    }
}

impl Problem for Error {
    fn category(&self) -> Category {
        match self {
            // Sent again, it would be refused again: so it is not RESOURCE_EXHAUSTED.
            Self::Field { .. } | Self::TooLarge { .. } => Category::InvalidArgument,
            Self::NoFastVariant { .. } | Self::NoPlannersTwin { .. } => {
                Category::FailedPrecondition
            }
        }
    }
    fn reason(&self) -> &'static str {
        match self {
            Self::Field { .. } => "INVALID_ROLLOUT",
            Self::TooLarge { .. } => "ROLLOUT_TOO_LARGE",
            Self::NoFastVariant { .. } => "FAST_VARIANT_UNKNOWN",
            Self::NoPlannersTwin { .. } => "PLANNERS_TWIN_UNKNOWN",
        }
    }
}
