//! Operations of workers on jobs. Every write is fenced by the lease's epoch.

use std::time::Duration;

use bendtwin_core::{ModelLoss, Progress, ids::WorkerId};

use super::{
    Job, JobId, Jobs, Turns, losses,
    row::{self, Row},
    turns::{self, Way, as_micros},
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
    /// What a fit has so far, in a text of the caller's; none: nothing newer.
    pub preview: Option<&'a str>,
    /// How it shares its worker; none: it does not.
    pub turns: Option<Turns<'a>>,
}

impl<'a> From<Option<&'a Progress>> for JobReport<'a> {
    fn from(progress: Option<&'a Progress>) -> Self {
        Self { progress, ..Self::default() }
    }
}

/// Answer to a worker's report.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Reported {
    /// True if the job has been asked to stop.
    pub cancel_requested: bool,
    /// Time until the job is to be handed back, if another owner's waits for its worker: at the next
    /// checkpoint, or then without one.
    pub make_way_within: Option<Duration>,
    /// Times of the job.
    pub times: JobTimes,
}

/// Times of a running job at its worker, by lease time ([`Store::lease_time`](crate::Store::lease_time)).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct JobTimes {
    /// Since its first claim, over all attempts.
    pub run: Duration,
    /// Since its progress or its checkpoint last changed, or since its last claim.
    pub idle: Duration,
    /// Bound on `run` of the key that created it, if there is one.
    pub most_run: Option<Duration>,
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

    /// Renews the lease, stores progress, losses and preview, if any, and adds to the times of the job.
    ///
    /// # Errors
    /// [`Error::StaleLease`].
    pub async fn report<'r>(
        &self,
        lease: Lease,
        report: impl Into<JobReport<'r>>,
        renew: Duration,
    ) -> Result<Reported> {
        let JobReport { progress, losses, preview, turns } = report.into();
        let mut tx = self.store.inner.database.write().await?;
        let until = self.store.lease_until(&tx, renew);
        let row = row::fetch_leased(&mut tx, lease).await?;
        let passed = as_micros(self.renew(lease, renew));
        losses::record(&mut tx, &row, losses).await?;
        if let Some(preview) = preview {
            self.record_preview(&mut tx, &row, preview).await?;
        }
        let json = progress.map(serde_json::to_string).transpose();
        let json = json.map_err(|e| Error::Io(std::io::Error::other(e.to_string())))?;
        let moves = json.is_some() && json != row.progress;
        let (run_us, slice_us) = (row.run_us + passed, row.slice_us + passed);
        let idle_us = if moves { 0 } else { row.idle_us + passed };
        let way = match turns {
            Some(turns) => turns::way(&mut tx, &row, slice_us, turns).await?,
            None => Way { asked_us: row.yield_us, within: None },
        };
        let micros = |us: i64| Duration::from_micros(us.max(0) as u64);
        let reported = Reported {
            cancel_requested: row.cancel_requested,
            make_way_within: way.within,
            times: JobTimes {
                run: micros(run_us),
                idle: micros(idle_us),
                most_run: row.max_run_s.map(|s| Duration::from_secs(s.max(0) as u64)),
            },
        };
        query(
            "update jobs set lease_until = $2, run_us = $3, slice_us = $4, idle_us = $5,
                 yield_us = $6
             where id = $1",
        )
        .bind(&row.id)
        .bind(until)
        .bind(run_us)
        .bind(slice_us)
        .bind(idle_us)
        .bind(way.asked_us)
        .execute(&mut tx)
        .await?;
        let (Some(progress), Some(json)) = (progress, json) else {
            tx.commit().await?;
            return Ok(reported);
        };
        let further = progress.fraction > row.furthest;
        let row: Row = query(
            "update jobs set progress = $2, furthest = $3, stalled = $4, interrupted = $5,
                 revision = revision + 1
             where id = $1 returning *",
        )
        .bind(&row.id)
        .bind(json)
        .bind(if further { progress.fraction } else { row.furthest })
        .bind(if further { 0 } else { row.stalled })
        .bind(if further { 0 } else { row.interrupted })
        .fetch_one(&mut tx)
        .await?;
        tx.commit().await?;
        self.changed(&Job::try_from(row)?);
        Ok(reported)
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
            let passed = as_micros(self.renew(lease, renew));
            let newer = row.checkpoint.as_deref() != Some(digest.as_str());
            query(
                "update jobs set checkpoint = $2, lease_until = $3, stalled = $4, interrupted = $5,
                     fruitless = $6, run_us = $7, slice_us = $8, idle_us = $9,
                     checkpoint_bytes = $10
                 where id = $1",
            )
            .bind(lease.job.uuid().to_string())
            .bind(digest.as_str())
            .bind(self.store.lease_until(&tx, renew))
            .bind(if newer { 0 } else { row.stalled })
            .bind(if newer { 0 } else { row.interrupted })
            .bind(if newer { 0 } else { row.fruitless })
            .bind(row.run_us + passed)
            .bind(row.slice_us + passed)
            .bind(if newer { 0 } else { row.idle_us + passed })
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
    /// Returns the time since the last renewal ([`LeaseTimes::renew`](super::LeaseTimes)).
    pub(super) fn renew(&self, lease: Lease, time: Duration) -> Duration {
        let monotonic = self.store.inner.clock.monotonic();
        self.store.inner.leases.renew(lease.job, lease.epoch, monotonic, time)
    }
}
