//! Runs on the device: frames forward, gradients backward, objectives, optimizer steps, and the
//! backend itself.

pub(crate) mod backend;
pub(crate) mod backward;
mod clearance;
mod contact;
mod gradient;
pub(crate) mod group;
pub(crate) mod objective;
pub(crate) mod optimizer;
pub(crate) mod outputs;
pub(crate) mod scoring;
pub(crate) mod simulation;
pub(crate) mod skin;
mod start;
mod states;
mod world;
