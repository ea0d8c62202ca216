//! The known workers, and the routing of rollouts to them. All of it is in memory: a worker that
//! the server forgot registers again. Workers of a fleet are followed (`follow.rs`), so that every
//! server knows what is loaded where, regardless of the server that they called.

mod call;
mod channel;
mod evaluations;
mod executing;
mod follow;
mod heartbeat;
mod line;
mod plan;
mod registrations;
mod registry;
mod rollout;
mod route;
mod sessions;
mod spread;
mod steps;
mod twins;
mod untaken;

use std::{
    collections::HashMap,
    sync::{Arc, Mutex, MutexGuard, PoisonError},
    time::Duration,
};

use bendtwin_core::ids::{TwinId, WorkerId};
use bendtwin_store::{Capabilities, Job, Kind, Store, Worker, WorkerEnd};
use bendtwin_tls::Connector;
use tokio_util::sync::CancellationToken;

use crate::{
    access::Child,
    error::{Error, Result},
    metrics::Metrics,
    options::{Limits, Options},
};

use line::Ask;
pub(crate) use line::Size;
pub(crate) use plan::{Plan, Updates};
pub(crate) use registrations::{Register, Registered};
use registry::{Entry, LastSign, Now};
pub(crate) use registry::{FitRoom, Heartbeat, HeldSession, Memory, WorkerView};
pub(crate) use rollout::{InParts, Parts, ReplyHold, RollOut, Whole};
pub(crate) use steps::{Step, Stepped};
use twins::Twins;

/// Outcome of learning of a worker.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Learned {
    /// This server may not use the worker.
    Unusable,
    /// The worker is known here, now or from before.
    Known,
    /// The worker has left since its row was read.
    Gone,
}

/// The routing table. Clones share it.
#[derive(Clone, Debug)]
pub(crate) struct Dispatch {
    store: Store,
    limits: Limits,
    metrics: Metrics,
    memory: crate::memory::Memory,
    heartbeat_interval: Duration,
    /// Token of workers that others start, if there may be such.
    worker_token: Option<Arc<str>>,
    workers: Arc<Mutex<HashMap<WorkerId, Arc<Entry>>>>,
    twins: Twins,
    dialer: Connector,
    /// Cancelled when the server begins to stop.
    stopping: CancellationToken,
}

impl Dispatch {
    pub(crate) fn new(
        options: &Options,
        store: Store,
        metrics: Metrics,
        memory: crate::memory::Memory,
        dialer: Connector,
        stopping: CancellationToken,
    ) -> Self {
        Self {
            store,
            limits: options.limits.clone(),
            metrics,
            memory,
            heartbeat_interval: options.heartbeat_interval(),
            worker_token: options.worker_token.as_deref().map(Arc::from),
            workers: Arc::default(),
            twins: Twins::default(),
            dialer,
            stopping,
        }
    }

    /// Adds a worker that has registered here; `token` is what it expects to be shown.
    pub(crate) fn add(&self, worker: Worker, child: Option<Child>, token: &str) -> Result<()> {
        let channel = channel::open(&worker.registration.endpoint, &self.dialer)?;
        let heard = LastSign::At(self.now());
        self.enter(Entry::new(worker, child, token, &self.limits, heard, channel)?);
        Ok(())
    }

    /// Adds a worker of the fleet, which has registered at another server, by its row, unless it is known.
    pub(crate) async fn learn(&self, worker: Worker) -> Result<Learned> {
        let Some(token) = self.worker_token.as_deref().filter(|_| !worker.is_supervised) else {
            return Ok(Learned::Unusable);
        };
        let known = self.lock().get(&worker.registration.id).cloned();
        let is_same =
            |e: Arc<Entry>| e.worker().registration.endpoint == worker.registration.endpoint;
        if known.is_some_and(is_same) {
            return Ok(Learned::Known);
        }
        let channel = channel::open(&worker.registration.endpoint, &self.dialer)?;
        let heard = LastSign::Never;
        let id = worker.registration.id;
        self.enter(Entry::new(worker, None, token, &self.limits, heard, channel)?);
        // A removal takes the row first and the entry afterwards: if the row is still there, a later
        // removal takes this entry, too.
        if self.store.workers().find(id).await?.is_some() {
            return Ok(Learned::Known);
        }
        self.remove(id);
        Ok(Learned::Gone)
    }

    fn enter(&self, entry: Entry) {
        let entry = Arc::new(entry);
        self.lock().insert(entry.id(), Arc::clone(&entry));
        if self.store.is_shared() && entry.child.is_none() {
            self.follow(&entry);
        }
    }

    pub(crate) fn remove(&self, worker: WorkerId) {
        self.lock().remove(&worker);
    }

    pub(crate) fn knows(&self, worker: WorkerId) -> bool {
        self.lock().contains_key(&worker)
    }

    /// The workers that are known here, each with its registration, and if it is a process of this
    /// server.
    pub(crate) fn known(&self) -> Vec<(Worker, bool)> {
        self.lock().values().map(|e| (e.worker().clone(), e.child.is_some())).collect()
    }

    /// Gives a worker no more work.
    pub(crate) fn drain(&self, worker: WorkerId) {
        if let Some(entry) = self.lock().get(&worker) {
            entry.draining.cancel();
        }
    }

    /// A token that is cancelled once a worker is to take no more work.
    pub(crate) fn draining(&self, worker: WorkerId) -> CancellationToken {
        self.lock().get(&worker).map(|e| e.draining.clone()).unwrap_or_default()
    }

    /// The worker that satisfies `holds`.
    pub(crate) fn find(&self, holds: impl Fn(WorkerId) -> bool) -> Option<WorkerId> {
        self.lock().keys().copied().find(|id| holds(*id))
    }

    /// A sign of life. False if the worker has to register first.
    pub(crate) fn heartbeat(&self, worker: WorkerId, heartbeat: Heartbeat) -> bool {
        let entry = self.lock().get(&worker).cloned();
        let Some(entry) = entry else { return false };
        self.take_in(&entry, heartbeat);
        true
    }

    /// A sign of life other than a heartbeat.
    pub(crate) fn seen(&self, worker: WorkerId) {
        if let Some(entry) = self.lock().get(&worker) {
            entry.seen(self.now());
        }
    }

    /// Notes the job of a kind that a worker is at.
    pub(crate) fn set_job(&self, worker: WorkerId, kind: Kind, job: Option<&Job>) {
        let entry = self.lock().get(&worker).cloned();
        if let Some(entry) = entry {
            entry.set_job(kind, job);
        }
    }

    /// Properties of a worker that jobs can ask for; those of none if it is not known.
    pub(crate) fn capabilities(&self, worker: WorkerId) -> Capabilities {
        self.lock().get(&worker).map(|entry| entry.capabilities()).unwrap_or_default()
    }

    /// Workers of this server alone without a sign of life for so long, by the time of leases: not
    /// after a standstill.
    pub(crate) fn silent(&self, span: Duration) -> Vec<WorkerId> {
        let (now, shared) = (self.store.lease_time(), self.store.is_shared());
        let is_silent = |e: &Entry| e.silence(now) > span && (e.child.is_some() || !shared);
        self.lock().iter().filter(|(_, e)| is_silent(e)).map(|(id, _)| *id).collect()
    }

    /// Time for which a worker gave no sign of life here.
    pub(crate) fn silence(&self, worker: WorkerId) -> Duration {
        let now = self.store.lease_time();
        self.lock().get(&worker).map_or(Duration::MAX, |e| e.silence(now))
    }

    /// Number of workers that lately gave a sign of life.
    pub(crate) fn answering(&self) -> usize {
        let now = self.store.lease_time();
        self.lock().values().filter(|e| e.silence(now) <= self.fresh()).count()
    }

    /// Reason for the loss of a worker's attempts, if it is gone.
    pub(crate) fn worker_end(&self, worker: WorkerId) -> WorkerEnd {
        let shared = self.store.is_shared();
        let was_at_rollouts =
            |e: &Arc<Entry>| e.executing.was_under_way() || shared && e.has_others_rollouts();
        match self.lock().get(&worker).is_some_and(was_at_rollouts) {
            true => WorkerEnd::DuringRollout,
            false => WorkerEnd::Lost,
        }
    }

    /// The workers that a child process registered as; more than one if it was quick.
    pub(crate) fn of_child(&self, child: Child) -> Vec<WorkerId> {
        self.lock().iter().filter(|(_, e)| e.child == Some(child)).map(|(id, _)| *id).collect()
    }

    /// All workers, newest first.
    pub(crate) fn views(&self) -> Vec<WorkerView> {
        let mut views: Vec<_> = self.lock().values().map(|e| e.view()).collect();
        views.sort_by_key(|v| std::cmp::Reverse(v.worker.registration.id));
        views
    }

    /// Number of workers, and of the rollouts that they are at.
    pub(crate) fn counts(&self) -> (usize, usize) {
        let workers = self.lock();
        (workers.len(), workers.values().map(|e| e.line.len()).sum())
    }

    /// Rollouts that wait, by [`Size`].
    pub(crate) fn waiting(&self) -> [usize; 3] {
        let lines = self.lock().values().map(|e| e.line.waiting()).collect::<Vec<_>>();
        Size::ALL.map(|size| lines.iter().map(|waiting| waiting[size as usize]).sum())
    }

    /// Number of sessions at all workers.
    pub(crate) fn session_count(&self) -> usize {
        self.lock().values().map(|e| e.session_count()).sum()
    }

    /// Memory of all workers' devices together, where it is known.
    pub(crate) fn memory(&self) -> Memory {
        let workers = self.lock();
        workers.values().filter_map(|e| e.view().memory).fold(Memory::default(), |sum, m| Memory {
            used: sum.used.saturating_add(m.used),
            total: sum.total.saturating_add(m.total),
        })
    }

    /// Capacity for a fit of each worker that has reported it.
    pub(crate) fn fit_rooms(&self) -> Vec<FitRoom> {
        self.lock().values().filter_map(|e| e.fit_room()).collect()
    }

    /// The owner of a twin; empty if it is not known.
    pub(crate) async fn twin_owner(&self, id: TwinId) -> Result<Arc<str>> {
        Ok(self.twins.get(&self.store, id).await?.owner)
    }

    pub(crate) fn forget_twin(&self, id: TwinId) {
        self.twins.forget(id);
    }

    /// The worker to send a rollout of this twin to; `tried` have failed it.
    fn choose(&self, twin: TwinId, ask: &Ask, tried: &[WorkerId]) -> Result<Arc<Entry>> {
        let entries: Vec<Arc<Entry>> = self.lock().values().cloned().collect();
        let (fresh, now) = (self.fresh(), self.store.lease_time());
        let candidates: Vec<route::Candidate> = entries
            .iter()
            .map(|e| e.candidate(twin, ask, e.silence(now) <= fresh))
            .map(|c| route::Candidate { usable: c.usable && !tried.contains(&c.worker), ..c })
            .collect();
        match route::choose(twin, &candidates) {
            route::Choice::Worker(i) => entries.get(i).cloned().ok_or(Error::NoWorker),
            route::Choice::NoneThere => Err(Error::NoWorker),
            route::Choice::AllFull => {
                let usable = entries.iter().zip(&candidates).filter(|(_, c)| c.usable);
                let waits = usable.map(|(e, _)| e.line.retry_after(ask));
                Err(Error::Busy { retry_after: waits.min().unwrap_or_default() })
            }
        }
    }

    /// Silence after which a worker is not asked for rollouts.
    fn fresh(&self) -> Duration {
        self.heartbeat_interval * 3
    }

    fn now(&self) -> Now {
        Now { day: self.store.now(), lease: self.store.lease_time() }
    }

    fn lock(&self) -> MutexGuard<'_, HashMap<WorkerId, Arc<Entry>>> {
        self.workers.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
