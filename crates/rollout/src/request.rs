//! The parts of a rollout request, from the message to what the engine takes.

pub(crate) mod actions;
pub(crate) mod checked;
pub(crate) mod costs;
pub(crate) mod ensemble;
pub(crate) mod grasping;
pub(crate) mod initial;
mod interpolate;
pub(crate) mod plausible;
pub(crate) mod quaternion;
mod recorded;
pub(crate) mod returns;
pub(crate) mod vary;
