//! Registrations: points that were seen in, a state of the twin out. The geometry is computed here;
//! the frames of physics that belong to it wait for their turn at the device like a rollout's.

use std::sync::Arc;

use bendtwin_contract::registration;
use bendtwin_core::{CancelToken, Point, ids::TwinId};
use bendtwin_engine::{Loaded, model::State};
use bendtwin_proto::{
    v1::{self, RegisterStateRequest, RegisteredState, Tensor, initial_state::GivenState},
    worker::v1::ExecuteRegisterStateRequest,
};
use bendtwin_register::{Around, RegisterOptions, Registered, register};

use super::{
    error::Error,
    initial::Start,
    observation,
    plan::shape,
    service::{Inner, Unary},
    sessions::correct::grippers,
    vary::{Base, Variants},
    warm::Warm,
    world::{Still, Surroundings},
};
use crate::{
    budget,
    device::{Priority, QueuedBackend},
};

/// A registration that has passed the check.
pub(super) struct Job {
    pub(super) warm: Arc<Warm>,
    pub(super) start: Start,
    pub(super) request: RegisterStateRequest,
    pub(super) backend: QueuedBackend,
}

impl Inner {
    /// Answers a registration.
    pub(super) async fn register(
        self: &Arc<Self>,
        request: ExecuteRegisterStateRequest,
        call: &Unary,
    ) -> Result<RegisteredState, Error> {
        let wire = request.request.ok_or_else(|| Error::field("request", "is missing"))?;
        let twin: TwinId = wire
            .twin
            .parse()
            .map_err(|e: bendtwin_core::ids::InvalidName| Error::field("twin", e.to_string()))?;
        let warm = self.twins.get(twin).await?;
        let shape = shape(&warm.twin, !request.capture.is_empty());
        registration::check_registration(&wire, &shape, &self.limits())?;
        // A simulation that comes before takes memory of its own, so it comes before this takes any.
        let begun = registration::begun(&wire);
        let starts = self.first_states(&warm, &begun, &request.capture, call.cancel()).await?;
        let start = starts.into_iter().next();
        let start = start.ok_or_else(|| Error::field("initial", "has no state"))?;
        let bytes = registration::memory_bytes(wire.observation.as_ref(), &shape);
        let purpose = "the registration: send fewer points";
        let share = budget::take(&self.memory.rollouts, bytes, purpose).await?;
        let backend = self.device.backend(Priority::Interactive);
        let job = Job { warm, start, request: wire, backend };
        call.blocking(move |cancel| {
            let _share = share;
            job.run(cancel)
        })
        .await
    }
}

impl Job {
    /// Computes it.
    pub(super) fn run(self, cancel: &CancelToken) -> Result<RegisteredState, Error> {
        let loaded = self.surrounded(cancel)?;
        let Self { warm, start, request, backend } = self;
        let grippers = grippers(request.grippers.as_ref(), "grippers")?;
        let around = Still::among(request.world.as_ref(), &grippers)?.around_now();
        let seen = observation::read(request.observation, &warm.twin.graph)?;
        let controls = observation::points(request.controls, "controls")?;
        let wire = request.options.unwrap_or_default();
        let options = RegisterOptions { around, ..options(wire, start, controls) };
        let registered = register(&backend, &loaded, &seen, &options, cancel)?;
        Ok(message(&registered, warm.twin.graph.rods.len()))
    }

    /// The twin's model with the ground and the gravity of the request.
    fn surrounded(&self, cancel: &CancelToken) -> Result<Loaded, Error> {
        let Some(world) = &self.request.world else { return Ok(self.warm.loaded.clone()) };
        let surroundings = Surroundings::without_bodies(world);
        let base = Base::own(&self.warm.loaded);
        let variants = Variants::load(None, &base, &surroundings, &self.backend, cancel)?;
        Ok(variants.of(0).loaded.clone())
    }
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
