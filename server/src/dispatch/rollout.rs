//! The steps of a rollout: check it, choose a worker, wait for a slot, pass the parts on. A worker
//! that cannot be reached is replaced once. A worker that took the rollout and broke down is not:
//! the rollout may be the cause, and would end the next worker, too. A disconnected caller drops
//! the stream, and with it the worker's work.

use std::{pin::Pin, sync::Arc, time::Duration};

use bendtwin_budget::Share;
use bendtwin_contract::rollout::{self, Batch, SessionParts, TwinShape};
use bendtwin_core::ids::{SessionId, TwinId};
use bendtwin_proto::{
    v1::{RollOutRequest, RollOutResponse, roll_out_response},
    worker::v1::{ExecuteRollOutRequest, ExecuteRollOutResponse},
};
use futures::{Stream, StreamExt, stream};
use prost::Message as _;
use tokio::time::Instant;
use tonic::{Status, Streaming};

use super::{
    Dispatch,
    call::{self, TakenCall},
    line::{Ask, Place},
    registry::Entry,
};
use crate::{
    context::Context,
    error::{Error, Result},
    memory::Shares,
    metrics::Metrics,
};

/// Size of a request beyond which it is checked beside other work [bytes]: a hundred megabytes of
/// actions take a while.
const LARGE: usize = 1 << 20;
/// Cost of a gradient beside that of a rollout.
const GRADIENT_COST: f64 = 3.0;
/// Longest time of a rollout without a deadline.
pub(super) const LONGEST: Duration = Duration::from_secs(3600);

/// A rollout to be routed.
pub(crate) struct RollOut {
    pub(crate) request: RollOutRequest,
    /// Time that the caller allows, if it said.
    pub(crate) timeout: Option<Duration>,
    /// True if the reply may come in parts.
    pub(crate) in_parts: bool,
    /// True if the reply is to be written as nested lists of JSON.
    pub(crate) as_lists: bool,
    /// Slots of the session it begins in that take over the final states; empty: none do.
    pub(crate) commit_slots: Vec<u32>,
    /// Memory of the request, held until a worker answers.
    pub(crate) memory: Arc<Shares>,
}

/// A rollout that has passed the check.
pub(super) struct CheckedRollOut {
    pub(super) twin: TwinId,
    pub(super) shape: TwinShape,
    /// The session that it begins in, and its worker: no other has the state.
    pub(super) session: Option<(SessionId, Arc<Entry>)>,
    pub(super) batch: Batch,
    pub(super) ask: Ask,
    pub(super) execute: ExecuteRollOutRequest,
    pub(super) ends: Ends,
    /// Size of its reply, or of one part of that.
    pub(super) reply_bytes: u64,
    /// Memory of the request, held until workers have all of it.
    pub(super) memory: Arc<Shares>,
}

/// Ends of a rollout's time.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ends {
    /// Time after which no caller waits for the reply.
    pub(super) deadline: Instant,
    /// No more instances are simulated, if the request has a time limit.
    pub(super) limit: Option<Instant>,
}

impl Ends {
    /// Seconds that are left of the time limit.
    fn time_left_s(self) -> f64 {
        let left = |end: Instant| end.saturating_duration_since(Instant::now()).as_secs_f64();
        self.limit.map_or(0.0, left)
    }
}

/// Held until a reply has been sent: its memory, and the place in the worker's line.
#[derive(Clone, Debug)]
pub(crate) struct ReplyHold {
    share: Arc<Share>,
    place: Option<Arc<Place>>,
}

impl ReplyHold {
    /// Memory of a reply whose workers have done with it.
    pub(super) fn of(share: Share) -> Self {
        Self { share: Arc::new(share), place: None }
    }

    /// The memory alone: the next rollout may start while this reply, written already, is sent.
    pub(crate) fn memory(self) -> Self {
        Self { place: None, ..self }
    }

    /// The memory, to be held with the bytes wherever they are, and the place, to be held by the
    /// body: what a connection has buffered and nobody reads must not keep a worker from others.
    pub(crate) fn apart(self) -> (Arc<Share>, impl Send + Sync + 'static) {
        (self.share, self.place)
    }
}

/// A reply in one part.
pub(crate) struct Whole {
    pub(crate) response: RollOutResponse,
    pub(crate) held: ReplyHold,
}

/// A reply in parts.
pub(crate) struct InParts {
    pub(crate) parts: Parts,
    pub(crate) held: ReplyHold,
}

/// Parts of a reply as they come.
pub(crate) type Parts = Pin<Box<dyn Stream<Item = Result<RollOutResponse>> + Send>>;

/// A reply under way at a worker.
pub(super) struct ReplyStream {
    replies: Streaming<ExecuteRollOutResponse>,
    taken: TakenCall,
    /// Held until the last part has arrived.
    place: Arc<Place>,
    started: Instant,
    queued: Duration,
    /// Time that the worker has computed, as it says [s].
    computed_s: f64,
    metrics: Metrics,
    outcome: &'static str,
}

/// Also counts the rollouts whose callers are gone.
impl Drop for ReplyStream {
    fn drop(&mut self) {
        self.metrics.rollout(self.outcome, self.queued, self.started.elapsed());
    }
}

impl Dispatch {
    /// The reply in one part. Workers are asked not to split it: `best` ranks
    /// the whole batch, and 16-bit positions have one scale. Several may share it.
    pub(crate) async fn roll_out(&self, rollout: RollOut) -> Result<Whole> {
        // Boxed: a request is large, and each of these steps has a place for it on the stack.
        let checked =
            Box::pin(self.checked_rollout(RollOut { in_parts: false, ..rollout })).await?;
        let sharers = self.sharers(&checked);
        if sharers.len() > 1 {
            return Box::pin(self.spread(checked, sharers)).await;
        }
        let InParts { mut parts, held } = Box::pin(self.by_one(checked)).await?;
        let response = parts.next().await.ok_or(Error::WorkerEnded)??;
        match parts.next().await {
            None => Ok(Whole { response, held }),
            Some(Ok(_)) => Err(Error::Internal("the worker split a reply".to_owned())),
            Some(Err(error)) => Err(error),
        }
    }

    /// The reply in the parts that the worker sends. The first has arrived when this returns.
    pub(crate) async fn parts(&self, rollout: RollOut) -> Result<InParts> {
        let checked = Box::pin(self.checked_rollout(rollout)).await?;
        Box::pin(self.by_one(checked)).await
    }

    /// Checks a rollout.
    async fn checked_rollout(&self, rollout: RollOut) -> Result<CheckedRollOut> {
        let arrived = Instant::now();
        let RollOut { mut request, timeout, in_parts, as_lists, commit_slots, memory } = rollout;
        let (session, parts) = self.session_of(&mut request).await?;
        let id: TwinId = request.twin.parse().map_err(Error::Name)?;
        let twin = self.twins.get(&self.store, id).await?;
        let part_instances = rollout::part_instances(&request, in_parts);
        let (request, batch) = self.checked(request, parts, twin.shape, part_instances).await?;
        let reply_bytes = rollout::reply_bytes(&request, &batch, &twin.shape, part_instances);
        if as_lists {
            self.fits_lists(reply_bytes)?;
        }
        let work = rollout::work(&request, &batch, &twin.shape) as f64 * passes(&request, &batch);
        let ask = Ask::of_caller(work);
        let limit = request.time_limit_s.and_then(|s| Duration::try_from_secs_f64(s).ok());
        let limit = limit.map(|time| arrived + time);
        let execute = ExecuteRollOutRequest {
            capture: twin.capture.map(|c| c.to_string()).unwrap_or_default(),
            part_instances,
            request_id: Context::current().request_id,
            request: Some(request),
            commit_slots,
            time_left_s: 0.0,
        };
        let deadline = Instant::now() + timeout.unwrap_or(LONGEST).min(LONGEST);
        let (twin, shape, ends) = (id, twin.shape, Ends { deadline, limit });
        Ok(CheckedRollOut { twin, shape, session, batch, ask, execute, ends, reply_bytes, memory })
    }

    /// The reply of one worker.
    async fn by_one(&self, checked: CheckedRollOut) -> Result<InParts> {
        let CheckedRollOut { twin, session, ask, execute, ends, reply_bytes, memory, .. } = checked;
        let deadline = ends.deadline;
        let share = tokio::time::timeout_at(deadline, self.memory.reply(reply_bytes));
        let share = share.await.map_err(|_| Error::Deadline)??;
        let started = async {
            match session {
                None => self.start(twin, &ask, execute, ends, None).await,
                Some(session) => self.start_in(&session, &ask, execute, ends).await,
            }
        };
        let (first, running) =
            tokio::time::timeout_at(deadline, started).await.map_err(|_| Error::Deadline)??;
        // The worker has all of the request.
        drop(memory);
        let place = Some(Arc::clone(&running.place));
        let held = ReplyHold { share: Arc::new(share), place };
        let rest = stream::unfold(Some(running), |running| async {
            let mut running = running?;
            match running.next().await {
                Ok(Some(part)) => Some((Ok(part), Some(running))),
                Ok(None) => None,
                Err(error) => Some((Err(error), None)),
            }
        });
        Ok(InParts { parts: stream::iter([Ok(first)]).chain(rest).boxed(), held })
    }

    /// Refuses a reply that is too large for nested lists of JSON.
    pub(super) fn fits_lists(&self, reply_bytes: u64) -> Result<()> {
        let limit = self.limits.rollout.json_reply_bytes;
        if reply_bytes <= limit {
            return Ok(());
        }
        Err(Error::Rollout(rollout::Error::TooLarge {
            what: "the size of the reply in bytes, as lists in JSON,",
            asked: reply_bytes,
            limit,
            advice: "ask for ?tensors=base64 or for application/x-protobuf, or for fewer points (returns.nodes or returns.skin_points) or every k-th frame (returns.every_frames)",
        }))
    }

    /// The request, if it is sound.
    async fn checked(
        &self,
        request: RollOutRequest,
        session: SessionParts,
        twin: TwinShape,
        part_instances: u32,
    ) -> Result<(RollOutRequest, Batch)> {
        let limits = self.limits.rollout;
        let is_large = request.encoded_len() > LARGE;
        let check = move || {
            let batch = rollout::check_in(&request, session, &twin, &limits, part_instances)?;
            Ok((request, batch))
        };
        if !is_large {
            return check();
        }
        let checked = tokio::task::spawn_blocking(check).await;
        checked.map_err(|e| Error::Internal(format!("the check of a rollout: {e}")))?
    }

    /// Gets a worker to send a first part, this one if it is given: a second one if the first cannot
    /// be reached.
    pub(super) async fn start(
        &self,
        twin: TwinId,
        ask: &Ask,
        execute: ExecuteRollOutRequest,
        ends: Ends,
        given: Option<Arc<Entry>>,
    ) -> Result<(RollOutResponse, ReplyStream)> {
        self.at_a_worker(twin, ask, given, |entry| {
            let execute = execute.clone();
            async move { self.start_at(&entry, ask, execute, ends).await }
        })
        .await
    }

    /// The result of an attempt at a worker, this one if it is given: at a second worker if the
    /// first cannot be reached (the attempt returns `None`), and at all others in turn while
    /// workers are busy, also with the work of other servers.
    pub(super) async fn at_a_worker<T, F>(
        &self,
        twin: TwinId,
        ask: &Ask,
        mut given: Option<Arc<Entry>>,
        attempt: impl Fn(Arc<Entry>) -> F,
    ) -> Result<T>
    where
        F: Future<Output = Result<Option<T>>>,
    {
        let (mut tried, mut lost, mut full) = (Vec::new(), false, None);
        loop {
            let chosen = given.take().map_or_else(|| self.choose(twin, ask, &tried), Ok);
            let entry = match chosen {
                Err(Error::NoWorker) if !tried.is_empty() => {
                    return Err(full.unwrap_or(Error::WorkerLost));
                }
                chosen => chosen?,
            };
            match attempt(Arc::clone(&entry)).await {
                Ok(Some(started)) => {
                    entry.warmed(twin);
                    return Ok(started);
                }
                Ok(None) => {
                    entry.broke();
                    if std::mem::replace(&mut lost, true) {
                        return Err(Error::WorkerLost);
                    }
                    tracing::warn!(worker = %entry.id(), "worker unreachable, trying another");
                }
                Err(error) => full = Some(refusal(error, &entry, ask)?),
            }
            tried.push(entry.id());
        }
    }

    /// `None` if the worker cannot be reached, so that it has not taken the rollout.
    pub(super) async fn start_at(
        &self,
        entry: &Arc<Entry>,
        ask: &Ask,
        mut execute: ExecuteRollOutRequest,
        ends: Ends,
    ) -> Result<Option<(RollOutResponse, ReplyStream)>> {
        let (started, deadline) = (Instant::now(), ends.deadline);
        // Others may have joined since the worker was chosen.
        let joined = entry.line.join(ask);
        let mut place = joined.map_err(|full| Error::Busy { retry_after: full.retry_after })?;
        place.turn().await;
        let place = Arc::new(place);
        let queued = started.elapsed();
        execute.time_left_s = ends.time_left_s();
        let sent = call::send(entry, execute, deadline, |mut client, request| async move {
            client.roll_out(request).await
        });
        let Some((replies, taken)) = sent.await? else { return Ok(None) };
        let metrics = self.metrics.clone();
        let (computed_s, outcome) = (0.0, "abandoned");
        let mut running =
            ReplyStream { replies, taken, place, started, queued, computed_s, metrics, outcome };
        match running.receive().await {
            Ok(Some(mut first)) => {
                let timing = first.timing.get_or_insert_with(Default::default);
                *timing = roll_out_response::Timing {
                    queue_s: timing.queue_s + queued.as_secs_f64(),
                    ..*timing
                };
                Ok(Some((first, running)))
            }
            Ok(None) => Err(Error::WorkerEnded),
            Err(status) => Err(running.taken.ended(&status)),
        }
    }
}

impl ReplyStream {
    /// The next part, within the deadline.
    pub(super) async fn next(&mut self) -> Result<Option<RollOutResponse>> {
        let received = tokio::time::timeout_at(self.taken.deadline, self.receive()).await;
        match received.map_err(|_| Error::Deadline)? {
            Ok(part) => Ok(part),
            Err(status) => Err(self.taken.ended(&status)),
        }
    }

    async fn receive(&mut self) -> Result<Option<RollOutResponse>, Status> {
        let worker = self.taken.entry.id();
        let part = self.replies.message().await;
        match &part {
            Ok(None) => {
                self.outcome = "done";
                self.taken.answered();
                // No worker computes for longer than it was asked to.
                let most = self.started.elapsed().as_secs_f64();
                self.place.computed(self.computed_s.min(most));
            }
            Err(_) => self.outcome = "failed",
            Ok(Some(_)) => {}
        }
        let Some(reply) = part? else { return Ok(None) };
        let response = reply.response.unwrap_or_default();
        self.computed_s = response.timing.map_or(0.0, |t| t.compute_s);
        Ok(Some(RollOutResponse { worker: worker.to_string(), ..response }))
    }
}

/// The error to return if no other worker takes a call that this one is too busy for; otherwise the
/// error that ends the call.
fn refusal(error: Error, entry: &Entry, ask: &Ask) -> Result<Error> {
    let Error::Worker(fault) = &error else { return Err(error) };
    match fault.reason.as_str() {
        "WORKER_BUSY" => Ok(Error::Busy { retry_after: entry.line.retry_after(ask) }),
        "MEMORY_IN_USE" | "TOO_MANY_SESSIONS" => Ok(error),
        _ => Err(error),
    }
}

/// Passes through a batch: gradients follow the rollouts, of all instances or of the best.
fn passes(request: &RollOutRequest, batch: &Batch) -> f64 {
    let Some(returns) = request.returns.as_ref().filter(|r| rollout::has_gradients(r)) else {
        return 1.0;
    };
    let share = match returns.best {
        0 => 1.0,
        best => (f64::from(best) / batch.instances.max(1) as f64).min(1.0),
    };
    1.0 + GRADIENT_COST * share
}
