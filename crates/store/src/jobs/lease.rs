//! Operations of workers on jobs. Every write is fenced by the lease's epoch.

use std::time::Duration;

use bendtwin_core::{ModelLoss, Progress, ids::WorkerId};
use tokio::time::Instant;

use super::{
    Job, JobId, Jobs, Kind, losses,
    row::{self, Row},
};
use crate::{Content, Digest, Error, Result, Staged, failpoint::Failpoint, sql::query};

/// Claims the job that is due first among those of the highest priority: a fit only once its
/// capture has been read. Ingests of small captures are due before those of large ones, which wait
/// no longer for that than they take themselves.
pub(crate) const CLAIM: &str =
    "update jobs set state = 'running', worker = $1, lease_epoch = lease_epoch + 1,
         lease_until = $3, attempts = attempts + 1, stalled = stalled + 1,
         started_at = coalesce(started_at, $2), revision = revision + 1
     where id = (
         select id from jobs as j
         where state = 'queued' and kind = $4 and (kind = 'ingest' or not exists (
             select 1 from jobs as i where i.capture = j.capture and i.kind = 'ingest'
                 and i.state in ('queued', 'running')))
         order by priority desc, due_at, id limit 1)
     returning *";

/// Time after which a claimant looks at the queue although nothing has woken it.
const LOOK_AGAIN: Duration = Duration::from_secs(10);

/// The right of one worker to write to one job, until another claims it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Lease {
    /// The job.
    pub job: JobId,
    /// The fencing number.
    pub epoch: u64,
}

/// News of a worker about its job.
#[derive(Clone, Copy, Debug, Default)]
pub struct JobReport<'a> {
    /// Progress, if there is any to store.
    pub progress: Option<&'a Progress>,
    /// Losses since the last report, of a fit.
    pub losses: &'a [ModelLoss],
}

impl<'a> From<Option<&'a Progress>> for JobReport<'a> {
    fn from(progress: Option<&'a Progress>) -> Self {
        Self { progress, losses: &[] }
    }
}

/// Answer to a worker's report.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Reported {
    /// True if the job has been asked to stop.
    pub cancel_requested: bool,
}

impl Jobs<'_> {
    /// Claims the next job of a kind, if there is one. A fit is claimed only once its capture's
    /// ingest has ended.
    ///
    /// # Errors
    /// Database errors.
    pub async fn claim(
        &self,
        kind: Kind,
        worker: WorkerId,
        lease: Duration,
    ) -> Result<Option<Job>> {
        let mut tx = self.store.inner.database.write().await?;
        let row: Option<Row> = query(CLAIM)
            .bind(worker.uuid().to_string())
            .bind(self.store.now_micros())
            .bind(self.store.lease_until(&tx, lease))
            .bind(kind.as_str())
            .fetch_optional(&mut tx)
            .await?;
        let Some(row) = row else { return Ok(None) };
        let job = Job::try_from(row)?;
        self.renew(Lease { job: job.id, epoch: job.lease_epoch }, lease);
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
        worker: WorkerId,
        lease: Duration,
        wait: Duration,
    ) -> Result<Option<Job>> {
        let deadline = Instant::now() + wait;
        loop {
            // Listen first, look second: a job queued in between is not missed.
            let mut queued = std::pin::pin!(self.store.inner.queued.notified());
            queued.as_mut().enable();
            if let Some(job) = self.claim(kind, worker, lease).await? {
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

    /// The jobs that a worker holds leases of.
    ///
    /// # Errors
    /// Database errors.
    pub async fn held_by(&self, worker: WorkerId) -> Result<Vec<Job>> {
        let rows: Vec<Row> = query("select * from jobs where state = 'running' and worker = $1")
            .bind(worker.uuid().to_string())
            .fetch_all(self.store.inner.database.read())
            .await?;
        rows.into_iter().map(Job::try_from).collect()
    }

    /// Renews the lease and stores progress and losses, if there are any to store.
    ///
    /// # Errors
    /// [`Error::StaleLease`].
    pub async fn report<'r>(
        &self,
        lease: Lease,
        report: impl Into<JobReport<'r>>,
        renew: Duration,
    ) -> Result<Reported> {
        let JobReport { progress, losses } = report.into();
        let mut tx = self.store.inner.database.write().await?;
        let until = self.store.lease_until(&tx, renew);
        let row = row::fetch_leased(&mut tx, lease).await?;
        self.renew(lease, renew);
        losses::record(&mut tx, &row, losses).await?;
        let key = lease.job.uuid().to_string();
        let Some(progress) = progress else {
            query("update jobs set lease_until = $2 where id = $1")
                .bind(key)
                .bind(until)
                .execute(&mut tx)
                .await?;
            tx.commit().await?;
            return Ok(Reported { cancel_requested: row.cancel_requested });
        };
        let further = progress.fraction > row.furthest;
        let json = serde_json::to_string(progress)
            .map_err(|e| Error::Io(std::io::Error::other(e.to_string())))?;
        let row: Row = query(
            "update jobs set lease_until = $2, progress = $3, furthest = $4, stalled = $5,
                 interrupted = $6, revision = revision + 1
             where id = $1 returning *",
        )
        .bind(key)
        .bind(until)
        .bind(json)
        .bind(if further { progress.fraction } else { row.furthest })
        .bind(if further { 0 } else { row.stalled })
        .bind(if further { 0 } else { row.interrupted })
        .fetch_one(&mut tx)
        .await?;
        tx.commit().await?;
        let job = Job::try_from(row)?;
        self.changed(&job);
        Ok(Reported { cancel_requested: job.cancel_requested })
    }

    /// Makes this content the job's checkpoint, and renews the lease.
    ///
    /// # Errors
    /// [`Error::StaleLease`], file errors.
    pub async fn save_checkpoint(
        &self,
        lease: Lease,
        content: Staged,
        renew: Duration,
    ) -> Result<()> {
        let digest = content.digest().to_hex();
        let guard = self.store.publish(content).await?;
        let stored: Result<Option<String>> = async {
            let mut tx = self.store.inner.database.write().await?;
            let row = row::fetch_leased(&mut tx, lease).await?;
            self.renew(lease, renew);
            let newer = row.checkpoint.as_deref() != Some(digest.as_str());
            query(
                "update jobs set checkpoint = $2, lease_until = $3, stalled = $4, interrupted = $5
                 where id = $1",
            )
            .bind(lease.job.uuid().to_string())
            .bind(digest.as_str())
            .bind(self.store.lease_until(&tx, renew))
            .bind(if newer { 0 } else { row.stalled })
            .bind(if newer { 0 } else { row.interrupted })
            .execute(&mut tx)
            .await?;
            self.store.pass(Failpoint::BeforeCommit)?;
            tx.commit().await?;
            Ok(row.checkpoint.filter(|_| newer))
        }
        .await;
        drop(guard);
        let obsolete = match &stored {
            Ok(before) => before.as_deref(),
            Err(Error::Failpoint(_)) => None,
            // Refused: nobody refers to the new content, unless by chance.
            Err(_) => Some(digest.as_str()),
        };
        self.store.pass(Failpoint::BeforeRelease)?;
        if let Some(obsolete) = obsolete {
            self.store.release(obsolete).await?;
        }
        stored.map(drop)
    }

    /// The newest checkpoint of a job. One whose content is lost is forgotten: the job begins anew.
    ///
    /// # Errors
    /// [`Error::NotFound`] if there is none, [`Error::ContentLost`], [`Error::ContentDamaged`].
    pub async fn checkpoint(&self, id: JobId) -> Result<Content> {
        let digest = self.get(id).await?.checkpoint;
        let digest =
            digest.ok_or_else(|| Error::NotFound { name: format!("checkpoint of {id}") })?;
        let content = self.store.blobs().read(&digest, None, &id.to_string()).await;
        if let Err(Error::ContentLost { .. } | Error::ContentDamaged { .. }) = &content {
            self.forget_checkpoint(id, digest).await?;
        }
        content
    }

    /// Takes a checkpoint off a job that still has this one.
    async fn forget_checkpoint(&self, id: JobId, digest: Digest) -> Result<()> {
        let digest = digest.to_hex();
        tracing::warn!(job = %id, %digest, "checkpoint lost: the job begins anew");
        let mut tx = self.store.inner.database.write().await?;
        query("update jobs set checkpoint = null where id = $1 and checkpoint = $2")
            .bind(id.uuid().to_string())
            .bind(digest.as_str())
            .execute(&mut tx)
            .await?;
        tx.commit().await?;
        // The remains of it, if it was damaged.
        self.store.release(&digest).await
    }

    /// Within the transaction that says the same to the database, so that no sweep comes between.
    fn renew(&self, lease: Lease, time: Duration) {
        let monotonic = self.store.inner.clock.monotonic();
        self.store.inner.leases.renew(lease.job, lease.epoch, monotonic, time);
    }
}
