//! A rollout that begins in a session: its states, and their return.

use std::sync::Arc;

use bendtwin_contract::rollout;
use bendtwin_proto::v1::{self, RollOutRequest, initial_state};
use tokio::sync::OwnedMutexGuard;

use super::{Session, Sessions};
use crate::{
    error::Error,
    request::initial::{Start, Starts},
};

/// A rollout that begins in a session.
pub struct Begun {
    session: Arc<Session>,
    /// The slots that instances begin in: one for all, or one for each.
    slots: Vec<usize>,
    /// The slots that take over final states; empty: none do.
    commit: Vec<usize>,
    /// Held while the session is advanced.
    _turn: Option<OwnedMutexGuard<()>>,
}

impl Begun {
    /// The session that a request begins in, if it begins in one. Its fidelity and, where the
    /// request names none, its surroundings are written into the request. If slots are to take over final
    /// states, this waits until nobody else advances the session.
    ///
    /// # Errors
    /// If the session is not here, or has no such slots, or the request asks for what an advance has not.
    pub async fn new(
        sessions: &Sessions,
        request: &mut RollOutRequest,
        commit_slots: Vec<u32>,
    ) -> Result<Option<Self>, Error> {
        let state = request.initial.as_ref().and_then(|i| i.state.as_ref());
        let Some(initial_state::State::Session(at)) = state else { return Ok(None) };
        let session = sessions.get(&at.session)?;
        let slots = session.chosen(&at.slots, [0])?;
        let commit = session.distinct(&commit_slots, [])?;
        let setup = &session.setup;
        if request.fidelity() == v1::Fidelity::Unspecified {
            request.fidelity = setup.fidelity.into();
        }
        if request.world.is_none() {
            request.world.clone_from(&setup.world);
        }
        if request.grasps.is_empty() {
            request.grasps.clone_from(&setup.grasps);
        }
        let turn = if commit.is_empty() {
            None
        } else {
            rollout::check_advance(request)?;
            Some(session.begin_advance().await)
        };
        Ok(Some(Self { session, slots, commit, _turn: turn }))
    }

    /// The states that instances begin in.
    pub fn starts(&self) -> Starts {
        let (mut states, _) = self.session.states(&self.slots);
        match states.pop() {
            Some(only) if states.is_empty() => Starts::Shared(only),
            last => {
                states.extend(last);
                Starts::Each(states)
            }
        }
    }

    /// True if final states are taken over.
    pub fn commits(&self) -> bool {
        !self.commit.is_empty()
    }

    /// Leaves the slots in the final states of the instances, unless one is missing because it
    /// diverged.
    ///
    /// # Errors
    /// If there is not an instance for each slot.
    pub fn commit(self, states: Vec<Option<Start>>, frames: usize) -> Result<(), Error> {
        if self.commit.is_empty() {
            return Ok(());
        }
        if states.len() != self.commit.len() {
            let (instances, slots) = (states.len(), self.commit.len());
            let fault = format!("has {slots} slots for {instances} instances: give one each");
            return Err(Error::field("slots", fault));
        }
        if let Some(states) = states.into_iter().collect::<Option<Vec<Start>>>() {
            self.session.commit(&self.commit, states, frames as u64);
        }
        Ok(())
    }
}
