//! Sessions: simulations that stay at a worker between calls.

use std::{sync::Arc, time::Duration};

use bendtwin_core::ids::{SessionId, TwinId};
use bendtwin_proto::{
    v1::{
        AdvanceSessionRequest, CloseSessionRequest, CorrectSessionRequest, CorrectedSession,
        GetSessionStatesRequest, OpenSessionRequest, RenderSessionRequest, RenderedSession,
        Session, SessionStates,
    },
    worker::v1::manage_session_request::Call,
};

use super::super::{App, Error, ReplyHold, Result, Step, Whole};
use crate::{access::Scope, dispatch::Stepped, memory::Shares};

impl App {
    /// Opens a session at a worker that can take it.
    pub(crate) async fn open_session(
        &self,
        open: OpenSessionRequest,
        timeout: Option<Duration>,
    ) -> Result<Session> {
        self.reach::<TwinId>(Scope::RolloutsRun, &open.twin).await?;
        self.require_initial(open.initial.as_ref()).await?;
        self.dispatch.open_session(open, timeout).await
    }

    /// Reads, forks or resets a session, as the call says.
    pub(crate) async fn session_call(
        &self,
        session: &str,
        call: Call,
        timeout: Option<Duration>,
    ) -> Result<Session> {
        self.reach_session(session).await?;
        if let Call::Reset(reset) = &call {
            self.require_initial(reset.initial.as_ref()).await?;
        }
        self.dispatch.session_call(session, call, timeout).await
    }

    /// States of slots, and their memory; `as_lists` if they are to be written as nested lists of
    /// JSON.
    pub(crate) async fn session_states(
        &self,
        asked: GetSessionStatesRequest,
        timeout: Option<Duration>,
        as_lists: bool,
    ) -> Result<(SessionStates, ReplyHold)> {
        self.reach_session(&asked.name).await?;
        self.dispatch.session_states(asked, timeout, as_lists).await
    }

    /// Simulates a rollout from where slots of a session are, and leaves them where it ends.
    pub(crate) async fn advance_session(
        &self,
        advance: AdvanceSessionRequest,
        timeout: Option<Duration>,
        as_lists: bool,
        memory: Arc<Shares>,
    ) -> Result<Whole> {
        self.reach_session(&advance.name).await?;
        self.dispatch.advance_session(advance, timeout, as_lists, memory).await
    }

    /// Brings slots of a session closer to an observation; the reply with its memory.
    pub(crate) async fn correct_session(
        &self,
        correct: CorrectSessionRequest,
        timeout: Option<Duration>,
        as_lists: bool,
    ) -> Result<(CorrectedSession, ReplyHold)> {
        self.reach_session(&correct.name).await?;
        self.dispatch.correct_session(correct, timeout, as_lists).await
    }

    /// Takes pictures of slots of a session; the reply with its memory.
    pub(crate) async fn render_session(
        &self,
        render: RenderSessionRequest,
        timeout: Option<Duration>,
        as_lists: bool,
    ) -> Result<(RenderedSession, ReplyHold)> {
        self.reach_session(&render.name).await?;
        self.dispatch.render_session(render, timeout, as_lists).await
    }

    /// Takes a step of a closed loop: a correction, a plan and an advance.
    pub(crate) async fn step_session(&self, step: Step) -> Result<Stepped> {
        self.reach_session(&step.request.name).await?;
        self.dispatch.step_session(step).await
    }

    /// Ends a session; it is no error if it has ended.
    pub(crate) async fn close_session(
        &self,
        close: CloseSessionRequest,
        timeout: Option<Duration>,
    ) -> Result<()> {
        match self.reach::<SessionId>(Scope::RolloutsRun, &close.name).await {
            Err(Error::SessionLost(_)) => return Ok(()),
            reached => reached?,
        };
        self.dispatch.close_session(close, timeout).await
    }
}
