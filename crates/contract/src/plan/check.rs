//! The check of a request for a plan, and what it leaves of it.

use bendtwin_plan::{Movement, Settings};
use bendtwin_proto::v1::{PlanRequest, Returns, RollOutRequest, initial_state::State};

use super::{
    Error, GraspPlaces, Template,
    places::{check_open, places},
    settings::settings,
    space, template,
};
use crate::rollout::{
    self, Batch, Limits, SessionParts, TwinShape,
    tensors::{floats, indices},
    within,
};

/// Most plans that are simulated for one: their costs are kept.
pub const MOST_PLANS: u64 = 1_000_000;
/// Copies of a plan's knots that a planner holds together, and of its actions in transit.
const KNOTS: usize = 8;
const ACTIONS: usize = 4;
/// Arrays of the size of a plan that the search of a place keeps, by coordinate and by displacement.
const PLACE: usize = 12;

/// A request for a plan that has passed the check.
#[derive(Clone, Debug)]
pub struct Checked {
    /// The rollout to minimize.
    pub template: Template,
    /// Settings of the planner.
    pub settings: Settings,
    /// Coordinates, by what they move.
    pub movement: Movement,
    /// The place that coordinates are counted from, shape [C, 3] or [G, 7]; none: row 0 of the nominal plan.
    pub start: Option<Vec<f64>>,
    /// The nominal plan as actions, shape [K, C, 3] or [K, G, 7].
    pub nominal: Vec<f64>,
    /// Frames that were executed since it was made.
    pub shift_frames: f64,
    /// Places to grasp that are searched; none: the plan begins where the nominal plan does.
    pub places: Option<GraspPlaces>,
    /// Memory of the plans of a batch, and of the planner [bytes].
    pub bytes: u64,
}

impl Checked {
    /// The rollout of the first frames of a plan, up to the horizon: the same motion, without what
    /// belongs to the search. Its actions are the nominal plan, until others
    /// [take their place](Template::put).
    pub fn first_frames(&self, frames: u32, returns: Option<Returns>) -> RollOutRequest {
        let Settings { knots, frames: horizon, frame_s, .. } = self.settings;
        let between_s = horizon as f64 * frame_s / (knots.max(2) - 1) as f64;
        self.template.first_frames(&self.nominal, frames, between_s, returns)
    }
}

/// Checks a request for a twin with `frame_s` seconds a frame, whose rollout may be in a session
/// with other surroundings.
///
/// # Errors
/// The first fault that is found; those of the rollout come first.
pub fn check(
    request: PlanRequest,
    session: SessionParts,
    twin: &TwinShape,
    frame_s: f64,
    limits: &Limits,
) -> Result<Checked, Error> {
    let missing = || Error::field("rollout", "is missing: say what to minimize");
    let of = request.rollout.as_ref().ok_or_else(missing)?;
    let one = rollout::check_in(of, session, twin, limits, 0).map_err(Error::of_rollout)?;
    if one.instances != 1 {
        let fault = format!("has {} instances: give the nominal plan alone", one.instances);
        return Err(Error::field("rollout.actions", fault));
    }
    if of.costs.is_empty() {
        return Err(Error::field("rollout.costs", "is empty: say what to minimize"));
    }
    if !(request.shift_frames >= 0.0 && request.shift_frames.is_finite()) {
        let fault = format!("is {}: it must be 0 or more, and finite", request.shift_frames);
        return Err(Error::field("shift_frames", fault));
    }
    let (Some(actions), Some(tensor)) = (&of.actions, template::actions(of)) else {
        return Err(Error::field("rollout.actions", "are missing"));
    };
    let [points, width] = [2, 3].map(|i| tensor.shape.get(i).map_or(0, |d| *d as usize));
    let space = request.space.clone().unwrap_or_default();
    let movement = space::movement(&space, actions, points)?;
    let start = space::start(&space, points, width)?;
    let search = request.grasp_search.as_ref();
    let places = search.map(|search| places(search, of, points)).transpose()?;
    if let Some(places) = &places {
        check_open(places, of, &given_phases(of))?;
    }
    let count = places.as_ref().map_or(1, GraspPlaces::count);
    let settings = settings(&request, of, &one, dims(&movement, points), frame_s, count)?;
    let nominal = floats(tensor).map(f64::from).collect();
    let shift_frames = request.shift_frames;
    let template = Template::new(request.rollout.unwrap_or_default(), places.as_ref());
    let batch = largest(&one, &settings)?;
    let gradients = settings.method.needs_gradients();
    template
        .check(&batch, settings.iterations as u64, gradients, twin, limits)
        .map_err(Error::of_rollout)?;
    let plan = (8 * KNOTS * settings.knots).saturating_mul(settings.dims)
        + template.row_bytes().saturating_mul(ACTIONS);
    let place = (8 * PLACE * settings.knots).saturating_mul(settings.dims + 6 * points);
    let bytes = batch.instances.saturating_mul(plan as u64);
    let bytes = bytes.saturating_add((count as u64).saturating_mul(place as u64));
    Ok(Checked { template, settings, movement, start, nominal, shift_frames, places, bytes })
}

/// Phases of the grasps in a given state; empty where they are not given.
fn given_phases(rollout: &RollOutRequest) -> Vec<u32> {
    let state = rollout.initial.as_ref().and_then(|initial| initial.state.as_ref());
    let Some(State::Given(given)) = state else { return Vec::new() };
    let phases = given.grasping.as_ref().and_then(|grasping| grasping.phases.as_ref());
    phases.map_or_else(Vec::new, |phases| indices(phases).collect())
}

/// Number of coordinates of a knot.
fn dims(movement: &Movement, points: usize) -> usize {
    match movement {
        Movement::Points(groups) => 3 * (groups.iter().max().map_or(0, |last| last + 1)),
        Movement::Translation => 3 * points,
        Movement::Rigid => 6 * points,
    }
}

/// The largest batch of a plan: its samples, among them the nominal plan and the one to stay still.
fn largest(one: &Batch, settings: &Settings) -> Result<Batch, Error> {
    let least = if settings.method.needs_gradients() { 1 } else { 3 };
    let instances = settings.samples.max(least) as u64;
    within(
        "the number of plans (samples x iterations)",
        u128::from(instances) * settings.iterations as u128,
        MOST_PLANS,
        "use fewer samples or iterations",
    )?;
    Ok(Batch { instances, ..*one })
}
