//! A rollout under way, stage by stage: the message becomes a checked request, that a plan with its
//! starts, and that an execution whose parts are sent.

use std::{
    pin::Pin,
    sync::Arc,
    task::{Context, Poll},
    time::{Duration, Instant},
};

use bendtwin_contract::rollout;
use bendtwin_core::{CancelToken, Problem as _};
use bendtwin_engine::backend;
use bendtwin_proto::{
    fault,
    v1::RollOutResponse,
    worker::v1::{ExecuteRollOutRequest, ExecuteRollOutResponse},
};
use bendtwin_rollout::{Begun, Checked, Execution, Plan, Room, Served, Starts, Warm};
use futures::Stream;
use tokio::sync::{OwnedSemaphorePermit, mpsc};
use tokio_stream::wrappers::ReceiverStream;
use tonic::Status;

use super::{Inner, RequestHold, blocking};
use crate::{
    budget,
    device::{Account, QueuedBackend},
    rollout::error::Error,
};

/// Parts that may wait for a slow reader: backpressure, so memory stays bounded.
const WAITING_PARTS: usize = 2;

/// A rollout under way.
pub(super) struct RollOutCall {
    inner: Arc<Inner>,
    backend: Arc<QueuedBackend>,
    /// Held until the work has ended, also when the caller is gone.
    slot: Arc<OwnedSemaphorePermit>,
    arrived: Instant,
    cancel: CancelToken,
    parts: mpsc::Sender<Result<ExecuteRollOutResponse, Status>>,
    held: RequestHold,
}

/// A request that has passed the check, before its memory is taken.
struct CheckedCall {
    checked: Checked,
    warm: Arc<Warm>,
    /// Name of the capture that the twin was fitted to; empty if the request needs none.
    capture: String,
    /// The session that it begins in.
    begun: Option<Begun>,
    /// The states there.
    starts: Option<Starts>,
}

/// A plan whose memory has been taken.
struct PlannedCall {
    plan: Plan,
    starts: Starts,
    begun: Option<Begun>,
}

impl RollOutCall {
    /// The call, and the stream of its reply.
    pub(super) fn new(
        inner: Arc<Inner>,
        slot: OwnedSemaphorePermit,
        arrived: Instant,
        held: RequestHold,
        account: Option<&Account>,
    ) -> (Self, Parts) {
        let cancel = CancelToken::default();
        let (parts, receiver) = mpsc::channel(WAITING_PARTS);
        let stream = Parts { parts: ReceiverStream::new(receiver), cancel: cancel.clone() };
        let backend = Arc::new(inner.device.backend_for(account));
        (Self { inner, backend, slot: Arc::new(slot), arrived, cancel, parts, held }, stream)
    }

    pub(super) async fn serve(self, request: ExecuteRollOutRequest, deadline: Option<Instant>) {
        let request_id = request.request_id.clone();
        let work = self.work(request);
        let result = match deadline {
            None => work.await,
            Some(deadline) => {
                tokio::time::timeout_at(deadline.into(), work).await.unwrap_or(Err(Error::Deadline))
            }
        };
        if let Err(error) = result {
            // Stops the simulation too if it was the deadline.
            self.cancel.cancel();
            let fault = error.fault();
            tracing::info!(request_id, reason = fault.reason, "rollout refused: {fault}");
            let _ = self.parts.send(Err(fault::status(&fault))).await;
        }
        drop(self.slot);
    }

    async fn work(&self, request: ExecuteRollOutRequest) -> Result<(), Error> {
        let limit_s = request.request.as_ref().and_then(|request| request.time_limit_s);
        let until = limit_s.map(|_| self.arrived + seconds(request.time_left_s));
        let checked = self.check(request).await?;
        let planned = self.plan(checked).await?;
        self.execute(planned, until).await
    }

    /// Checks a request against its session, its twin and the limits.
    async fn check(&self, request: ExecuteRollOutRequest) -> Result<CheckedCall, Error> {
        let ExecuteRollOutRequest { request, capture, part_instances, commit_slots, .. } = request;
        let mut request = request.ok_or_else(|| Error::field("request", "is missing"))?;
        let inner = &self.inner;
        let begun = Begun::new(&inner.sessions, &mut request, commit_slots).await?;
        let twin = Error::parsed("twin", &request.twin)?;
        let fidelity = rollout::fidelity(request.fidelity)?;
        let warm = inner.twins.get(twin).await?;
        inner.status.has_warm(inner.twins.ids());
        let starts = begun.as_ref().map(Begun::starts);
        let rests = starts.as_ref().map(Starts::rests).unwrap_or_default();
        let limits = inner.limits();
        let lanes = inner.device.description().lanes;
        let room = Room { bytes: inner.memory.rollouts.most(), lanes };
        // Loading a model takes a while, and so does checking a hundred megabytes of actions.
        let (own, twin, on) = (capture.clone(), Arc::clone(&warm), Arc::clone(&self.backend));
        let checked = blocking(&self.held, move || {
            let served = Served::choose(twin, fidelity, &*on)?.with_rests(rests)?;
            Ok(Checked::new(request, &own, part_instances, served, &limits, room)?)
        })
        .await?;
        Ok(CheckedCall { checked, warm, capture, begun, starts })
    }

    /// Takes the memory of a checked request and plans it.
    async fn plan(&self, call: CheckedCall) -> Result<PlannedCall, Error> {
        let CheckedCall { checked, warm, capture, begun, starts } = call;
        let inner = &self.inner;
        // A preceding simulation takes its memory first.
        let request = checked.request();
        let (initial, world) = (request.initial.as_ref(), request.world.as_ref());
        let simulated =
            inner.simulated(&warm, initial, world, &capture, &self.backend, &self.cancel).await?;
        let before = starts.or(simulated.map(Starts::Shared));
        let advice = "the rollout: ask for less at once";
        let share = budget::take(&inner.memory.rollouts, checked.bytes(), advice).await?;
        // It is set here alone.
        let _ = self.held.rollout.set(share);
        let (on, cancel) = (Arc::clone(&self.backend), self.cancel.clone());
        let (mut plan, wanted) =
            blocking(&self.held, move || Ok(Plan::new(checked, &*on, &cancel)?)).await?;
        if begun.as_ref().is_some_and(Begun::commits) {
            let (bytes, advice) = (plan.surroundings_bytes(), "the surroundings: close sessions");
            plan.keep_surroundings(budget::take(&inner.memory.sessions, bytes, advice).await?);
        }
        let starts = plan.starts(wanted, before)?;
        Ok(PlannedCall { plan, starts, begun })
    }

    /// Executes a plan at the device, sends the parts of its reply, and commits its final states.
    async fn execute(&self, call: PlannedCall, until: Option<Instant>) -> Result<(), Error> {
        let PlannedCall { plan, starts, begun } = call;
        let (inner, backend) = (Arc::clone(&self.inner), Arc::clone(&self.backend));
        let (cancel, parts, arrived) = (self.cancel.clone(), self.parts.clone(), self.arrived);
        // A deadline ends the waiting, not this work: until it has heard, its place stays taken.
        let slot = Arc::clone(&self.slot);
        blocking(&self.held, move || {
            let _slot = slot;
            let execution = Execution {
                plan: &plan,
                starts: &starts,
                backend: &*backend,
                cancel: &cancel,
                until,
                arrived,
                worker: &inner.worker,
                keeps_states: begun.as_ref().is_some_and(Begun::commits),
            };
            let mut replies = Vec::new();
            let kept = execution.run(|response| {
                if execution.keeps_states {
                    // What was not committed is not answered.
                    replies.push(response);
                    return Ok(());
                }
                send(&parts, response)
            })?;
            if let Some(begun) = begun {
                begun.commit(kept, plan.frames())?;
            }
            Ok(replies.into_iter().try_for_each(|response| send(&parts, response))?)
        })
        .await
    }
}

/// A span of time; zero for an invalid number.
fn seconds(seconds: f64) -> Duration {
    Duration::try_from_secs_f64(seconds).unwrap_or_default()
}

/// Sends a part, if the caller still listens.
fn send(
    parts: &mpsc::Sender<Result<ExecuteRollOutResponse, Status>>,
    response: RollOutResponse,
) -> Result<(), bendtwin_rollout::Error> {
    let message = ExecuteRollOutResponse { response: Some(response) };
    parts.blocking_send(Ok(message)).map_err(|_| backend::Error::Cancelled.into())
}

/// The reply stream. Dropping it, as happens when the caller goes away, stops the simulation.
pub(crate) struct Parts {
    parts: ReceiverStream<Result<ExecuteRollOutResponse, Status>>,
    cancel: CancelToken,
}

impl Stream for Parts {
    type Item = Result<ExecuteRollOutResponse, Status>;

    fn poll_next(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<Option<Self::Item>> {
        Pin::new(&mut self.parts).poll_next(context)
    }
}

impl Drop for Parts {
    fn drop(&mut self) {
        self.cancel.cancel();
    }
}
