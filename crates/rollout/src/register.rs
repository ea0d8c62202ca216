//! Registrations: points that were seen in, a state of the twin out. The geometry is computed here;
//! the frames of physics that belong to it run on the backend like a rollout's.

use bendtwin_core::{CancelToken, Point};
use bendtwin_engine::{Backend, Loaded, model::State};
use bendtwin_proto::v1::{
    self, RegisterStateRequest, RegisteredState, Tensor, initial_state::GivenState,
};
use bendtwin_register::{Around, RegisterOptions, Registered, register};

use crate::{
    error::Error,
    observation,
    request::{
        initial::Start,
        vary::{Base, Variants},
    },
    session::correct::grippers,
    twin::warm::Warm,
    world::{Still, Surroundings},
};

/// The state of a twin that a checked registration finds, from a state to begin with.
///
/// # Errors
/// If a tensor is not what the check saw, the twin does not explain the observation, or the backend
/// fails.
pub fn register_state(
    warm: &Warm,
    start: Start,
    request: RegisterStateRequest,
    backend: &dyn Backend,
    cancel: &CancelToken,
) -> Result<RegisteredState, Error> {
    let loaded = surrounded(warm, request.world.as_ref(), backend, cancel)?;
    let grippers = grippers(request.grippers.as_ref(), "grippers")?;
    let around = Still::among(request.world.as_ref(), &grippers)?.around_now();
    let seen = observation::read(request.observation, &warm.twin.graph)?;
    let controls = observation::points(request.controls, "controls")?;
    let wire = request.options.unwrap_or_default();
    let options = RegisterOptions { around, ..options(wire, start, controls) };
    let registered = register(backend, &loaded, &seen, &options, cancel)?;
    Ok(message(&registered, warm.twin.graph.rods.len()))
}

/// The twin's model with the ground and the gravity of a world.
fn surrounded(
    warm: &Warm,
    world: Option<&v1::World>,
    backend: &dyn Backend,
    cancel: &CancelToken,
) -> Result<Loaded, Error> {
    let Some(world) = world else { return Ok(warm.loaded.clone()) };
    let surroundings = Surroundings::without_bodies(world);
    let base = Base::own(&warm.loaded);
    let variants = Variants::load(None, &base, &surroundings, backend, cancel)?;
    Ok(variants.of(0).loaded.clone())
}

fn options(wire: v1::RegisterOptions, start: Start, controls: Vec<Point>) -> RegisterOptions {
    let default = RegisterOptions::default();
    // Grasps belong to a rollout.
    let state = State { grasping: Default::default(), ..State::clone(&start.state) };
    let start_controls = start.likely.unwrap_or(start.controls);
    RegisterOptions {
        initial: Some((state, Vec::clone(&start_controls))),
        controls,
        held: Vec::new(),
        around: Around::default(),
        near: wire.near,
        noise_m: wire.noise_m.unwrap_or(default.noise_m),
        give: wire.give.unwrap_or(default.give),
        settle_frames: wire.settle_frames.map_or(default.settle_frames, |frames| frames as usize),
        max_residual_m: wire.max_residual_m,
        least_explained: wire.least_explained.unwrap_or(default.least_explained),
    }
}

fn message(registered: &Registered, rods: usize) -> RegisteredState {
    let state = &registered.state;
    let points = |points: &[Point]| Some(Tensor::pack_points(&[points.len()], points));
    let mut twists = state.twists.clone();
    twists.resize(rods, 0.0);
    RegisteredState {
        state: Some(GivenState {
            positions: points(&state.positions),
            velocities: points(&state.velocities),
            twists: (rods > 0).then(|| Tensor::pack(&[rods], &twists)),
            controls: points(&registered.controls),
            ..GivenState::default()
        }),
        before: Some(observation::residual(registered.before)),
        after: Some(observation::residual(registered.residual)),
        explained: Some(observation::explained(registered.explained)),
        motion: registered.rigid.pose().to_vec(),
        drift_mm: registered.drift_mm,
        ..RegisteredState::default()
    }
}
