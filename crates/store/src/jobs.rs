//! Jobs: the queue. Its design is in the crate's documentation. Here are the types and the
//! operations of users on either kind; `fits.rs` and `ingests.rs` have those of one kind,
//! `claim.rs` the choice of the next job, `turns.rs` when a running one makes way, `requirements.rs` what a job asks of its worker, `lease.rs` the operations of workers, `losses.rs` the losses of fits, `previews.rs` what a running one has so far, `lease_time.rs` the time by which leases end, `end.rs` the ends of
//! attempts, `id.rs` the names and `row.rs` the row.

mod claim;
mod end;
mod fits;
mod id;
mod ingests;
mod lease;
mod lease_time;
mod losses;
mod previews;
mod requirements;
mod row;
mod suspend;
mod turns;

use std::time::Duration;

use bendtwin_core::{
    Fault, Progress,
    ids::{CaptureId, FitId, TwinId, WorkerId},
    quality::Measure,
};
use jiff::Timestamp;
use tokio::sync::broadcast;

use crate::{
    Digest, Error, Labels, Result, Store,
    labels::{self, Collection},
    owners::deleted_requests,
    owners::request_ids::RequestId,
    sql::query,
    trash::Remove,
};

pub use claim::Claimant;
#[cfg(test)]
pub(crate) use claim::statement as claim_statement;
pub use end::{AttemptEnd, WorkerEnd};
pub use fits::NewFit;
pub use id::{JobId, Kind};
pub use ingests::{IngestOutcome, IngestResult, NewIngest, NewReport};
pub(crate) use ingests::{JobOrigin, admit_ingest, dequeue, enqueue, require_idle};
pub use lease::{JobReport, JobTimes, Lease, Reported};
pub use lease_time::LeaseTerms;
pub(crate) use lease_time::LeaseTimes;
pub use previews::StoredPreview;
#[cfg(test)]
pub(crate) use requirements::DIFFERENT as DIFFERENT_REQUIREMENTS;
pub use requirements::{Capabilities, Requirements};
pub use row::State;
pub(crate) use row::fits_under_way;
pub use turns::Turns;
#[cfg(test)]
pub(crate) use turns::waiting as waiting_statement;

use row::Row;

/// Attempts without progress after which a job fails.
pub const MAX_STALLED_ATTEMPTS: u32 = 3;
/// Attempts without progress that other work of their workers may end before such an end counts
/// like any other: the job may be the cause after all.
pub const MAX_INTERRUPTED_ATTEMPTS: u32 = 20;

/// A job.
#[derive(Clone, Debug, PartialEq)]
pub struct Job {
    /// Id of the job, which includes the kind.
    pub id: JobId,
    /// The capture to be fitted or read.
    pub capture: CaptureId,
    /// State of the job.
    pub state: State,
    /// The settings in force, as JSON.
    pub settings: String,
    /// Jobs of higher priority run earlier.
    pub priority: i32,
    /// Number of claims that count as attempts.
    pub attempts: u32,
    /// The fencing number, which every claim increments.
    pub lease_epoch: u64,
    /// End of the lease by the time of day, while it runs; it ends by [`Store::lease_time`].
    pub lease_until: Option<Timestamp>,
    /// The worker, while it runs.
    pub worker: Option<WorkerId>,
    /// The last report.
    pub progress: Option<Progress>,
    /// Digest of the newest checkpoint, until the job ends.
    pub checkpoint: Option<Digest>,
    /// True if it has been asked to stop.
    pub cancel_requested: bool,
    /// The twin that it made, if it is a fit.
    pub twin: Option<TwinId>,
    /// The fault if it failed.
    pub fault: Option<Fault>,
    /// Faults of earlier attempts.
    pub attempt_faults: Vec<Fault>,
    /// True of an ingest that succeeded with masks alone, as it was to: there is nothing to fit.
    pub masks_only: bool,
    /// W3C traceparent of the call that created it.
    pub trace_parent: Option<String>,
    /// The idempotency key it was created under.
    pub request_id: Option<String>,
    /// Time of creation.
    pub created: Timestamp,
    /// Time of the first claim.
    pub started: Option<Timestamp>,
    /// Time of the end.
    pub ended: Option<Timestamp>,
    /// Revision; grows with every change, and from one ingest of a capture to the next.
    pub revision: u64,
    /// Display name, note and tags, if it is a fit.
    pub labels: Labels,
    /// Error of the twin that it made, if there is one [m].
    pub error_m: Option<f64>,
    /// Kind of that error, if it is known.
    pub measure: Option<Measure>,
    /// Owner of the key with which it was asked for; empty if that is not known.
    pub owner: String,
    /// Worker that it asks for.
    pub requirements: Requirements,
    /// Time for which it has run at workers, over all attempts, as of its last report.
    pub run: Duration,
}

/// Number of jobs by kind and state, and waiting time of the queues.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct QueueDepth {
    /// Number of jobs by kind and state; zeros are left out.
    pub counts: Vec<(Kind, State, u64)>,
    /// Waiting time of the oldest queued job of a kind.
    pub oldest_queued: Vec<(Kind, Duration)>,
}

impl QueueDepth {
    /// Number of jobs of a kind in a state.
    pub fn count(&self, kind: Kind, state: State) -> u64 {
        let found = self.counts.iter().find(|(k, s, _)| (*k, *s) == (kind, state));
        found.map_or(0, |(.., n)| *n)
    }

    /// Waiting time of the oldest queued job of a kind; zero without queued jobs.
    pub fn oldest(&self, kind: Kind) -> Duration {
        let found = self.oldest_queued.iter().find(|(k, _)| *k == kind);
        found.map_or(Duration::ZERO, |(_, waited)| *waited)
    }
}

/// The jobs of a store.
#[derive(Clone, Copy, Debug)]
pub struct Jobs<'a> {
    pub(crate) store: &'a Store,
}

impl Jobs<'_> {
    /// Returns a job.
    ///
    /// # Errors
    /// [`Error::NotFound`].
    pub async fn get(&self, id: impl Into<JobId>) -> Result<Job> {
        let id = id.into();
        let row: Option<Row> = query("select * from jobs where id = $1 and kind = $2")
            .bind(id.uuid().to_string())
            .bind(id.kind().as_str())
            .fetch_optional(self.store.inner.database.read())
            .await?;
        row.ok_or_else(|| Error::NotFound { name: id.to_string() })?.try_into()
    }

    /// Asks a job to stop: a queued one ends immediately, a running one when its worker learns of
    /// it; an ended one does not change.
    ///
    /// # Errors
    /// [`Error::NotFound`].
    pub async fn cancel(&self, id: impl Into<JobId>) -> Result<Job> {
        let id = id.into();
        let key = id.uuid().to_string();
        let mut tx = self.store.inner.database.write().await?;
        let row = row::fetch(&mut tx, id).await?;
        let checkpoint = row.checkpoint.clone();
        let row: Row = match row.state()? {
            State::Queued => {
                query(
                    "update jobs set state = 'cancelled', cancel_requested = true,
                         checkpoint = null, ended_at = $2, revision = revision + 1
                     where id = $1 returning *",
                )
                .bind(key)
                .bind(self.store.now_micros())
                .fetch_one(&mut tx)
                .await?
            }
            State::Running if !row.cancel_requested => {
                query(
                    "update jobs set cancel_requested = true, revision = revision + 1
                     where id = $1 returning *",
                )
                .bind(key)
                .fetch_one(&mut tx)
                .await?
            }
            _ => return row.try_into(),
        };
        let job = Job::try_from(row)?;
        let followers = self.fail_followers(&mut tx, &job).await?;
        tx.commit().await?;
        self.settled(&job, checkpoint, followers).await?;
        Ok(job)
    }

    /// Deletes a fit that does not run for good, also one in the trash. Its twin stays. Its request
    /// id makes no other for a day.
    ///
    /// # Errors
    /// [`Error::NotFound`], [`Error::FitRunning`].
    pub async fn delete(&self, fit: FitId) -> Result<()> {
        self.remove(fit, Remove::Any).await
    }

    /// Deletes a fit for good if it is one of these.
    pub(crate) async fn remove(&self, fit: FitId, which: Remove) -> Result<()> {
        let mut tx = self.store.inner.database.write().await?;
        let row = row::fetch_any(&mut tx, fit.into()).await?;
        if !row.is_among(which) {
            return Err(Error::NotFound { name: fit.to_string() });
        }
        if row.state()? == State::Running {
            return Err(Error::FitRunning { fit });
        }
        let key = fit.uuid().to_string();
        for statement in ["delete from jobs where id = $1", "delete from losses where fit = $1"] {
            query(statement).bind(&key).execute(&mut tx).await?;
        }
        previews::forget(&mut tx, &key).await?;
        labels::forget(&mut tx, Collection::Fits, &key).await?;
        let request_id = row.request_id.as_deref();
        let request = request_id.map(|stored| RequestId::of_row(stored, &row.owner));
        let kind = deleted_requests::Kind::Jobs;
        self.store.keep_request_id(&mut tx, kind, request, &fit.to_string()).await?;
        tx.commit().await?;
        let _ = self.store.inner.changes.send(fit.into());
        match row.checkpoint {
            Some(digest) => self.store.release(&digest).await,
            None => Ok(()),
        }
    }

    /// Ids of jobs that change from now on. A receiver that lags behind should read the jobs that
    /// it watches again.
    pub fn changes(&self) -> broadcast::Receiver<JobId> {
        self.store.inner.changes.subscribe()
    }

    /// Depth of the queues.
    ///
    /// # Errors
    /// Database errors.
    pub async fn depth(&self) -> Result<QueueDepth> {
        let rows: Vec<(String, String, i64, i64)> =
            query("select kind, state, count(*), min(created_at) from jobs group by kind, state")
                .fetch_all(self.store.inner.database.read())
                .await?;
        // The first statement reads an index alone, this one the few rows in the trash.
        let in_trash: Vec<(String, String, i64)> = query(
            "select kind, state, count(*) from jobs where trashed_at is not null
             group by kind, state",
        )
        .fetch_all(self.store.inner.database.read())
        .await?;
        let mut depth = QueueDepth::default();
        for (kind, state, count, oldest) in rows {
            let trashed = in_trash.iter().find(|(k, s, _)| (k, s) == (&kind, &state));
            let count = count - trashed.map_or(0, |(.., trashed)| *trashed);
            let (Some(kind), Some(state)) = (Kind::parse(&kind), State::parse(&state)) else {
                continue;
            };
            depth.counts.push((kind, state, count.max(0) as u64));
            if state == State::Queued {
                let waited = self.store.now_micros().saturating_sub(oldest).max(0);
                depth.oldest_queued.push((kind, Duration::from_micros(waited as u64)));
            }
        }
        Ok(depth)
    }

    /// Wakes watchers, and claimants if there may be a job for them.
    pub(crate) fn changed(&self, job: &Job) {
        // No receiver, no matter.
        let _ = self.store.inner.changes.send(job.id);
        // The end of an ingest sets fits free, and that of any job may bring its owner below a bound.
        if job.state == State::Queued || job.state.has_ended() {
            self.store.inner.queued.notify_waiters();
        }
    }
}

#[cfg(test)]
mod tests;
