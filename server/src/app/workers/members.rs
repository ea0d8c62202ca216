//! The other servers of the same database, and the workers of the fleet that all of them share. A
//! server judges that another is gone by watching its row for the time of a lease, by its own time of
//! leases: neither a clock that is set nor a database that was away makes a living one look gone.

use std::{
    collections::{HashMap, HashSet},
    sync::{Mutex, PoisonError},
    time::Duration,
};

use bendtwin_core::ids::{ServerId, WorkerId};
use bendtwin_store::{Job, Server, Worker, WorkerEnd};
use uuid::Uuid;

use crate::{
    app::{App, Error, Result},
    dispatch::Learned,
};

/// The last sign of each member, and when it was first seen, by the time of leases.
#[derive(Debug, Default)]
pub(crate) struct Members(Mutex<State>);

#[derive(Debug, Default)]
struct State {
    signs: HashMap<Uuid, (i64, Duration)>,
    /// Last time at which this server notified the others of itself, or of a worker.
    announced: HashMap<Uuid, Duration>,
}

impl Members {
    /// Time for which a member has given the same sign.
    fn silence(&self, member: Uuid, sign: i64, now: Duration) -> Duration {
        let mut state = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let seen = state.signs.entry(member).or_insert((sign, now));
        if seen.0 != sign {
            *seen = (sign, now);
        }
        now.saturating_sub(seen.1)
    }

    /// True if the next notification about a member is due, which then counts as sent.
    fn is_due(&self, member: Uuid, every: Duration, now: Duration) -> bool {
        let mut state = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let due = state
            .announced
            .get(&member)
            .is_none_or(|announced| now.saturating_sub(*announced) >= every);
        if due {
            state.announced.insert(member, now);
        }
        due
    }

    /// Forgets all but these.
    fn keep(&self, there: &HashSet<Uuid>) {
        let mut state = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        state.signs.retain(|member, _| there.contains(member));
        state.announced.retain(|member, _| there.contains(member));
    }
}

impl App {
    /// Takes up the state that previous servers left. If this server is alone in its database, it
    /// requeues the jobs of their worker processes immediately: those ended with their server, and
    /// fencing rejects stragglers. Workers started by others are expected to be alive still, and
    /// get a full lease to report. Beside other servers it takes nothing from anyone:
    /// [`App::sweep`] does, once a server has been silent.
    pub(crate) async fn recover(&self) -> Result<()> {
        self.store.servers().seen(self.id, bendtwin_core::BUILD).await?;
        if self.store.is_shared() {
            return self.learn().await.map(drop);
        }
        for worker in self.store.workers().all().await? {
            let id = worker.registration.id;
            let added = match &self.options.worker_token {
                Some(token) if !worker.is_supervised => self.dispatch.add(worker, None, token),
                _ => Err(Error::WorkerUnknown(id.to_string())),
            };
            if let Err(error) = added {
                // It registers again if it is alive.
                tracing::info!(worker = %id, %error, "a worker of an earlier run is forgotten");
                self.forfeit(id, WorkerEnd::ByServer).await?;
            }
        }
        for server in self.others(self.store.servers().all().await?) {
            self.store.servers().forget(server.id).await?;
        }
        Ok(())
    }

    /// Takes over which workers are in the fleet, and which are to end. Returns all of them.
    pub(crate) async fn learn(&self) -> Result<Vec<Worker>> {
        // What registers here from now on may not be among the rows.
        let known = self.dispatch.known();
        let workers = self.store.workers().all().await?;
        let rows: HashSet<WorkerId> = workers.iter().map(|w| w.registration.id).collect();
        for worker in &workers {
            let id = worker.registration.id;
            // Unusable are the processes of other servers, which are never known here.
            let learned = match self.dispatch.learn(worker.clone()).await {
                Err(Error::Store(error)) => return Err(error.into()),
                learned => learned.unwrap_or_else(|error| {
                    tracing::warn!(worker = %id, %error, "a worker of the fleet cannot be used");
                    Learned::Unusable
                }),
            };
            if learned != Learned::Gone && worker.is_draining {
                self.dispatch.drain(id);
            }
        }
        for (worker, is_own) in known {
            let id = worker.registration.id;
            if rows.contains(&id) {
                continue;
            }
            if is_own && self.dispatch.knows(id) {
                // Another server took this one for gone.
                self.store.workers().register(worker.registration).await?;
            } else if !is_own {
                // It registers again if it is alive.
                self.dispatch.remove(id);
            }
        }
        Ok(workers)
    }

    /// Signals to the other servers that this one runs, takes over what they know, and requeues the jobs
    /// of servers and workers that have been silent for a lease. Returns the processes of other
    /// living servers: these alone end the attempts of theirs.
    pub(in crate::app) async fn sweep_members(&self, lease: Duration) -> Result<HashSet<WorkerId>> {
        let now = self.store.lease_time();
        if self.members.is_due(self.id.uuid(), lease / 3, now) {
            self.store.servers().seen(self.id, bendtwin_core::BUILD).await?;
        }
        // Before the servers: the server of each of them is among those, if it lives.
        let workers = self.learn().await?;
        let is_gone = |member, sign| self.members.silence(member, sign, now) > lease;
        let mut servers = HashSet::from([self.id]);
        let mut there = HashSet::from([self.id.uuid()]);
        for server in self.others(self.store.servers().all().await?) {
            there.insert(server.id.uuid());
            if is_gone(server.id.uuid(), server.sign) {
                tracing::warn!(server = %server.id, build = server.build, "a server is gone");
                self.store.servers().forget(server.id).await?;
            } else {
                servers.insert(server.id);
            }
        }
        let mut elsewhere = HashSet::new();
        for worker in workers {
            let id = worker.registration.id;
            there.insert(id.uuid());
            let silent = is_gone(id.uuid(), worker.sign);
            match worker.registration.server {
                Some(server) if server == self.id => {}
                // As long as a server lives, its processes are its own affair.
                Some(server) if servers.contains(&server) => {
                    elsewhere.insert(id);
                }
                Some(_) => drop(self.forfeit(id, WorkerEnd::ByServer).await?),
                None if worker.is_supervised && silent => {
                    self.forfeit(id, WorkerEnd::ByServer).await?;
                }
                None if silent && self.dispatch.silence(id) > lease => {
                    self.worker_fell_silent(id).await?;
                }
                None => {}
            }
        }
        self.members.keep(&there);
        Ok(elsewhere)
    }

    /// Notes for all servers that a worker of the fleet is heard of, now and then. False if none
    /// knows it any more.
    pub(in crate::app) async fn tell_of(&self, worker: WorkerId) -> Result<bool> {
        let (every, now) = (self.options.lease() / 3, self.store.lease_time());
        if !self.store.is_shared() || !self.members.is_due(worker.uuid(), every, now) {
            return Ok(true);
        }
        Ok(self.store.workers().seen(worker).await?)
    }

    /// Makes sure that a worker is known here. It may have registered at another server.
    pub(crate) async fn require_known(&self, worker: WorkerId) -> Result<()> {
        if self.dispatch.knows(worker) {
            return Ok(());
        }
        if self.store.is_shared()
            && let Some(found) = self.store.workers().find(worker).await?
            && self.dispatch.learn(found).await? == Learned::Known
        {
            return Ok(());
        }
        Err(Error::WorkerUnknown(worker.to_string()))
    }

    /// The worker that satisfies `holds`, registered at any server.
    pub(crate) async fn find_worker(
        &self,
        holds: impl Fn(WorkerId) -> bool,
    ) -> Result<Option<WorkerId>> {
        if let Some(found) = self.dispatch.find(&holds) {
            return Ok(Some(found));
        }
        if !self.store.is_shared() {
            return Ok(None);
        }
        let workers = self.store.workers().all().await?;
        Ok(workers.into_iter().map(|w: Worker| w.registration.id).find(|id| holds(*id)))
    }

    fn others(&self, servers: Vec<Server>) -> impl Iterator<Item = Server> + use<> {
        let own: ServerId = self.id;
        servers.into_iter().filter(move |server| server.id != own)
    }

    /// Forgets a worker that has ended, and requeues its jobs. The attempts of one that ended with its
    /// server, or in good order, do not count.
    /// Returns the jobs.
    pub(in crate::app) async fn forfeit(
        &self,
        worker: WorkerId,
        end: WorkerEnd,
    ) -> Result<Vec<Job>> {
        self.dispatch.remove(worker);
        let jobs = self.store.jobs().forfeit(worker, end).await?;
        jobs.iter().for_each(|job| self.note_end(job));
        self.store.workers().forget(worker).await?;
        // It may have been learned again from its row.
        self.dispatch.remove(worker);
        Ok(jobs)
    }
}

#[cfg(test)]
mod tests;
