//! The physics: graph building, the [`Backend`] trait, the CPU backend that
//! defines what is correct, its hand-written adjoint, and the conformance suite
//! that every backend must pass. Knows no network, no files, no optimiser.

pub mod backend;
pub mod build;
pub mod model;
pub mod objective;

pub use backend::{Backend, Device, Error, Loaded};
pub use model::Model;
pub use objective::{Objective, PointLoss, Term};
