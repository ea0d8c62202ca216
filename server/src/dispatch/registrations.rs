//! The way of registrations: as of rollouts, to a worker that has the twin loaded and time for it, in
//! whose line they wait.

use std::{sync::Arc, time::Duration};

use bendtwin_contract::{registration, rollout::TwinShape};
use bendtwin_core::ids::TwinId;
use bendtwin_proto::{
    v1::{RegisterStateRequest, RegisteredState},
    worker::v1::ExecuteRegisterStateRequest,
};
use tokio::time::Instant;

use super::{Dispatch, call, line::Ask, registry::Entry, rollout::ReplyHold};
use crate::{
    context::Context,
    error::{Error, Result},
    memory::Shares,
};

/// Longest time of a registration without a deadline.
const LONGEST: Duration = Duration::from_secs(600);

/// A registration to be routed.
pub(crate) struct Register {
    pub(crate) request: RegisterStateRequest,
    /// Time that the caller allows, if it said.
    pub(crate) timeout: Option<Duration>,
    /// True if the reply is to be written as nested lists of JSON.
    pub(crate) as_lists: bool,
    /// Memory of the request, held until a worker answers.
    pub(crate) memory: Arc<Shares>,
}

/// A registered state, and what is held until it has been sent.
pub(crate) struct Registered {
    pub(crate) state: RegisteredState,
    pub(crate) held: ReplyHold,
}

impl Dispatch {
    /// The state of a twin that explains an observation.
    pub(crate) async fn register_state(&self, register: Register) -> Result<Registered> {
        let Register { request, timeout, as_lists, memory } = register;
        let deadline = Instant::now() + timeout.unwrap_or(LONGEST).min(LONGEST);
        let twin: TwinId = request.twin.parse().map_err(Error::Name)?;
        let known = self.twins.get(&self.store, twin).await?;
        let request = self.checked_registration(request, known.shape).await?;
        let reply_bytes = registration::reply_bytes(&known.shape);
        if as_lists {
            self.fits_lists(reply_bytes)?;
        }
        let work = registration::registration_work(&request, &known.shape) as f64;
        let ask = Ask::of_caller(work);
        let share = tokio::time::timeout_at(deadline, self.memory.reply(reply_bytes));
        let share = share.await.map_err(|_| Error::Deadline)??;
        let execute = ExecuteRegisterStateRequest {
            request: Some(request),
            capture: known.capture.map(|c| c.to_string()).unwrap_or_default(),
            request_id: Context::current().request_id,
        };
        let state = self.at_a_worker(twin, &ask, None, |entry| {
            let (execute, ask) = (execute.clone(), ask.clone());
            async move { register_at(&entry, &ask, execute, deadline).await }
        });
        let state =
            tokio::time::timeout_at(deadline, state).await.map_err(|_| Error::Deadline)??;
        drop(memory);
        Ok(Registered { state, held: ReplyHold::of(share) })
    }

    /// The request, if it is valid. Many points are checked in a separate thread.
    async fn checked_registration(
        &self,
        request: RegisterStateRequest,
        twin: TwinShape,
    ) -> Result<RegisterStateRequest> {
        let limits = self.limits.rollout;
        let checked = tokio::task::spawn_blocking(move || {
            registration::check_registration(&request, &twin, &limits)?;
            Ok(request)
        });
        checked.await.map_err(|e| Error::Internal(format!("the check of a registration: {e}")))?
    }
}

/// `None` if the worker cannot be reached, so that it has not taken the registration.
async fn register_at(
    entry: &Arc<Entry>,
    ask: &Ask,
    execute: ExecuteRegisterStateRequest,
    deadline: Instant,
) -> Result<Option<RegisteredState>> {
    let joined = entry.line.join(ask);
    let mut place = joined.map_err(|full| Error::Busy { retry_after: full.retry_after })?;
    place.turn().await;
    let sent = call::send(entry, execute, deadline, |mut client, request| async move {
        client.register_state(request).await
    });
    let Some((reply, mut taken)) = sent.await? else { return Ok(None) };
    taken.answered();
    let missing = || Error::Internal("a worker's reply has no state".to_owned());
    let registered = reply.registered.ok_or_else(missing)?;
    Ok(Some(RegisteredState { worker: entry.id().to_string(), ..registered }))
}
