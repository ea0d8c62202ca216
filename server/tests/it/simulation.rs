//! Calls that a worker answers from a loaded twin: rollouts, plans, registrations, evaluations, sessions
//! and steps of closed loops, by one worker or several.

mod evaluations;
mod pictures;
mod places;
mod plans;
mod registrations;
pub(crate) mod rollouts;
mod sessions;
mod sharing;
mod steps;
mod streams;
