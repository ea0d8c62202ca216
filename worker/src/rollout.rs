//! The rollout executor: turns requests into batches of engine instances on
//! the interactive lane of the device, and results into parts of a reply.

mod actions;
mod checked;
mod costs;
mod ensemble;
mod error;
mod evaluate;
mod execute;
mod grasping;
mod initial;
mod interpolate;
mod lru;
mod mean;
mod observation;
mod plan;
mod planner;
mod plausible;
mod quaternion;
mod recorded;
mod register;
mod replay;
mod reply;
mod rest_shape;
mod returns;
mod serve;
mod service;
mod sessions;
mod settle;
mod spans;
mod told;
mod vary;
mod warm;
mod world;

pub(crate) use self::{
    error::Error,
    replay::Replays,
    service::{Rollouts, serve},
    told::AtWork,
    warm::WarmTwins,
};

#[cfg(test)]
mod tests;
