//! Sessions: simulations that stay here between calls. Each has slots with separate states. A
//! rollout reads the state of a slot; only an advance changes it, one at a time, and all of its
//! slots together or none.

mod begun;
pub(crate) mod correct;
mod states;

use std::{
    collections::HashMap,
    sync::{Arc, Mutex, MutexGuard, PoisonError},
    time::{Duration, Instant},
};

use bendtwin_budget::Share;
use bendtwin_core::ids::{SessionId, TwinId};
use bendtwin_proto::{v1, worker::v1::HeldSession};
use bendtwin_register::Tracking;

pub use self::{begun::Begun, states::session_states};
use crate::{error::Error, request::initial::Start};

/// Most sessions of a worker.
const MOST: usize = 256;
/// Time after which an unused session ends: where the caller did not say, and bounds of what it may
/// say [s].
const IDLE_S: f64 = 300.0;
const IDLE_BOUNDS_S: std::ops::RangeInclusive<f64> = 1.0..=3600.0;

/// A session, apart from its states.
#[derive(Debug)]
pub struct Setup {
    /// The twin.
    pub twin: TwinId,
    /// Owner of the key that opened it, for servers; empty if it is not known.
    pub owner: String,
    /// captures/{uuid} of the twin, for initial states in a frame of it.
    pub capture: String,
    /// The model that answers.
    pub fidelity: v1::Fidelity,
    /// Surroundings of rollouts that name none.
    pub world: Option<v1::World>,
    /// Grasps of rollouts that name none.
    pub grasps: Vec<v1::Grasp>,
    /// Time after which it ends if nobody uses it.
    pub idle: Duration,
}

impl Setup {
    /// The surroundings and fidelity as a request.
    pub fn as_request(&self) -> v1::OpenSessionRequest {
        v1::OpenSessionRequest {
            world: self.world.clone(),
            grasps: self.grasps.clone(),
            fidelity: self.fidelity.into(),
            ..v1::OpenSessionRequest::default()
        }
    }
}

/// A simulation of a session.
#[derive(Clone, Debug)]
struct Slot {
    now: Start,
    /// Frames since the first state.
    frames: u64,
    /// Record of how well its corrections explain what is seen.
    tracking: Tracking,
}

impl Slot {
    /// A slot that begins in a state.
    fn new(now: Start) -> Self {
        Self { now, frames: 0, tracking: Tracking::default() }
    }
}

/// A session.
pub struct Session {
    /// Id, which may be replaced before the session is added.
    pub id: SessionId,
    /// Twin, surroundings and options that it was opened with.
    pub setup: Setup,
    first: Vec<Start>,
    slots: Mutex<Vec<Slot>>,
    /// Held while the session is advanced.
    advancing: Arc<tokio::sync::Mutex<()>>,
    last_use: Mutex<Instant>,
    /// Memory of the states.
    _share: Option<Share>,
}

/// The sessions of a worker.
#[derive(Default)]
pub struct Sessions(Mutex<HashMap<SessionId, Arc<Session>>>);

/// Time after which an unused session ends; 0 asks for the default.
///
/// # Errors
/// If it is too short or too long.
pub fn idle(asked_s: f64) -> Result<Duration, Error> {
    let seconds = if asked_s == 0.0 { IDLE_S } else { asked_s };
    if !IDLE_BOUNDS_S.contains(&seconds) {
        let (low, high) = (IDLE_BOUNDS_S.start(), IDLE_BOUNDS_S.end());
        return Err(Error::field("idle_timeout_s", format!("must lie in {low}..={high}")));
    }
    Ok(Duration::from_secs_f64(seconds))
}

impl Session {
    /// A session whose slots begin in these states.
    pub fn new(setup: Setup, first: Vec<Start>, share: Option<Share>) -> Self {
        let slots = first.iter().cloned().map(Slot::new).collect();
        Self {
            id: SessionId::generate(),
            setup,
            first,
            slots: Mutex::new(slots),
            advancing: Arc::default(),
            last_use: Mutex::new(Instant::now()),
            _share: share,
        }
    }

    /// Number of slots.
    pub fn slots(&self) -> usize {
        self.first.len()
    }

    /// Checks numbers of slots, each named once; none means those of `default`.
    ///
    /// # Errors
    /// If there is no such slot, or one is named twice.
    pub fn distinct(
        &self,
        slots: &[u32],
        default: impl IntoIterator<Item = usize>,
    ) -> Result<Vec<usize>, Error> {
        let mut seen = vec![false; self.slots()];
        let chosen = self.chosen(slots, default)?;
        match chosen.iter().find(|&&slot| std::mem::replace(&mut seen[slot], true)) {
            Some(slot) => Err(Error::field("slots", format!("names slot {slot} twice"))),
            None => Ok(chosen),
        }
    }

    /// Checks numbers of slots; none means those of `default`.
    ///
    /// # Errors
    /// If there is no such slot.
    pub fn chosen(
        &self,
        slots: &[u32],
        default: impl IntoIterator<Item = usize>,
    ) -> Result<Vec<usize>, Error> {
        let count = self.slots();
        if slots.is_empty() {
            return Ok(default.into_iter().collect());
        }
        if let Some(beyond) = slots.iter().find(|&&s| s as usize >= count) {
            let fault = format!("names slot {beyond} of {count} (counted from 0)");
            return Err(Error::field("slots", fault));
        }
        Ok(slots.iter().map(|&s| s as usize).collect())
    }

    /// The states of slots, and the frames that they have been advanced by.
    pub(crate) fn states(&self, slots: &[usize]) -> (Vec<Start>, Vec<u64>) {
        let own = lock(&self.slots);
        slots.iter().filter_map(|&s| own.get(s)).map(|s| (s.now.clone(), s.frames)).unzip()
    }

    /// Waits until no other call advances the session.
    pub async fn begin_advance(&self) -> tokio::sync::OwnedMutexGuard<()> {
        Arc::clone(&self.advancing).lock_owned().await
    }

    /// Leaves slots in new states, `frames` later.
    pub(crate) fn commit(&self, slots: &[usize], states: Vec<Start>, frames: u64) {
        let mut own = lock(&self.slots);
        for (&slot, now) in slots.iter().zip(states) {
            if let Some(slot) = own.get_mut(slot) {
                slot.now = now;
                slot.frames = slot.frames.saturating_add(frames);
            }
        }
    }

    /// The records of slots.
    pub(crate) fn trackings(&self, slots: &[usize]) -> Vec<Tracking> {
        let own = lock(&self.slots);
        slots.iter().filter_map(|&s| own.get(s)).map(|s| s.tracking).collect()
    }

    /// Leaves slots with these records.
    pub(crate) fn record(&self, slots: impl IntoIterator<Item = (usize, Tracking)>) {
        let mut own = lock(&self.slots);
        for (slot, tracking) in slots {
            if let Some(slot) = own.get_mut(slot) {
                slot.tracking = tracking;
            }
        }
    }

    /// Copies a slot to others.
    pub fn fork(&self, from: usize, to: &[usize]) {
        let mut own = lock(&self.slots);
        let Some(source) = own.get(from).cloned() else { return };
        for &slot in to {
            if let Some(target) = own.get_mut(slot) {
                target.clone_from(&source);
            }
        }
    }

    /// Sets slots to given states, one each, or to the session's first ones.
    pub fn reset(&self, slots: &[usize], states: Option<Vec<Start>>) {
        let first = || slots.iter().filter_map(|&s| self.first.get(s).cloned()).collect();
        let states = states.unwrap_or_else(first);
        let mut own = lock(&self.slots);
        for (&slot, now) in slots.iter().zip(states) {
            if let Some(slot) = own.get_mut(slot) {
                *slot = Slot::new(now);
            }
        }
    }

    /// The session as a client sees it.
    pub fn describe(&self, worker: &str) -> v1::Session {
        let slots = lock(&self.slots);
        let lost = slots.iter().zip(0..).filter(|(slot, _)| slot.tracking.is_lost());
        v1::Session {
            name: self.id.to_string(),
            twin: self.setup.twin.to_string(),
            slots: self.slots() as u32,
            frames: slots.iter().map(|s| s.frames).collect(),
            idle_timeout_s: self.setup.idle.as_secs_f64(),
            worker: worker.to_owned(),
            fidelity: self.setup.fidelity.into(),
            lost: lost.map(|(_, number)| number).collect(),
        }
    }

    fn used(&self) {
        *lock(&self.last_use) = Instant::now();
    }

    /// True if the session is unused, and has been for as long as it may be idle.
    fn has_ended(&self, now: Instant) -> bool {
        let idle = now.saturating_duration_since(*lock(&self.last_use));
        idle > self.setup.idle && self.advancing.try_lock().is_ok()
    }
}

impl Sessions {
    /// Adds a session.
    ///
    /// # Errors
    /// If there are too many.
    pub fn add(&self, session: Session) -> Result<Arc<Session>, Error> {
        let mut sessions = lock(&self.0);
        end_idle(&mut sessions);
        if sessions.len() >= MOST {
            return Err(Error::TooManySessions { limit: MOST });
        }
        let session = Arc::new(session);
        sessions.insert(session.id, Arc::clone(&session));
        Ok(session)
    }

    /// A session, which is used from now on.
    ///
    /// # Errors
    /// If it is not here.
    pub fn get(&self, name: &str) -> Result<Arc<Session>, Error> {
        let id: SessionId = name
            .parse()
            .map_err(|e: bendtwin_core::ids::InvalidName| Error::field("session", e.to_string()))?;
        let mut sessions = lock(&self.0);
        end_idle(&mut sessions);
        let found = sessions.get(&id).cloned();
        let session = found.ok_or_else(|| Error::SessionLost { name: name.to_owned() })?;
        session.used();
        Ok(session)
    }

    /// Ends a session; it is no error if it has ended.
    pub fn close(&self, id: SessionId) {
        lock(&self.0).remove(&id);
    }

    /// The sessions of this worker, for heartbeats.
    pub fn list(&self) -> Vec<HeldSession> {
        let mut sessions = lock(&self.0);
        end_idle(&mut sessions);
        let held = sessions.values().map(|session| HeldSession {
            session: session.id.to_string(),
            twin: session.setup.twin.to_string(),
            slots: session.slots() as u32,
            grasps: session.setup.grasps.len() as u32,
            colliders: session.setup.world.as_ref().map_or(0, |w| w.colliders.len() as u32),
            owner: session.setup.owner.clone(),
        });
        held.collect()
    }
}

fn end_idle(sessions: &mut HashMap<SessionId, Arc<Session>>) {
    let now = Instant::now();
    sessions.retain(|id, session| {
        let ends = session.has_ended(now);
        if ends {
            tracing::info!(session = %id, "session ended: nobody used it");
        }
        !ends
    });
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests;
