//! Registration: from points that were seen of an object to a state of its twin.

mod observation;

use bendtwin_core::{Point, ids::TwinId};
pub use bendtwin_proto::v1::Residual;
use bendtwin_proto::v1::{
    InitialState, RegisterOptions, RegisterStateRequest, RegisteredState, Tensor,
    initial_state::{GivenState, Settled, State as Initial},
    registration_service_client::RegistrationServiceClient,
};

pub use self::observation::Observation;
use crate::{Error, State, WirePose, World, client::Channel};

/// Calls that find objects.
#[derive(Clone, Debug)]
pub struct Registrations {
    service: RegistrationServiceClient<Channel>,
}

/// A registration of a twin to an observation.
#[derive(Clone, Debug)]
pub struct Registration {
    request: RegisterStateRequest,
}

/// A state that was found.
#[derive(Clone, Debug, PartialEq)]
pub struct Registered {
    /// The state, at rest, with its control points: [`Rollout::from_state`](crate::Rollout).
    pub state: State,
    /// Distances of the points from the shape to start from.
    pub before: Residual,
    /// Distances of the points from the state.
    pub after: Residual,
    /// Share of the points that are within reach of the twin, 0..=1.
    pub explained_points: f64,
    /// Share of the surface that could have been seen and has a point within reach, 0..=1.
    pub explained_surface: f64,
    /// The rigid part of the motion from the shape to start from, about the origin: x, y, z [m],
    /// quaternion x, y, z, w.
    pub motion: [f64; 7],
    /// Mean distance by which nodes move in a frame when the points stop pulling [mm].
    pub drift_mm: f64,
}

impl Registrations {
    pub(crate) fn new(service: RegistrationServiceClient<Channel>) -> Self {
        Self { service }
    }

    /// Finds the state in which a twin explains an observation. Dropping the future stops the work
    /// at the server.
    ///
    /// # Errors
    /// If the request is wrong or too large, more than the stated residual is left (reason
    /// `OBSERVATION_NOT_EXPLAINED`), or the server cannot be asked.
    pub async fn run(&self, registration: Registration) -> Result<Registered, Error> {
        let reply = self.service.clone().register_state(registration.request).await?;
        reply.into_inner().try_into()
    }
}

impl Registration {
    /// A registration of a twin, from its rest shape.
    pub fn of(twin: TwinId, observation: Observation) -> Self {
        let observation = Some(observation.into());
        let twin = twin.to_string();
        Self { request: RegisterStateRequest { twin, observation, ..Default::default() } }
    }

    /// Starts from a state instead.
    #[must_use]
    pub fn from_state(self, state: &State) -> Self {
        self.from(Initial::Given(GivenState::from(state)))
    }

    /// Starts from the shape in which the twin comes to rest.
    #[must_use]
    pub fn settled(self) -> Self {
        self.from(Initial::Settled(Settled {}))
    }

    fn from(mut self, state: Initial) -> Self {
        self.request.initial = Some(InitialState { state: Some(state) });
        self
    }

    /// The control points are known, say from the gripper [m], shape [C].
    #[must_use]
    pub fn controls(mut self, controls: &[Point]) -> Self {
        self.request.controls = Some(Tensor::pack_points(&[controls.len()], controls));
        self
    }

    /// Gravity, ground and colliders, where they are not those of the twin: the state is outside of them.
    #[must_use]
    pub fn world(mut self, world: World) -> Self {
        self.request.world = Some(world.0);
        self
    }

    /// Poses of the grippers that carry colliders of the world; what others carry is left out.
    #[must_use]
    pub fn grippers(mut self, poses: &[WirePose]) -> Self {
        self.request.grippers = Some(packed(poses));
        self
    }

    /// The object is near the shape to start from: no other pose is tried.
    #[must_use]
    pub fn near(self) -> Self {
        self.with(|options| options.near = true)
    }

    /// Deviation of a point from the surface [m].
    #[must_use]
    pub fn noise_m(self, noise_m: f64) -> Self {
        self.with(|options| options.noise_m = Some(noise_m))
    }

    /// Frames of physics under the pull of the points; 0 leaves the shape as the points have it.
    #[must_use]
    pub fn settle_frames(self, frames: u32) -> Self {
        self.with(|options| options.settle_frames = Some(frames))
    }

    /// Median distance of the points beyond which the registration is refused [m].
    #[must_use]
    pub fn max_residual_m(self, residual_m: f64) -> Self {
        self.with(|options| options.max_residual_m = Some(residual_m))
    }

    fn with(mut self, set: impl FnOnce(&mut RegisterOptions)) -> Self {
        set(self.request.options.get_or_insert_default());
        self
    }
}

/// Poses of grippers, shape [G, 7].
pub(crate) fn packed(poses: &[WirePose]) -> Tensor {
    Tensor::pack(&[poses.len(), 7], poses.as_flattened())
}

impl TryFrom<RegisteredState> for Registered {
    type Error = Error;
    fn try_from(wire: RegisteredState) -> Result<Self, Error> {
        let explained = wire.explained.unwrap_or_default();
        let motion = wire.motion.try_into();
        Ok(Self {
            state: wire.state.unwrap_or_default().try_into()?,
            before: wire.before.unwrap_or_default(),
            after: wire.after.unwrap_or_default(),
            explained_points: explained.points,
            explained_surface: explained.surface,
            motion: motion.map_err(|_| Error::malformed("a motion that has not 7 numbers"))?,
            drift_mm: wire.drift_mm,
        })
    }
}

#[cfg(test)]
mod tests;
