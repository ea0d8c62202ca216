//! Planners that lower a cost by simulating batches of plans. The cost is an abstract [`Evaluate`];
//! twins, networks and clocks are left to the caller.
//!
//! A plan is knots, shape [K, D], spread evenly over a horizon ([`Curve`]); row 0 says where things
//! are and stays. A [`Planner`] keeps the plan of last time, [shifts](Planner::shift) it by what was
//! executed, and betters it by one of four [methods](Method). It never returns knots that were not
//! simulated, hence never a plan that is worse than the one that it began with: the mean of good
//! samples can be bad. A [`PlaceSearch`] makes plans that begin at several places, and takes the best.
//!
//! `bendtwin.planners` of the Python client has the same mathematics.

mod bounds;
mod curve;
mod error;
mod method;
mod noise;
mod places;
mod planner;
mod rotation;
mod search;
mod settings;
mod space;

pub use self::{
    bounds::{Bounds, Limit},
    curve::Curve,
    error::{Error, Invalid},
    method::Method,
    places::{PlaceSearch, check_places, rounds},
    planner::{Evaluate, Planner},
    search::{Evaluation, Origin, Plan, Progress, Search},
    settings::Settings,
    space::{Movement, Space},
};

/// Knots of a plan, shape [K, D], row-major.
pub type Knots = Vec<f64>;
