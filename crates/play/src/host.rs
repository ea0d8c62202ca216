//! The host of plays, which has sessions and a planner.

use std::time::Duration;

use bendtwin_proto::v1::{
    AdvanceSessionRequest, OpenSessionRequest, PlanRequest, PlanUpdate, ResetSessionRequest,
    RollOutResponse, initial_state::GivenState,
};
use futures::{future::BoxFuture, stream::BoxStream};

use crate::{Error, Result};

/// Updates of a plan as they come.
pub type Updates = BoxStream<'static, Result<PlanUpdate>>;

/// The calls that a play makes, each on behalf of the client that began it and within a time limit.
pub trait Host: Send + Sync {
    /// Owner of the key of that client; empty if it is not known.
    fn owner(&self) -> &str;

    /// Opens a session with one slot. Returns its name.
    fn open_session(
        &self,
        request: OpenSessionRequest,
        limit: Duration,
    ) -> BoxFuture<'_, Result<String>>;

    /// The state of a session's slot.
    fn session_state(&self, session: String, limit: Duration) -> BoxFuture<'_, Result<GivenState>>;

    /// Simulates frames from where a session is, and leaves it where they end.
    fn advance_session(
        &self,
        request: AdvanceSessionRequest,
        limit: Duration,
    ) -> BoxFuture<'_, Result<RollOutResponse>>;

    /// Sets a session to a state.
    fn reset_session(
        &self,
        request: ResetSessionRequest,
        limit: Duration,
    ) -> BoxFuture<'_, Result<()>>;

    /// Ends a session; it is no error if it has ended.
    fn close_session(&self, session: String, limit: Duration) -> BoxFuture<'_, Result<()>>;

    /// Searches for actions. Dropping the updates ends the search.
    fn plan(&self, request: PlanRequest, limit: Duration) -> BoxFuture<'_, Result<Updates>>;

    /// The document that shows an error to the client.
    fn problem(&self, error: Error) -> serde_json::Value;
}
