//! Heartbeats of this worker, to one server and to every server that watches.

use std::{
    pin::Pin,
    sync::{
        Mutex, MutexGuard, OnceLock, PoisonError,
        atomic::{AtomicU64, Ordering},
    },
    time::Duration,
};

use bendtwin_core::ids::TwinId;
use bendtwin_proto::worker::v1::{HeartbeatRequest, WatchResponse, lease_job_request::Kind};
use futures::{Stream, StreamExt as _, stream};
use tokio::sync::watch;
use tokio_util::sync::CancellationToken;
use tonic::Status;

use super::Rollouts;
use crate::job::LeasedJob;

/// Least time between two messages to one server.
const PAUSE: Duration = Duration::from_millis(20);
/// Bounds of the interval that a server asks for, and the one where it asks for none [s].
const INTERVAL_S: [f64; 2] = [0.05, 60.0];
const DEFAULT_S: f64 = 5.0;

/// Messages to a server that watches.
pub(super) type StatusStream = Pin<Box<dyn Stream<Item = Result<WatchResponse, Status>> + Send>>;

/// Facts that rollouts do not know of, and whether anything changed.
#[derive(Debug, Default)]
pub(super) struct WorkerStatus {
    changes: watch::Sender<()>,
    facts: Mutex<Facts>,
    /// Memory that a fit may take; zero if this worker takes none [bytes].
    fit_bytes: AtomicU64,
    ended: OnceLock<CancellationToken>,
}

#[derive(Debug, Default)]
struct Facts {
    warm: Vec<TwinId>,
    /// fits/{uuid} under way; empty without a fit.
    fit: String,
    /// captures/{uuid} whose ingest is under way; empty without an ingest.
    ingest: String,
}

impl Facts {
    fn of(&mut self, kind: Kind) -> &mut String {
        if kind == Kind::Fit { &mut self.fit } else { &mut self.ingest }
    }
}

impl WorkerStatus {
    /// Notifies the watching servers.
    pub(super) fn changed(&self) {
        self.changes.send_replace(());
    }

    /// Notifies the watching servers if other twins are loaded than before.
    pub(super) fn has_warm(&self, mut twins: Vec<TwinId>) {
        twins.sort_unstable();
        let mut facts = self.facts();
        if facts.warm != twins {
            facts.warm = twins;
            self.changed();
        }
    }

    /// Ends the notifications with this token.
    pub(super) fn end_with(&self, token: CancellationToken) {
        // It is set once, by the one service.
        let _ = self.ended.set(token);
    }

    fn facts(&self) -> MutexGuard<'_, Facts> {
        self.facts.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// A job in the heartbeats; dropping it reports the job's end.
pub(crate) struct StatusGuard {
    rollouts: Rollouts,
    kind: Kind,
}

impl Drop for StatusGuard {
    fn drop(&mut self) {
        self.rollouts.set_job(self.kind, String::new());
    }
}

impl Rollouts {
    /// Sets the memory that a fit may take; zero if this worker takes none [bytes].
    pub(crate) fn set_fit_bytes(&self, bytes: u64) {
        self.inner().status.fit_bytes.store(bytes, Ordering::Relaxed);
    }

    /// Reports a job to servers, until the returned value is dropped.
    pub(crate) fn at_work(&self, kind: Kind, job: &LeasedJob) -> StatusGuard {
        let shown = if kind == Kind::Fit { job.name() } else { job.capture() };
        self.set_job(kind, shown.to_owned());
        StatusGuard { rollouts: self.clone(), kind }
    }

    fn set_job(&self, kind: Kind, job: String) {
        let status = &self.inner().status;
        *status.facts().of(kind) = job;
        status.changed();
    }

    /// The current heartbeat.
    pub(crate) fn heartbeat(&self) -> HeartbeatRequest {
        let inner = self.inner();
        let memory = inner.device.memory();
        let (fit, ingest) = {
            let facts = inner.status.facts();
            (facts.fit.clone(), facts.ingest.clone())
        };
        HeartbeatRequest {
            worker: inner.worker.clone(),
            warm_twins: inner.twins.ids().iter().map(ToString::to_string).collect(),
            rollouts_in_flight: u32::try_from(self.in_flight()).unwrap_or(u32::MAX),
            memory_used_bytes: memory.map_or(0, |m| m.used),
            memory_total_bytes: memory.map_or(0, |m| m.total),
            fit_memory_bytes: inner.status.fit_bytes.load(Ordering::Relaxed),
            sessions: inner.sessions.list(),
            fit,
            ingest,
        }
    }

    /// Heartbeats sent to a watching server: immediately, with every change, and at this interval
    /// [s].
    pub(super) fn statuses(&self, interval_s: f64) -> StatusStream {
        let [least, most] = INTERVAL_S;
        let asked = interval_s.is_finite() && interval_s > 0.0;
        let interval_s = if asked { interval_s.clamp(least, most) } else { DEFAULT_S };
        let interval = Duration::from_secs_f64(interval_s);
        let status = &self.inner().status;
        let (changes, ended) = (status.changes.subscribe(), status.ended.get().cloned());
        let begun = (self.clone(), changes, ended.unwrap_or_default(), false);
        let statuses =
            stream::unfold(begun, move |(rollouts, mut changes, ended, waits)| async move {
                if waits {
                    tokio::time::sleep(PAUSE).await;
                    tokio::select! {
                        () = ended.cancelled() => return None,
                        _ = changes.changed() => {}
                        () = tokio::time::sleep(interval) => {}
                    }
                }
                changes.borrow_and_update();
                let status = WatchResponse { heartbeat: Some(rollouts.heartbeat()) };
                Some((Ok(status), (rollouts, changes, ended, true)))
            });
        statuses.boxed()
    }
}
