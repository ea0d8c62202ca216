//! The physics: graph building, the [`Backend`] trait, the CPU backend that
//! defines what is correct, its hand-written adjoint, and the conformance suite
//! that every backend must pass. Knows no network, no files, and of
//! fitting only how to take a step downhill ([`descent`]).

pub mod backend;
pub mod build;
pub mod conformance;
pub mod constants;
mod cpu;
pub mod descent;
mod energy;
pub mod fidelity;
pub mod model;
pub mod objective;
pub mod reference;
mod stability;

pub use backend::{Backend, Device, Error, Loaded};
pub use cpu::{CpuBackend, check, cpu, cpu_with_threads};
pub use energy::{Energy, energy};
pub use model::Model;
pub use objective::{Objective, PointLoss, Term};
pub use stability::{StableSubsteps, enough_substeps, stable_substeps};
