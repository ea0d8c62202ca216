//! Claims: the next job for a worker.
//!
//! Jobs of the highest priority come first. Among equals the owner with the fewest running jobs of
//! the kind is served, then the one that was served longest ago, so that owners take turns however
//! many jobs each has queued. Of an owner's jobs the one that is due first is taken: ingests of
//! small captures are due before those of large ones, which wait no longer for that than they take
//! themselves. Owners that have as many jobs running as the key allows with which their next job was
//! created are passed over.

use std::time::Duration;

use bendtwin_core::ids::WorkerId;
use tokio::time::Instant;

use super::{Capabilities, Job, Jobs, Kind, Lease, Requirements, requirements, row::Row};
use crate::{
    Result,
    failpoint::Failpoint,
    sql::{Builder, Query, Transaction},
};

/// Claim up to the requirements that the worker satisfies. The worker is $1, the time of day $2,
/// the end of the lease $3, the kind $4.
const CLAIM: &str = "update jobs set state = 'running', worker = $1,
         lease_epoch = lease_epoch + 1, lease_until = $3, attempts = attempts + 1,
         stalled = stalled + 1, fruitless = fruitless + 1, slice_us = 0, idle_us = 0,
         started_at = coalesce(started_at, $2), served_at = $2, revision = revision + 1
     where id = (with recursive allowed (requirements) as (values ";
/// Then the queues. Each owner's jobs of equal requirements are one, found in an index after the one
/// before; its first job is the first whose capture has been read.
pub(super) const QUEUES: &str = "),
         queues (requirements, owner) as (
             select requirements, (select owner from jobs
                 where state = 'queued' and kind = $4 and requirements = allowed.requirements
                 order by kind, requirements, owner, priority desc, due_at, id limit 1)
             from allowed
             union all
             select requirements, (select owner from jobs
                 where state = 'queued' and kind = $4 and requirements = before.requirements
                     and owner > before.owner
                 order by kind, requirements, owner, priority desc, due_at, id limit 1)
             from queues as before where before.owner is not null),
         firsts (id, owner) as (
             select (select id from jobs as j
                 where state = 'queued' and kind = $4 and requirements = queues.requirements
                     and owner = queues.owner
                     and (kind = 'ingest' or not exists (
                         select 1 from jobs as i where i.capture = j.capture
                             and i.kind = 'ingest' and i.state in ('queued', 'running')))
                 order by kind, requirements, owner, priority desc, due_at, id limit 1), owner
             from queues where owner is not null)
         ";
/// Condition on the first job of a queue: that its owner may have one more job running.
pub(super) const HAS_ROOM: &str = "(select count(*) from jobs as b
                 where b.state = 'running' and b.kind in ('fit', 'ingest') and b.owner = firsts.owner)
             < coalesce((select max_running from jobs as f where f.id = firsts.id), 9223372036854775807)";
/// The rest of the claim.
const CHOICE: &str = "
         order by (select priority from jobs as f where f.id = firsts.id) desc,
             (select count(*) from jobs as r
                 where r.state = 'running' and r.kind = $4 and r.owner = firsts.owner),
             coalesce((select max(s.served_at) from jobs as s
                     where s.kind = $4 and s.owner = firsts.owner),
                 (select max(s.started_at) from jobs as s
                     where s.kind = $4 and s.owner = firsts.owner), 0),
             (select due_at from jobs as f where f.id = firsts.id), id
         limit 1)
     returning *";

/// Time after which a claimant checks the queue without a notification.
const LOOK_AGAIN: Duration = Duration::from_secs(10);

/// A worker that asks for jobs.
#[derive(Clone, Debug)]
pub struct Claimant {
    /// The worker.
    pub worker: WorkerId,
    /// Properties that jobs can ask for.
    pub capabilities: Capabilities,
}

/// A worker that gets only jobs without requirements.
impl From<WorkerId> for Claimant {
    fn from(worker: WorkerId) -> Self {
        Self { worker, capabilities: Capabilities::default() }
    }
}

/// The statement that claims a job with one of these requirements. The times are those of the day
/// and of the end of the lease.
pub(crate) fn statement(
    kind: Kind,
    worker: WorkerId,
    (now, lease_until): (i64, i64),
    allowed: &[String],
) -> Query {
    let mut sql = Builder::new(CLAIM);
    sql.bind(worker.uuid().to_string()).bind(now).bind(lease_until).bind(kind.as_str());
    push_allowed(&mut sql, allowed);
    sql.push(QUEUES).push("select id from firsts where id is not null and ").push(HAS_ROOM);
    sql.push(CHOICE);
    sql.build()
}

/// Adds requirements as rows of values.
pub(super) fn push_allowed(sql: &mut Builder, allowed: &[String]) {
    for (nth, requirements) in allowed.iter().enumerate() {
        sql.push(if nth == 0 { "(" } else { ", (" }).push_bind(requirements).push(")");
    }
}

impl Jobs<'_> {
    /// Claims the next job of a kind for a worker, if there is one. A fit is claimed only once its
    /// capture's ingest has ended.
    ///
    /// # Errors
    /// Database errors.
    pub async fn claim(
        &self,
        kind: Kind,
        claimant: impl Into<Claimant>,
        lease: Duration,
    ) -> Result<Option<Job>> {
        let claimant = claimant.into();
        let worker = claimant.worker;
        let mut tx = self.store.inner.database.write().await?;
        let allowed = allowed(&mut tx, kind, &claimant.capabilities).await?;
        if allowed.is_empty() {
            return Ok(None);
        }
        let times = (self.store.now_micros(), self.store.lease_until(&tx, lease));
        let row: Option<Row> =
            statement(kind, worker, times, &allowed).fetch_optional(&mut tx).await?;
        let Some(row) = row else { return Ok(None) };
        let job = Job::try_from(row)?;
        self.renew(Lease { job: job.id, epoch: job.lease_epoch, worker }, lease);
        self.store.pass(Failpoint::BeforeCommit)?;
        tx.commit().await?;
        self.changed(&job);
        self.store.pass(Failpoint::AfterCommit)?;
        Ok(Some(job))
    }

    /// Claims the next job of a kind, waiting up to `wait` for one.
    ///
    /// # Errors
    /// Database errors.
    pub async fn claim_within(
        &self,
        kind: Kind,
        claimant: impl Into<Claimant>,
        lease: Duration,
        wait: Duration,
    ) -> Result<Option<Job>> {
        let (claimant, deadline) = (claimant.into(), Instant::now() + wait);
        loop {
            // Listen first, look second: a job queued in between is not missed.
            let mut queued = std::pin::pin!(self.store.inner.queued.notified());
            queued.as_mut().enable();
            if let Some(job) = self.claim(kind, claimant.clone(), lease).await? {
                return Ok(Some(job));
            }
            // Where notifications come over a connection, one may be lost.
            let remote = self.store.inner.database.is_remote();
            let look = if remote { deadline.min(Instant::now() + LOOK_AGAIN) } else { deadline };
            if tokio::time::timeout_at(look, queued).await.is_err() && look == deadline {
                return Ok(None);
            }
        }
    }
}

/// Requirements of queued jobs that a worker satisfies, as their texts. Jobs with others than this
/// version knows are left to servers of the newer version that made them.
pub(super) async fn allowed(
    tx: &mut Transaction,
    kind: Kind,
    capabilities: &Capabilities,
) -> Result<Vec<String>> {
    let satisfied = |text: &String| {
        Requirements::known(text).is_some_and(|requirements| capabilities.satisfies(&requirements))
    };
    Ok(requirements::queued(tx, kind).await?.into_iter().filter(satisfied).collect())
}
