//! Reasons to refuse a request.

use bendtwin_core::Problem;
use bendtwin_proto::tensor::TensorError;

/// Reason to refuse a rollout request.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error, Problem)]
pub enum Error {
    /// A field is wrong.
    #[error("`{field}` {fault}")]
    #[problem(InvalidArgument, "INVALID_ROLLOUT")]
    Field {
        /// Path of the field in the request, `costs[0].weight` say.
        field: String,
        /// The fault, and what to do.
        fault: String,
    },
    /// The request exceeds one of the [`Limits`](super::Limits).
    #[error("{what} would be {asked}, the most for one request is {limit}: {advice}")]
    // Sent again, it would be refused again: so it is not RESOURCE_EXHAUSTED.
    #[problem(InvalidArgument, "ROLLOUT_TOO_LARGE")]
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
    #[problem(FailedPrecondition, "FAST_VARIANT_UNKNOWN")]
    NoFastVariant {
        /// twins/{uuid}
        twin: String,
    },
    /// The twin has no planner's twin.
    #[error(
        "{twin} has no planner's twin: make one with `bendtwin twin planner`, fit its capture with planner.nodes, or ask for FAST or EXACT"
    )]
    #[problem(FailedPrecondition, "PLANNERS_TWIN_UNKNOWN")]
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
