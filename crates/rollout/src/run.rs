//! The simulations of a request: planned, and carried out on a backend.

pub(crate) mod execute;
mod mean;
pub(crate) mod plan;
pub(crate) mod replay;
pub(crate) mod settle;
mod spans;
