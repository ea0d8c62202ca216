//! Plays, and what they call: the use cases of sessions and plans, on behalf of the client that began
//! the play.

use std::{sync::Arc, time::Duration};

use bendtwin_core::ids::TwinId;
use bendtwin_play::{Begin, Error as PlayError, Host, Play, Player, View};
use bendtwin_proto::{
    v1::{
        AdvanceSessionRequest, CloseSessionRequest, GetSessionStatesRequest, OpenSessionRequest,
        PlanRequest, ResetSessionRequest, RollOutResponse, initial_state::GivenState,
    },
    worker::v1::manage_session_request::Call,
};
use futures::{FutureExt as _, StreamExt as _, future::BoxFuture};

use super::super::{App, Error, Plan, Result};
use crate::{
    access::{Limited, Scope},
    app::shares::Seat,
    context::Context,
};

impl App {
    /// The twin of a name, if the caller may play with it.
    pub(crate) async fn twin_to_play(&self, name: &str) -> Result<TwinId> {
        let twin: TwinId = self.reach(Scope::RolloutsRun, name).await?;
        Ok(self.store.twins().get(twin).await?.id)
    }

    /// Begins a play of a twin. `problem` makes the document that shows an error to the client.
    pub(crate) async fn begin_play(
        &self,
        twin: TwinId,
        begin: Begin,
        problem: fn(Error, &Context) -> serde_json::Value,
    ) -> Result<Player> {
        self.plays.require_room()?;
        let seat = self.share_seat()?;
        let geometry = self.geometry_of(twin, false).await?.message;
        let context = Context::current();
        let host = Arc::new(PlayHost { app: self.clone(), context, problem, _seat: seat });
        Ok(self.plays.begin(host, twin, &geometry, begin).await?)
    }

    /// A play that is under way.
    pub(crate) async fn play(&self, name: &str) -> Result<Arc<Play>> {
        Ok(self.plays.get(self.reach(Scope::RolloutsRun, name).await?)?)
    }

    /// The view of a watcher of a play.
    pub(crate) async fn watch_play(&self, name: &str) -> Result<View> {
        Ok(self.plays.watch(self.reach(Scope::RolloutsRun, name).await?)?)
    }
}

/// The server as plays see it.
struct PlayHost {
    app: App,
    /// The context of the request that began the play.
    context: Context,
    problem: fn(Error, &Context) -> serde_json::Value,
    /// The seat of a play that was begun with a share.
    _seat: Option<Seat>,
}

impl PlayHost {
    /// Makes a call for the client. On the heap: the future of a rollout is large.
    fn call<'a, T>(
        &self,
        call: impl Future<Output = Result<T>> + Send + 'a,
    ) -> BoxFuture<'a, Result<T, PlayError>> {
        self.context.clone().scope(call).map(|called| called.map_err(PlayError::from)).boxed()
    }
}

impl Host for PlayHost {
    fn owner(&self) -> &str {
        &self.context.caller.owner
    }

    fn open_session(
        &self,
        request: OpenSessionRequest,
        limit: Duration,
    ) -> BoxFuture<'_, Result<String, PlayError>> {
        self.call(async move { Ok(self.app.open_session(request, Some(limit)).await?.name) })
    }

    fn session_state(
        &self,
        session: String,
        limit: Duration,
    ) -> BoxFuture<'_, Result<GivenState, PlayError>> {
        let asked = GetSessionStatesRequest { name: session, slots: Vec::new() };
        self.call(async move {
            let (states, _held) = self.app.session_states(asked, Some(limit), false).await?;
            Ok(states.states.unwrap_or_default())
        })
    }

    fn advance_session(
        &self,
        request: AdvanceSessionRequest,
        limit: Duration,
    ) -> BoxFuture<'_, Result<RollOutResponse, PlayError>> {
        let advanced = self.app.advance_session(request, Some(limit), false, Arc::default());
        self.call(async move { Ok(advanced.await?.response) })
    }

    fn reset_session(
        &self,
        request: ResetSessionRequest,
        limit: Duration,
    ) -> BoxFuture<'_, Result<(), PlayError>> {
        self.call(async move {
            let name = request.name.clone();
            self.app.session_call(&name, Call::Reset(request), Some(limit)).await.map(drop)
        })
    }

    fn close_session(
        &self,
        session: String,
        limit: Duration,
    ) -> BoxFuture<'_, Result<(), PlayError>> {
        let close = CloseSessionRequest { name: session };
        self.call(self.app.close_session(close, Some(limit)))
    }

    fn plan(
        &self,
        request: PlanRequest,
        limit: Duration,
    ) -> BoxFuture<'_, Result<bendtwin_play::Updates, PlayError>> {
        if let Some(share) = self.context.caller.share {
            // A search takes as much as many plays do.
            let refused = Error::from(Limited::ToTwin(share.twin));
            return std::future::ready(Err(refused.into())).boxed();
        }
        let plan = Plan { request, timeout: Some(limit), as_lists: false, memory: Arc::default() };
        self.call(async move {
            let updates = self.app.plan(plan).await?;
            Ok(updates.map(|update| update.map_err(PlayError::from)).boxed())
        })
    }

    fn problem(&self, error: PlayError) -> serde_json::Value {
        (self.problem)(error.into(), &self.context)
    }
}
