//! Rules of a plan that server and clients share: the check of a request against the limits of
//! rollouts and a twin's shape, which leaves what a planner needs. A plan is bounded by the same
//! limits: its largest batch as one rollout, and all its batches together by the work of one.

mod check;
mod error;
mod places;
mod settings;
mod space;
mod template;

pub use self::{
    check::{Checked, MOST_PLANS, check},
    error::Error,
    places::{GraspPlaces, MOST_PLACES, check_open},
    template::{Force, Template},
};
