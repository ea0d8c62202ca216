//! The way to sessions, which live at workers: a call about a session goes to the worker that has
//! it, and to no other. The table is in memory; after a restart of the server the workers'
//! heartbeats fill it again.

use std::{sync::Arc, time::Duration};

use bendtwin_core::ids::{SessionId, TwinId};
use bendtwin_proto::{
    rollout::{self, REQUEST_BYTES},
    v1::{
        AdvanceSessionRequest, InitialState, OpenSessionRequest, RollOutRequest, RollOutResponse,
        initial_state::{SessionSlots, State},
    },
    worker::v1::{
        ExecuteRollOutRequest, ManageSessionRequest, ManageSessionResponse,
        manage_session_request::Call,
    },
};
use prost::Message as _;
use tokio::time::Instant;
use tonic::Request;

use super::{
    Dispatch,
    line::Ask,
    registry::Entry,
    rollout::{Ends, RollOut, Running, Whole, failure, is_late, late},
    untaken::was_not_taken,
};
use crate::{
    context::Context,
    failure::{Error, Result},
    memory::Shares,
};

/// Longest that a call without a deadline of its own may take: the way to a first state may be long.
const LONGEST: Duration = Duration::from_secs(600);

impl Dispatch {
    /// The worker that has a session, and the session's twin.
    pub(super) fn session(&self, session: SessionId) -> Result<(Arc<Entry>, TwinId)> {
        let workers = self.lock();
        let found = workers.values().find_map(|e| Some((Arc::clone(e), e.session(session)?)));
        found.ok_or_else(|| Error::SessionLost(session.to_string()))
    }

    /// The session in which a request begins, if it begins in one, and its worker; fills in the
    /// twin.
    pub(super) fn session_of(
        &self,
        request: &mut RollOutRequest,
    ) -> Result<Option<(SessionId, Arc<Entry>)>> {
        let state = request.initial.as_ref().and_then(|i| i.state.as_ref());
        let Some(State::Session(SessionSlots { session, .. })) = state else { return Ok(None) };
        let id: SessionId = session.parse().map_err(Error::Name)?;
        let (entry, twin) = self.session(id)?;
        if !request.twin.is_empty() && request.twin.parse() != Ok(twin) {
            let fault = format!("is {}: the session is of {twin}", request.twin);
            return Err(Error::invalid("twin", fault));
        }
        request.twin = twin.to_string();
        Ok(Some((id, entry)))
    }

    /// Gets the session's worker to send a first part.
    pub(super) async fn start_in(
        &self,
        (session, entry): &(SessionId, Arc<Entry>),
        ask: &Ask,
        execute: ExecuteRollOutRequest,
        ends: Ends,
    ) -> Result<(RollOutResponse, Running)> {
        match self.start_at(entry, ask, execute, ends).await {
            Ok(Some(started)) => Ok(started),
            Ok(None) => {
                entry.broke();
                Err(Error::WorkerLost)
            }
            // Whatever the worker had in memory went with it.
            Err(Error::WorkerEnded) => {
                entry.closed(*session);
                Err(Error::SessionLost(session.to_string()))
            }
            Err(error) => Err(error),
        }
    }

    /// Simulates a rollout from where slots of a session are, and leaves them where it ends.
    pub(crate) async fn advance_session(
        &self,
        advance: AdvanceSessionRequest,
        timeout: Option<Duration>,
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
        let (in_parts, as_lists) = (false, false);
        let rollout = RollOut { request, timeout, in_parts, as_lists, commit_slots, memory };
        self.roll_out(rollout).await
    }

    /// Opens a session at a worker that can take it.
    pub(crate) async fn open_session(
        &self,
        open: OpenSessionRequest,
        timeout: Option<Duration>,
    ) -> Result<ManageSessionResponse> {
        let twin: TwinId = open.twin.parse().map_err(Error::Name)?;
        let known = self.twins.get(&self.store, twin).await?;
        rollout::check_session(&open, &known.shape, &self.limits.rollout)?;
        let ask = Ask { client: Context::current().client, work: 0.0 };
        let entry = self.choose(twin, &ask, &[])?;
        let capture = known.capture.map(|c| c.to_string()).unwrap_or_default();
        let reply = self.manage(&entry, Call::Open(open), capture, timeout).await?;
        let session = reply.session.as_ref().and_then(|s| s.name.parse().ok());
        let session = session.ok_or(Error::WorkerEnded)?;
        entry.opened(session, twin);
        entry.warmed(twin);
        Ok(reply)
    }

    /// Passes a call on to the session's worker.
    pub(crate) async fn manage_session(
        &self,
        session: &str,
        call: Call,
        timeout: Option<Duration>,
    ) -> Result<ManageSessionResponse> {
        let session: SessionId = session.parse().map_err(Error::Name)?;
        let closes = matches!(call, Call::Close(_));
        let (entry, twin) = match self.session(session) {
            // It has ended already.
            Err(Error::SessionLost(_)) if closes => return Ok(ManageSessionResponse::default()),
            found => found?,
        };
        let known = self.twins.get(&self.store, twin).await?;
        let capture = known.capture.map(|c| c.to_string()).unwrap_or_default();
        let reply = self.manage(&entry, call, capture, timeout).await;
        let is_gone = matches!(&reply, Err(Error::Worker(f)) if f.reason == "SESSION_LOST");
        if closes || is_gone {
            entry.closed(session);
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
        let deadline = Instant::now() + timeout.unwrap_or(LONGEST).min(LONGEST);
        let request_id = Context::current().request_id;
        let (mut client, token) = entry.client();
        let message = ManageSessionRequest { call: Some(call), capture, request_id };
        let length = message.encoded_len();
        let mut request = Request::new(message);
        request.metadata_mut().insert(REQUEST_BYTES, length.into());
        request.metadata_mut().insert("authorization", token);
        request.set_timeout(deadline.saturating_duration_since(Instant::now()));
        match client.manage_session(request).await {
            Ok(reply) => Ok(reply.into_inner()),
            Err(status) if is_late(deadline) => Err(late(&status)),
            Err(status) if was_not_taken(&status) => {
                entry.broke();
                Err(Error::WorkerLost)
            }
            Err(status) => Err(failure(&status)),
        }
    }
}
