//! Cases of what a backend promises for any physics: costs, gradients, batches, optimizers and refusals.

pub(crate) mod batches;
pub(crate) mod degenerate;
pub(crate) mod gradients;
pub(crate) mod objectives;
pub(crate) mod optimizer;
pub(crate) mod refusals;
pub(crate) mod tasks;
