//! Sessions: simulations that stay at a worker between calls.

mod correction;
mod new;
mod pictures;
mod step;

use std::{
    sync::{Arc, OnceLock},
    time::Duration,
};

use bendtwin_core::{
    Fidelity,
    ids::{SessionId, TwinId, WorkerId},
};
use bendtwin_proto::v1::{
    self, AdvanceSessionRequest, CloseSessionRequest, ForkSessionRequest, GetSessionRequest,
    GetSessionStatesRequest, InitialState, ResetSessionRequest, SessionStates,
    initial_state::State as Initial, session_service_client::SessionServiceClient,
};
use futures::{Stream, StreamExt as _, future, stream};
use serde::Serialize;

pub use self::{
    correction::{Corrected, Correction, Tracking},
    new::NewSession,
    pictures::{PictureCamera, Pictures, Prop, Rendering},
    step::{Step, StepTimes, Stepped},
};
use crate::{Error, Reply, Rollout, State, client::Channel, resources::resource};

/// Calls about sessions. If the worker of a session is lost, or the session was unused for a while,
/// they fail with the reason `SESSION_LOST`: open another from the last [`State`] in a reply.
#[derive(Clone, Debug)]
pub struct Sessions {
    service: SessionServiceClient<Channel>,
}

resource! { v1::Session =>
/// A session.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Session {
    /// Name of the session.
    pub name: SessionId,
    /// The twin that is simulated.
    pub twin: TwinId,
    /// Number of simulations.
    pub slots: u32,
    /// Frames by which each slot has been advanced since its first state, shape [slots].
    pub frames: Vec<u64>,
    /// Time after which the session ends if it is unused.
    pub idle_timeout: Duration = idle_timeout_s,
    /// The worker where it is.
    pub worker: WorkerId,
    /// Fidelity of its rollouts.
    pub fidelity: Fidelity,
    /// Slots that do not follow their object any more ([`Tracking`]), ascending.
    pub lost: Vec<u32>,
}
}

impl Sessions {
    pub(crate) fn new(service: SessionServiceClient<Channel>) -> Self {
        Self { service }
    }

    /// Opens simulations of a twin.
    ///
    /// # Errors
    /// If the request is wrong, no worker has room for it, or the server cannot be asked.
    pub async fn open(&self, new: NewSession) -> Result<Session, Error> {
        self.service.clone().open_session(new.0).await?.into_inner().try_into()
    }

    /// Returns the current session.
    ///
    /// # Errors
    /// If it is lost, or the server cannot be asked.
    pub async fn get(&self, name: SessionId) -> Result<Session, Error> {
        let request = GetSessionRequest { name: name.to_string() };
        self.service.clone().get_session(request).await?.into_inner().try_into()
    }

    /// The states of slots, or of all if none are named.
    ///
    /// # Errors
    /// If the session is lost, or the server cannot be asked.
    pub async fn states(&self, name: SessionId, slots: &[u32]) -> Result<Vec<State>, Error> {
        let request = GetSessionStatesRequest { name: name.to_string(), slots: slots.to_vec() };
        states(self.service.clone().get_session_states(request).await?.into_inner())
    }

    /// Simulates the actions of a rollout, an instance for each slot (none: slot 0), and leaves the
    /// slots where they end. Nothing changes if it fails or an instance diverges.
    ///
    /// # Errors
    /// If the rollout is wrong or names an initial state, the session is lost, or the server cannot
    /// be asked.
    pub async fn advance(
        &self,
        name: SessionId,
        slots: &[u32],
        rollout: Rollout,
    ) -> Result<Reply, Error> {
        let request = advance(name, slots, rollout)?;
        self.service.clone().advance_session(request).await?.into_inner().try_into()
    }

    /// Advances slots by one rollout after another over one connection, for teleoperation. Each is
    /// answered before the next one is sent on; the replies end with the first error.
    ///
    /// # Errors
    /// If the server cannot be asked.
    pub async fn control<S: Stream<Item = Rollout> + Send + 'static>(
        &self,
        name: SessionId,
        slots: &[u32],
        actions: S,
    ) -> Result<impl Stream<Item = Result<Reply, Error>> + use<S>, Error> {
        let fault = Arc::new(OnceLock::new());
        let (slots, noted) = (slots.to_vec(), Arc::clone(&fault));
        let messages = actions.map(move |rollout| advance(name, &slots, rollout));
        let messages = messages.map_while_ok(noted);
        let replies = self.service.clone().control_session(messages).await?.into_inner();
        let replies = replies.map(|reply| Reply::try_from(reply?));
        // Rollouts that cannot be sent end the stream; here it says why.
        let last = stream::once(async move { fault.get().cloned() });
        Ok(replies.chain(last.filter_map(|error: Option<Error>| future::ready(error.map(Err)))))
    }

    /// Copies the state of a slot, and its rest shape, to others, or to all others if none are named.
    ///
    /// # Errors
    /// If the session is lost or lacks a slot, or the server cannot be asked.
    pub async fn fork(&self, name: SessionId, from: u32, to: &[u32]) -> Result<Session, Error> {
        let request = ForkSessionRequest { name: name.to_string(), from, to: to.to_vec() };
        self.service.clone().fork_session(request).await?.into_inner().try_into()
    }

    /// Sets slots, or all if none are named, back to the session's first state, or to a given one, and
    /// to the rest shape of the twin.
    ///
    /// # Errors
    /// If the session is lost or lacks a slot, the state does not fit the twin, or the server cannot
    /// be asked.
    pub async fn reset(
        &self,
        name: SessionId,
        slots: &[u32],
        state: Option<&State>,
    ) -> Result<Session, Error> {
        let given = |state: &State| InitialState { state: Some(Initial::Given(state.into())) };
        let initial = state.map(given);
        let request =
            ResetSessionRequest { name: name.to_string(), slots: slots.to_vec(), initial };
        self.service.clone().reset_session(request).await?.into_inner().try_into()
    }

    /// Brings the states of slots (none: slot 0) closer to what is seen, in place and outside of
    /// obstacles; all of them, or none if too much is left at one (reason `OBSERVATION_NOT_EXPLAINED`,
    /// or `OBJECT_LOST` if that slot is lost). Rest shapes of the slots
    /// take part ([`Correction::carry`]); they are lost with the worker of the session.
    ///
    /// # Errors
    /// If the session is lost or lacks a slot, it is refused, or the server cannot be asked.
    pub async fn correct(
        &self,
        name: SessionId,
        slots: &[u32],
        correction: Correction,
    ) -> Result<Vec<Corrected>, Error> {
        let request = correction.into_request(name, slots);
        let reply = self.service.clone().correct_session(request).await?.into_inner();
        reply.corrections.into_iter().map(Corrected::try_from).collect()
    }

    /// Takes pictures of slots, or of all if none are named: one set for each camera. Nothing changes.
    ///
    /// # Errors
    /// If a camera or a prop is wrong or too much is asked for, the twin has no Gaussians (reason `GAUSSIANS_UNKNOWN`),
    /// the session is lost, or the server cannot be asked.
    pub async fn render(
        &self,
        name: SessionId,
        slots: &[u32],
        rendering: Rendering,
    ) -> Result<Vec<Pictures>, Error> {
        let request = rendering.into_request(name, slots);
        pictures::read(self.service.clone().render_session(request).await?.into_inner())
    }

    /// Takes a step of a closed loop: corrects a slot by what is seen, plans from there, and advances it
    /// by the first frames of the best plan.
    ///
    /// # Errors
    /// If the request is wrong, before anything changes; if the session or its worker is lost, every
    /// plan diverges, or the server cannot be asked: the slot may be corrected then, but it is not
    /// advanced.
    pub async fn step(&self, name: SessionId, step: Step) -> Result<Stepped, Error> {
        let request = step.into_request(name)?;
        self.service.clone().step_session(request).await?.into_inner().try_into()
    }

    /// Ends a session; it is no error if it has ended.
    ///
    /// # Errors
    /// If the server cannot be asked.
    pub async fn close(&self, name: SessionId) -> Result<(), Error> {
        let request = CloseSessionRequest { name: name.to_string() };
        self.service.clone().close_session(request).await?;
        Ok(())
    }
}

fn advance(
    name: SessionId,
    slots: &[u32],
    rollout: Rollout,
) -> Result<AdvanceSessionRequest, Error> {
    let rollout = Some(rollout.into_request()?);
    Ok(AdvanceSessionRequest { name: name.to_string(), slots: slots.to_vec(), rollout })
}

/// The end of a stream at its first error.
trait MapWhileOk<T>: Stream<Item = Result<T, Error>> + Sized {
    /// The items before the first error, which is noted.
    fn map_while_ok(self, fault: Arc<OnceLock<Error>>) -> impl Stream<Item = T> {
        self.scan(fault, |fault, item| {
            let item = item.map_err(|error| fault.set(error));
            future::ready(item.ok())
        })
    }
}

impl<T, S: Stream<Item = Result<T, Error>>> MapWhileOk<T> for S {}

fn states(wire: SessionStates) -> Result<Vec<State>, Error> {
    let (given, rows) = (wire.states.unwrap_or_default(), wire.slots.len());
    let all = State::try_from(given)?;
    Ok((0..rows).map(|row| all.row(rows, row)).collect())
}
