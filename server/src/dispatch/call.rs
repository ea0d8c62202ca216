//! A call from the server to a worker, for any method: with the worker's token, the length of the
//! body, for which the worker takes memory before it reads it, and the time that is left; and the
//! meaning of its failure.

use std::{sync::Arc, time::Duration};

use bendtwin_contract::rollout::{ACCOUNT, REQUEST_BYTES};
use bendtwin_proto::{fault, worker::v1::worker_rollouts_client::WorkerRolloutsClient};
use prost::Message;
use tokio::time::Instant;
use tonic::{Code, Request, Response, Status, transport::Channel};
use tonic_types::StatusExt as _;

use super::{executing::SentCall, registry::Entry, untaken::was_not_taken};
use crate::{
    context::Context,
    error::{Error, Result},
};

/// A call that a worker has taken.
pub(super) struct TakenCall {
    pub(super) entry: Arc<Entry>,
    sent: SentCall,
    pub(super) deadline: Instant,
}

/// Sends a message to a worker. None if the worker cannot be reached, so that it has not taken the
/// call.
pub(super) async fn send<M, T, F>(
    entry: &Arc<Entry>,
    message: M,
    deadline: Instant,
    method: impl FnOnce(WorkerRolloutsClient<Channel>, Request<M>) -> F,
) -> Result<Option<(T, TakenCall)>>
where
    M: Message,
    F: Future<Output = Result<Response<T>, Status>>,
{
    let (client, token) = entry.client();
    let length = message.encoded_len();
    let mut request = Request::new(message);
    request.metadata_mut().insert(REQUEST_BYTES, length.into());
    request.metadata_mut().insert("authorization", token);
    // A hash, because names of owners are free text.
    let account = blake3::hash(Context::current().caller.owner.as_bytes()).to_hex();
    if let Ok(account) = account[..16].parse() {
        request.metadata_mut().insert(ACCOUNT, account);
    }
    if let Some(parent) = Context::current().trace_parent().and_then(|p| p.parse().ok()) {
        request.metadata_mut().insert(bendtwin_telemetry::HEADER, parent);
    }
    request.set_timeout(deadline.saturating_duration_since(Instant::now()));
    let sent = entry.executing.send();
    let mut taken = TakenCall { entry: Arc::clone(entry), sent, deadline };
    match method(client, request).await {
        Ok(reply) => Ok(Some((reply.into_inner(), taken))),
        Err(status) if was_not_taken(&status) => {
            taken.answered();
            if is_late(deadline) { Err(late(&status)) } else { Ok(None) }
        }
        Err(status) => Err(taken.ended(&status)),
    }
}

impl TakenCall {
    /// The worker has answered it in full.
    pub(super) fn answered(&mut self) {
        self.sent.answered();
    }

    /// The error of the call, from the status in which it ended.
    pub(super) fn ended(&mut self, status: &Status) -> Error {
        if is_late(self.deadline) {
            return late(status);
        }
        if is_breakdown(status) {
            tracing::warn!(worker = %self.entry.id(), %status, "worker broke down during a call");
            self.entry.broke();
            return Error::WorkerEnded;
        }
        self.answered();
        match status.code() {
            Code::DeadlineExceeded => Error::Deadline,
            _ => Error::Worker(fault::fault(status)),
        }
    }
}

/// True if the deadline is over, within the precision of two timers. Both ends of the call to the
/// worker give up then, with various codes.
fn is_late(deadline: Instant) -> bool {
    const SLACK: Duration = Duration::from_millis(2);
    Instant::now() + SLACK >= deadline
}

fn late(status: &Status) -> Error {
    tracing::debug!(%status, "deadline passed");
    Error::Deadline
}

/// True if the worker or the way to it broke, as opposed to its having answered with an error:
/// answers carry an `ErrorInfo`.
fn is_breakdown(status: &Status) -> bool {
    let broken = matches!(
        status.code(),
        Code::Unavailable | Code::Unknown | Code::Internal | Code::Cancelled
    );
    broken && status.get_details_error_info().is_none()
}
