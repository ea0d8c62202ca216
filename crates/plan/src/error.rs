//! Errors of planners.

/// Settings that no planner can work with.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{field}: {problem}")]
pub struct Invalid {
    /// Name of the setting.
    pub field: &'static str,
    /// The fault, and what to give instead.
    pub problem: String,
}

impl Invalid {
    pub(crate) fn new(field: &'static str, problem: impl Into<String>) -> Self {
        Self { field, problem: problem.into() }
    }
}

/// Planning that came to nothing.
#[derive(Debug, thiserror::Error)]
pub enum Error<E> {
    /// No plan of the first iteration could be simulated to its end.
    #[error(
        "every plan diverged: lower sigma, bound the speed or shorten the horizon, and see that the \
         plan begins where the control points are"
    )]
    EveryPlanDiverged,
    /// Costs or gradients of another shape than the batch's.
    #[error("a batch of {plans} plans was answered with {costs} costs and {gradients} gradients")]
    Shape {
        /// Plans of the batch.
        plans: usize,
        /// Costs of the answer.
        costs: usize,
        /// Gradients of the answer that have the shape of a plan.
        gradients: usize,
    },
    /// The nominal plan does not have the planner's shape, or is not finite.
    #[error(transparent)]
    Invalid(#[from] Invalid),
    /// The simulation failed.
    #[error("{0}")]
    Evaluate(E),
}
