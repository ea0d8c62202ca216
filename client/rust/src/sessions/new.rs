//! A session to be opened, built step by step.

use std::time::Duration;

use bendtwin_core::{
    Fidelity,
    ids::{CaptureId, TwinId},
};
use bendtwin_proto::v1::{
    self, InitialState, OpenSessionRequest,
    initial_state::{CaptureFrame, Settled, State as Initial},
};

use crate::{Grasp, State, World};

/// A session to be opened: by default one simulation, of the twin at rest.
#[derive(Clone, Debug)]
pub struct NewSession(pub(super) OpenSessionRequest);

impl NewSession {
    /// A session of a twin.
    pub fn of(twin: TwinId) -> Self {
        Self(OpenSessionRequest { twin: twin.to_string(), ..OpenSessionRequest::default() })
    }

    /// Sets the number of simulations.
    #[must_use]
    pub fn slots(mut self, slots: u32) -> Self {
        self.0.slots = slots;
        self
    }

    /// Begins where the twin comes to rest under its gravity.
    #[must_use]
    pub fn settled(self) -> Self {
        self.start(Initial::Settled(Settled {}))
    }

    /// Begins in a whole state, such as [`Reply::state`](crate::Reply::state): the way to resume
    /// after a session was lost.
    #[must_use]
    pub fn going_on(self, state: &State) -> Self {
        self.start(Initial::Given(state.into()))
    }

    /// Begins where the twin is after following the controls of a capture (by default the twin's
    /// own) up to a frame.
    #[must_use]
    pub fn from_capture_frame(self, capture: Option<CaptureId>, sequence: u32, frame: u32) -> Self {
        let capture = capture.map(|c| c.to_string()).unwrap_or_default();
        self.start(Initial::CaptureFrame(CaptureFrame { capture, sequence, frame }))
    }

    /// Surrounds the object by this in all rollouts that name no other world.
    #[must_use]
    pub fn world(mut self, world: World) -> Self {
        self.0.world = Some(world.0);
        self
    }

    /// Adds a hold of a gripper to all rollouts that name none.
    #[must_use]
    pub fn grasp(mut self, grasp: Grasp) -> Self {
        self.0.grasps.push(grasp.0);
        self
    }

    /// Follows the twin exactly, which is the default, by its fast variant or by its planner's twin.
    #[must_use]
    pub fn fidelity(mut self, fidelity: Fidelity) -> Self {
        self.0.fidelity = match fidelity {
            Fidelity::Exact => v1::Fidelity::Exact.into(),
            Fidelity::Fast => v1::Fidelity::Fast.into(),
            Fidelity::Planner => v1::Fidelity::Planner.into(),
        };
        self
    }

    /// Sets the time after which the unused session ends, a second to an hour; without this, five
    /// minutes.
    #[must_use]
    pub fn idle_timeout(mut self, time: Duration) -> Self {
        self.0.idle_timeout_s = time.as_secs_f64();
        self
    }

    fn start(mut self, state: Initial) -> Self {
        self.0.initial = Some(InitialState { state: Some(state) });
        self
    }
}
