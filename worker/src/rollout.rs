//! Rollouts as a service: calls of the server, the twins and captures that they need, their memory and
//! their turn at the device. The computation is `bendtwin_rollout`.

mod error;
mod evaluate;
mod lru;
mod register;
mod replay;
mod service;
mod sessions;
mod status;
mod warm;

pub(crate) use self::{
    error::Error,
    replay::Replays,
    service::{Rollouts, serve},
    status::StatusGuard,
    warm::WarmTwins,
};

#[cfg(test)]
mod tests;
