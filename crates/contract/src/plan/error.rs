//! Reasons to refuse a request for a plan.

use bendtwin_core::Problem;
use bendtwin_plan::Invalid;
use bendtwin_proto::tensor::TensorError;

use crate::rollout;

/// Reason to refuse a request for a plan.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error, Problem)]
pub enum Error {
    /// A field is wrong.
    #[error("`{field}` {fault}")]
    #[problem(InvalidArgument, "INVALID_PLAN")]
    Field {
        /// Path of the field in the request, `bounds.low` say.
        field: String,
        /// The fault, and what to do.
        fault: String,
    },
    /// The rollout that is to be planned is wrong, or too large.
    #[error(transparent)]
    Rollout(rollout::Error),
}

impl Error {
    /// A wrong field.
    pub(super) fn field(field: impl Into<String>, fault: impl Into<String>) -> Self {
        Self::Field { field: field.into(), fault: fault.into() }
    }

    /// A fault of the rollout, whose fields are below the plan's.
    pub(super) fn of_rollout(error: rollout::Error) -> Self {
        Self::Rollout(match error {
            rollout::Error::Field { field, fault } => {
                rollout::Error::Field { field: format!("rollout.{field}"), fault }
            }
            other => other,
        })
    }
}

/// A fault that the checks of tensors found in a field of the plan.
impl From<rollout::Error> for Error {
    fn from(error: rollout::Error) -> Self {
        match error {
            rollout::Error::Field { field, fault } => Self::Field { field, fault },
            other => Self::Rollout(other),
        }
    }
}

impl From<TensorError> for Error {
    fn from(TensorError { name, fault }: TensorError) -> Self {
        Self::Field { field: name, fault }
    }
}

/// The planner names its settings, the request has some of them in messages.
impl From<Invalid> for Error {
    fn from(Invalid { field, problem }: Invalid) -> Self {
        let path = match field {
            "temperature" => "method.mppi.temperature",
            "elites" => "method.cem.elites",
            "memory" => "method.cem.memory",
            "smallest" => "method.cem.smallest",
            "rate" => "method.gradient.rate",
            "knot_times" => "rollout.knot_times",
            "frames" => "rollout.frames",
            other => other,
        };
        Self::field(path, problem)
    }
}
