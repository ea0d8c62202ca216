//! Operations of workers on jobs. Every write is fenced by the lease's epoch.

use std::time::Duration;

use bendtwin_core::{ModelLoss, Progress, ids::WorkerId};

use super::{
    Job, JobId, Jobs, losses,
    row::{self, Row},
};
use crate::{Content, Digest, Error, Result, Staged, failpoint::Failpoint, sql::query};

/// The right of one worker to write to one job, until the job is claimed again. Every write of a
/// worker shows it, and is refused if the job has another lease by then.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Lease {
    /// The job.
    pub job: JobId,
    /// The fencing number.
    pub epoch: u64,
    /// The worker: the fencing number is no secret.
    pub worker: WorkerId,
}

impl Lease {
    /// The error of a write under this lease while the job has another, or none.
    pub(super) fn stale(self) -> Error {
        Error::StaleLease { job: self.job, epoch: self.epoch }
    }
}

impl Job {
    /// The lease of the job, while it runs.
    pub fn lease(&self) -> Option<Lease> {
        let worker = self.worker?;
        Some(Lease { job: self.id, epoch: self.lease_epoch, worker })
    }
}

/// News of a worker about its job.
#[derive(Clone, Copy, Debug, Default)]
pub struct JobReport<'a> {
    /// Progress to store, if any.
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

    /// Refuses a lease of a job that runs under another one, before a result is received. What has
    /// ended is repeated or refused by the write itself.
    ///
    /// # Errors
    /// [`Error::NotFound`], [`Error::StaleLease`].
    pub async fn check_lease(&self, lease: Lease) -> Result<()> {
        match self.get(lease.job).await?.lease() {
            Some(running) if running != lease => Err(lease.stale()),
            _ => Ok(()),
        }
    }

    /// Renews the lease and stores progress and losses, if any.
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
        let (digest, size_bytes) = (content.digest().to_hex(), content.size_bytes());
        let guard = self.store.publish(content).await?;
        let stored: Result<Option<String>> = async {
            let mut tx = self.store.inner.database.write().await?;
            let row = row::fetch_leased(&mut tx, lease).await?;
            self.renew(lease, renew);
            let newer = row.checkpoint.as_deref() != Some(digest.as_str());
            query(
                "update jobs set checkpoint = $2, lease_until = $3, stalled = $4, interrupted = $5,
                     checkpoint_bytes = $6
                 where id = $1",
            )
            .bind(lease.job.uuid().to_string())
            .bind(digest.as_str())
            .bind(self.store.lease_until(&tx, renew))
            .bind(if newer { 0 } else { row.stalled })
            .bind(if newer { 0 } else { row.interrupted })
            .bind(i64::try_from(size_bytes).unwrap_or(i64::MAX))
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
            // Refused: no row refers to the new content, except by chance.
            Err(_) => Some(digest.as_str()),
        };
        self.store.pass(Failpoint::BeforeRelease)?;
        if let Some(obsolete) = obsolete {
            self.store.release(obsolete).await?;
        }
        stored.map(drop)
    }

    /// The newest checkpoint of a job. A checkpoint whose content is lost is forgotten: the job
    /// starts again.
    ///
    /// # Errors
    /// [`Error::NotFound`] without a checkpoint, [`Error::ContentLost`], [`Error::ContentDamaged`].
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
    pub(super) fn renew(&self, lease: Lease, time: Duration) {
        let monotonic = self.store.inner.clock.monotonic();
        self.store.inner.leases.renew(lease.job, lease.epoch, monotonic, time);
    }
}
