//! Rules of the contract that server, workers and clients share: what a rollout, a plan, a
//! registration and pictures may ask for, what they cost, and whose key a worker shows. Messages themselves are
//! in `bendtwin_proto`, which is not rebuilt when a rule changes; transport is left to the callers.

pub mod picture;
pub mod plan;
pub mod registration;
pub mod rollout;
pub mod worker_key;
