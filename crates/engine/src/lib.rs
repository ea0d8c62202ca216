//! The physics: the [`Backend`] trait, the CPU backend that defines what is correct, and its
//! hand-written adjoint. It uses no network and no files; of fitting it has only the gradient steps
//! ([`optimizer`]). `tests/kits/engine` has the conformance suite that every backend must pass.

pub mod backend;
pub mod constants;
mod cpu;
mod energy;
pub mod fidelity;
pub mod model;
pub mod objective;
pub mod optimizer;
pub mod planner;
pub mod reference;
mod stability;
pub mod world;

pub use backend::{Backend, Device, Error, Loaded};
pub use cpu::{CpuBackend, Gauge, PathGradient, check, cpu, cpu_with_threads};
pub use energy::{Energies, Energy, energy};
pub use model::Model;
pub use objective::{Objective, PointLoss, PointSet, Term};
pub use stability::{StableSubsteps, enough_substeps, stable_substeps};
pub use world::{Motion, World};
