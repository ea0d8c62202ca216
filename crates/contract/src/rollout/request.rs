//! The parts of a rollout request, a file for each: what it may hold, alone and beside a twin, and its
//! price.

pub(super) mod actions;
pub(super) mod costs;
pub(super) mod gradients;
pub(super) mod grasps;
pub(super) mod initial;
mod numbers;
pub(super) mod partial;
pub(super) mod plausibility;
pub(super) mod returns;
pub(crate) mod tensors;
pub(super) mod times;
pub(super) mod vary;
pub(crate) mod world;

pub(crate) use self::numbers::SHORTEST_QUATERNION;
use super::{
    Error, Limits, TwinShape,
    check::{Batch, Grippers, Moves, within},
    message::Message,
    price::{Asked, Price, mul, sum},
};
