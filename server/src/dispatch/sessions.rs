//! The way to sessions, which live at workers: a call about a session goes to the worker that has
//! it, and to no other. The table is in memory; after a restart of the server the workers'
//! heartbeats fill it again. A session that another server opened a moment ago is asked for at its
//! worker, which its id names.

use std::{sync::Arc, time::Duration};

use bendtwin_contract::{
    picture, registration,
    rollout::{self, SessionParts},
};
use bendtwin_core::ids::{SessionId, TwinId};
use bendtwin_proto::{
    v1::{
        AdvanceSessionRequest, CloseSessionRequest, CorrectSessionRequest, CorrectedSession,
        GetSessionStatesRequest, InitialState, OpenSessionRequest, RenderSessionRequest,
        RenderedSession, RollOutRequest, RollOutResponse, Session, SessionStates,
        initial_state::{SessionSlots, State},
    },
    worker::v1::{
        ExecuteRollOutRequest, ManageSessionRequest, ManageSessionResponse,
        manage_session_request::Call,
    },
};
use tokio::time::Instant;

use super::{
    Dispatch, Learned, call,
    line::Ask,
    registry::{Entry, HeldSession},
    rollout::{Ends, ReplyHold, ReplyStream, RollOut, Whole},
};
use crate::{
    context::Context,
    error::{Error, Result},
    memory::Shares,
};

/// Longest time of a call without a deadline: a first state may take long.
const LONGEST: Duration = Duration::from_secs(600);

impl Dispatch {
    /// The owner that opened a session; empty if it is not known.
    pub(crate) async fn session_owner(&self, session: SessionId) -> Result<Arc<str>> {
        Ok(self.session(session).await?.1.owner)
    }

    /// The twin of a session.
    pub(crate) async fn session_twin(&self, session: SessionId) -> Result<TwinId> {
        Ok(self.session(session).await?.1.twin)
    }

    /// The worker that has a session, and what is known of it.
    pub(super) async fn session(&self, session: SessionId) -> Result<(Arc<Entry>, HeldSession)> {
        if let Some(found) = self.known_session(session) {
            return Ok(found);
        }
        if self.store.is_shared() {
            self.look_for(session).await?;
        }
        self.known_session(session).ok_or_else(|| Error::SessionLost(session.to_string()))
    }

    fn known_session(&self, session: SessionId) -> Option<(Arc<Entry>, HeldSession)> {
        let workers = self.lock();
        workers.values().find_map(|e| Some((Arc::clone(e), e.session(session)?)))
    }

    /// Asks the worker that a session's id names, though it may have registered at another server in
    /// this moment.
    async fn look_for(&self, session: SessionId) -> Result<()> {
        let named = || {
            let workers = self.lock();
            workers.values().find(|e| session.may_be_at(e.id())).cloned()
        };
        let mut entry = named();
        if entry.is_none() {
            let workers = self.store.workers().all().await?;
            let its = workers.into_iter().find(|w| session.may_be_at(w.registration.id));
            let Some(worker) = its else { return Ok(()) };
            if self.learn(worker).await? == Learned::Unusable {
                return Err(Error::SessionElsewhere(session.to_string()));
            }
            entry = named();
        }
        if let Some(entry) = entry {
            self.ask(&entry).await;
        }
        Ok(())
    }

    /// The session in which a request begins, if it begins in one, and its worker; fills in the
    /// twin. Also the parts of its surroundings.
    pub(super) async fn session_of(
        &self,
        request: &mut RollOutRequest,
    ) -> Result<(Option<(SessionId, Arc<Entry>)>, SessionParts)> {
        let state = request.initial.as_ref().and_then(|i| i.state.as_ref());
        let Some(State::Session(SessionSlots { session, .. })) = state else {
            return Ok((None, SessionParts::default()));
        };
        let id: SessionId = session.parse().map_err(Error::Name)?;
        let (entry, HeldSession { twin, parts, .. }) = self.session(id).await?;
        if !request.twin.is_empty() && request.twin.parse() != Ok(twin) {
            let fault = format!("is {}: the session is of {twin}", request.twin);
            return Err(Error::invalid("twin", fault));
        }
        request.twin = twin.to_string();
        Ok((Some((id, entry)), parts))
    }

    /// Gets the session's worker to send a first part.
    pub(super) async fn start_in(
        &self,
        (session, entry): &(SessionId, Arc<Entry>),
        ask: &Ask,
        execute: ExecuteRollOutRequest,
        ends: Ends,
    ) -> Result<(RollOutResponse, ReplyStream)> {
        match self.start_at(entry, ask, execute, ends).await {
            Ok(Some(started)) => Ok(started),
            Ok(None) => {
                entry.broke();
                Err(Error::WorkerLost)
            }
            // All that the worker had in memory is lost with it.
            Err(Error::WorkerEnded) => {
                entry.closed(*session);
                Err(Error::SessionLost(session.to_string()))
            }
            Err(error) => Err(error),
        }
    }

    /// Simulates a rollout from where slots of a session are, and leaves them where it ends;
    /// `as_lists` if the reply is to be written as nested lists of JSON.
    pub(crate) async fn advance_session(
        &self,
        advance: AdvanceSessionRequest,
        timeout: Option<Duration>,
        as_lists: bool,
        memory: Arc<Shares>,
    ) -> Result<Whole> {
        let missing = || Error::invalid("rollout", "is missing");
        let mut request = advance.rollout.ok_or_else(missing)?;
        if request.initial.is_some() {
            let fault = "must be left out: an advance begins where the session is";
            return Err(Error::invalid("rollout.initial", fault));
        }
        let commit_slots = if advance.slots.is_empty() { vec![0] } else { advance.slots };
        let slots = SessionSlots { session: advance.name, slots: commit_slots.clone() };
        request.initial = Some(InitialState { state: Some(State::Session(slots)) });
        let rollout = RollOut { request, timeout, in_parts: false, as_lists, commit_slots, memory };
        self.roll_out(rollout).await
    }

    /// Opens a session at a worker that can take it.
    pub(crate) async fn open_session(
        &self,
        open: OpenSessionRequest,
        timeout: Option<Duration>,
    ) -> Result<Session> {
        let twin: TwinId = open.twin.parse().map_err(Error::Name)?;
        let known = self.twins.get(&self.store, twin).await?;
        rollout::check_session(&open, &known.shape, &self.limits.rollout)?;
        let ask = Ask::of_caller(0.0);
        let capture = known.capture.map(|c| c.to_string()).unwrap_or_default();
        let parts = SessionParts {
            colliders: open.world.as_ref().map_or(0, |world| world.colliders.len() as u32),
            grasps: open.grasps.len() as u32,
        };
        let opened = self.at_a_worker(twin, &ask, None, |entry| {
            let (call, capture) = (Call::Open(open.clone()), capture.clone());
            async move {
                let reply = self.manage_at(&entry, call, capture, timeout).await?;
                Ok(reply.map(|reply| (entry, reply)))
            }
        });
        let (entry, reply) = opened.await?;
        let session = described(reply)?;
        let id: SessionId = session.name.parse().map_err(|_| Error::WorkerEnded)?;
        let owner = Context::current().caller.owner;
        entry.opened(id, HeldSession { twin, owner, slots: session.slots, parts });
        Ok(session)
    }

    /// Passes a call on to the worker of its session.
    pub(crate) async fn session_call(
        &self,
        session: &str,
        call: Call,
        timeout: Option<Duration>,
    ) -> Result<Session> {
        let (id, entry, held) = self.named(session).await?;
        described(self.manage_known(id, &entry, held.twin, call, timeout).await?)
    }

    /// States of slots, and their memory; `as_lists` if they are to be written as nested lists of
    /// JSON.
    pub(crate) async fn session_states(
        &self,
        request: GetSessionStatesRequest,
        timeout: Option<Duration>,
        as_lists: bool,
    ) -> Result<(SessionStates, ReplyHold)> {
        let (id, entry, held) = self.named(&request.name).await?;
        let known = self.twins.get(&self.store, held.twin).await?;
        let slots = match request.slots.len() {
            0 => held.slots as usize,
            count => count,
        };
        let mut limits = self.limits.rollout;
        if as_lists {
            limits.reply_bytes = limits.json_reply_bytes;
        }
        let grasps = u64::from(held.parts.grasps);
        let bytes = rollout::states_bytes(slots as u64, grasps, &known.shape, &limits)?;
        let share = self.memory.reply(bytes).await?;
        let reply =
            self.manage_known(id, &entry, held.twin, Call::States(request), timeout).await?;
        Ok((reply.states.unwrap_or_default(), ReplyHold::of(share)))
    }

    /// Brings slots of a session closer to what is seen; the reply with its memory. `as_lists` if it is
    /// to be written as nested lists of JSON.
    pub(crate) async fn correct_session(
        &self,
        correct: CorrectSessionRequest,
        timeout: Option<Duration>,
        as_lists: bool,
    ) -> Result<(CorrectedSession, ReplyHold)> {
        let (id, entry, held) = self.named(&correct.name).await?;
        let known = self.twins.get(&self.store, held.twin).await?;
        let (slots, grasps) = (correct.slots.len().max(1) as u64, u64::from(held.parts.grasps));
        let mut limits = self.limits.rollout;
        if as_lists {
            limits.reply_bytes = limits.json_reply_bytes;
        }
        registration::check_correction(&correct, slots, grasps, &known.shape, &limits)?;
        let options = correct.options.clone().unwrap_or_default();
        let bytes = registration::correction_reply_bytes(&options, slots, grasps, &known.shape);
        let share = self.memory.reply(bytes).await?;
        let call = Call::Correct(correct);
        let reply = self.manage_known(id, &entry, held.twin, call, timeout).await?;
        let missing = || Error::Internal("a worker's reply has no correction".to_owned());
        Ok((reply.corrected.ok_or_else(missing)?, ReplyHold::of(share)))
    }

    /// Pictures of slots of a session; the reply with its memory. `as_lists` if it is to be written as nested lists of
    /// JSON.
    pub(crate) async fn render_session(
        &self,
        render: RenderSessionRequest,
        timeout: Option<Duration>,
        as_lists: bool,
    ) -> Result<(RenderedSession, ReplyHold)> {
        let (id, entry, held) = self.named(&render.name).await?;
        let slots = match render.slots.len() {
            0 => u64::from(held.slots),
            count => count as u64,
        };
        let mut limits = self.limits.rollout;
        if as_lists {
            limits.reply_bytes = limits.json_reply_bytes;
        }
        picture::check_pictures(&render, slots, &limits)?;
        let share = self.memory.reply(picture::reply_bytes(&render, slots)).await?;
        let reply = self.manage_known(id, &entry, held.twin, Call::Render(render), timeout).await?;
        let missing = || Error::Internal("a worker's reply has no pictures".to_owned());
        Ok((reply.rendered.ok_or_else(missing)?, ReplyHold::of(share)))
    }

    /// Ends a session; it is no error if it has ended.
    pub(crate) async fn close_session(
        &self,
        close: CloseSessionRequest,
        timeout: Option<Duration>,
    ) -> Result<()> {
        match self.named(&close.name).await {
            Err(Error::SessionLost(_)) => Ok(()),
            Err(error) => Err(error),
            Ok((id, entry, held)) => {
                self.manage_known(id, &entry, held.twin, Call::Close(close), timeout).await?;
                entry.closed(id);
                Ok(())
            }
        }
    }

    pub(super) async fn named(
        &self,
        session: &str,
    ) -> Result<(SessionId, Arc<Entry>, HeldSession)> {
        let id = session.parse().map_err(Error::Name)?;
        let (entry, held) = self.session(id).await?;
        Ok((id, entry, held))
    }

    async fn manage_known(
        &self,
        session: SessionId,
        entry: &Arc<Entry>,
        twin: TwinId,
        call: Call,
        timeout: Option<Duration>,
    ) -> Result<ManageSessionResponse> {
        let known = self.twins.get(&self.store, twin).await?;
        let capture = known.capture.map(|c| c.to_string()).unwrap_or_default();
        let reply = self.manage(entry, call, capture, timeout).await;
        let is_lost = match &reply {
            Err(Error::Worker(fault)) => fault.reason == "SESSION_LOST",
            // All that the worker had in memory is lost with it.
            Err(Error::WorkerEnded) => true,
            _ => false,
        };
        if is_lost {
            entry.closed(session);
            return Err(Error::SessionLost(session.to_string()));
        }
        reply
    }

    async fn manage(
        &self,
        entry: &Arc<Entry>,
        call: Call,
        capture: String,
        timeout: Option<Duration>,
    ) -> Result<ManageSessionResponse> {
        let reply = self.manage_at(entry, call, capture, timeout).await?;
        reply.ok_or_else(|| {
            entry.broke();
            Error::WorkerLost
        })
    }

    /// `None` if the worker cannot be reached, so that it has not taken the call.
    async fn manage_at(
        &self,
        entry: &Arc<Entry>,
        call: Call,
        capture: String,
        timeout: Option<Duration>,
    ) -> Result<Option<ManageSessionResponse>> {
        let deadline = Instant::now() + timeout.unwrap_or(LONGEST).min(LONGEST);
        let Context { request_id, caller, .. } = Context::current();
        let owner = caller.owner.to_string();
        let message = ManageSessionRequest { call: Some(call), capture, request_id, owner };
        let sent = call::send(entry, message, deadline, |mut client, request| async move {
            client.manage_session(request).await
        });
        let Some((reply, mut taken)) = sent.await? else { return Ok(None) };
        taken.answered();
        Ok(Some(reply))
    }
}

fn described(reply: ManageSessionResponse) -> Result<Session> {
    let missing = || Error::Internal("a worker's reply has no session".to_owned());
    reply.session.ok_or_else(missing)
}
