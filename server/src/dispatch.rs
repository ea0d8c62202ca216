//! The workers that are there, and the routing of rollouts to them. All of it
//! is in memory: a worker that the server forgot registers again.

mod registry;
mod rollout;
mod route;
mod twins;

use std::{
    collections::HashMap,
    sync::{Arc, Mutex, MutexGuard, PoisonError},
    time::Duration,
};

use bendtwin_core::ids::{TwinId, WorkerId};
use bendtwin_store::{Job, Kind, Store, Worker};
use tokio::time::Instant;

use crate::{
    failure::{Error, Result},
    metrics::Metrics,
    options::{Limits, Options},
    tokens::Child,
};

use registry::Entry;
pub(crate) use registry::{Heartbeat, Memory, WorkerView};
pub(crate) use rollout::RollOut;
use twins::Twins;

/// The routing table. Clones share it.
#[derive(Clone, Debug)]
pub(crate) struct Dispatch {
    store: Store,
    limits: Limits,
    metrics: Metrics,
    heartbeat_interval: Duration,
    workers: Arc<Mutex<HashMap<WorkerId, Arc<Entry>>>>,
    twins: Twins,
}

impl Dispatch {
    pub(crate) fn new(options: &Options, store: Store, metrics: Metrics) -> Self {
        Self {
            store,
            limits: options.limits.clone(),
            metrics,
            heartbeat_interval: options.heartbeat_interval(),
            workers: Arc::default(),
            twins: Twins::default(),
        }
    }

    /// Adds a worker; `token` is what it expects to be shown.
    pub(crate) fn add(&self, worker: Worker, child: Option<Child>, token: &str) -> Result<()> {
        let id = worker.registration.id;
        let entry = Entry::new(worker, child, token, &self.limits, self.store.now())?;
        self.lock().insert(id, Arc::new(entry));
        Ok(())
    }

    pub(crate) fn remove(&self, worker: WorkerId) {
        self.lock().remove(&worker);
    }

    pub(crate) fn knows(&self, worker: WorkerId) -> bool {
        self.lock().contains_key(&worker)
    }

    /// The worker of whom this holds.
    pub(crate) fn find(&self, holds: impl Fn(WorkerId) -> bool) -> Option<WorkerId> {
        self.lock().keys().copied().find(|id| holds(*id))
    }

    /// A sign of life. False if the worker has to register first.
    pub(crate) fn heartbeat(&self, worker: WorkerId, heartbeat: Heartbeat) -> bool {
        let entry = self.lock().get(&worker).cloned();
        let Some(entry) = entry else { return false };
        entry.heartbeat(self.store.now(), heartbeat);
        true
    }

    /// Notes the job of a kind that a worker is at.
    pub(crate) fn set_job(&self, worker: WorkerId, kind: Kind, job: Option<&Job>) {
        let Some(entry) = self.lock().get(&worker).cloned() else { return };
        let mut live = entry.live();
        match kind {
            Kind::Ingest => live.ingest = job.map(|j| j.capture),
            Kind::Fit => live.fit = job.and_then(|j| j.id.fit()),
        }
    }

    /// Workers without a sign of life for so long.
    pub(crate) fn silent(&self, span: Duration) -> Vec<WorkerId> {
        let now = Instant::now();
        let silent = |e: &Entry| now.duration_since(e.live().last_heartbeat) > span;
        self.lock().iter().filter(|(_, e)| silent(e)).map(|(id, _)| *id).collect()
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
        (workers.len(), workers.values().map(|e| e.load()).sum())
    }

    /// Memory of all workers' devices together, as far as it is known.
    pub(crate) fn memory(&self) -> Memory {
        let workers = self.lock();
        workers.values().filter_map(|e| e.view().memory).fold(Memory::default(), |sum, m| Memory {
            used: sum.used.saturating_add(m.used),
            total: sum.total.saturating_add(m.total),
        })
    }

    pub(crate) fn forget_twin(&self, id: TwinId) {
        self.twins.forget(id);
    }

    /// The worker to send a rollout of this twin to; `tried` have failed it.
    fn choose(&self, twin: TwinId, tried: &[WorkerId]) -> Result<Arc<Entry>> {
        let entries: Vec<Arc<Entry>> = self.lock().values().cloned().collect();
        let fresh = self.heartbeat_interval * 3;
        let candidates: Vec<route::Candidate> = entries
            .iter()
            .map(|e| e.candidate(twin, fresh))
            .map(|c| route::Candidate { usable: c.usable && !tried.contains(&c.worker), ..c })
            .collect();
        let bounds = route::Bounds {
            running: self.limits.rollouts_per_worker,
            waiting: self.limits.rollout_queue,
        };
        match route::choose(twin, &candidates, bounds) {
            route::Choice::Worker(i) => entries.get(i).cloned().ok_or(Error::NoWorker),
            route::Choice::AllFull => Err(Error::Busy { waiting: self.limits.rollout_queue }),
            route::Choice::NoneThere => Err(Error::NoWorker),
        }
    }

    fn lock(&self) -> MutexGuard<'_, HashMap<WorkerId, Arc<Entry>>> {
        self.workers.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
