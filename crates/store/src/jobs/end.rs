//! Ends of attempts without a result, and the job's next state.

use bendtwin_core::{Category, Fault, ids::WorkerId};

use uuid::Uuid;

use super::{
    Job, JobId, Jobs, Lease, LeaseTerms, MAX_INTERRUPTED_ATTEMPTS, MAX_STALLED_ATTEMPTS,
    Requirements,
    lease_time::RunningJob,
    row::{self, Row, State, to_json},
};
use crate::{
    Error, Result,
    failpoint::Failpoint,
    sql::{Transaction, query},
};

/// Reason for the end of an attempt.
#[derive(Clone, Debug, PartialEq)]
pub enum AttemptEnd {
    /// Failed; another attempt may succeed.
    Failed(Fault),
    /// Failed because of the input: every attempt would.
    FailedForGood(Fault),
    /// Stopped on request.
    Cancelled,
    /// The worker gave the job back in good order; the attempt does not count.
    Released,
    /// A brief ingest takes longer than it may; the attempt does not count, and from now on it is a long one.
    Outgrown,
    /// Other work of the worker ended it. It does not count either, unless that was so for the last
    /// [`MAX_INTERRUPTED_ATTEMPTS`] attempts.
    Interrupted(Fault),
}

/// Reason for which a worker lost its attempts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WorkerEnd {
    /// The worker ended or fell silent: the job may be the cause.
    Lost,
    /// The worker ended while it answered rollouts, which may equally be the cause.
    DuringRollout,
    /// The server ended the worker, or ended itself: the job is not the cause.
    ByServer,
}

impl Jobs<'_> {
    /// Ends the attempt under this lease.
    ///
    /// # Errors
    /// [`Error::StaleLease`].
    pub async fn end_attempt(&self, lease: Lease, end: AttemptEnd) -> Result<Job> {
        let mut tx = self.store.inner.database.write().await?;
        let row = row::fetch_leased(&mut tx, lease).await?;
        let checkpoint = row.checkpoint.clone();
        let job = self.apply(&mut tx, row, end).await?;
        let followers = self.fail_followers(&mut tx, &job).await?;
        self.store.pass(Failpoint::BeforeCommit)?;
        tx.commit().await?;
        self.settled(&job, checkpoint, followers).await?;
        Ok(job)
    }

    /// Advances lease time to now ([`Store::lease_time`](crate::Store::lease_time)) and ends all
    /// attempts whose leases have run out, also by the database's clock if it has one: another
    /// server may have renewed them. `worker_end` returns what became of a worker; `None` leaves the
    /// attempt to another server.
    ///
    /// # Errors
    /// Database errors.
    pub async fn sweep(
        &self,
        terms: LeaseTerms,
        worker_end: impl Fn(WorkerId) -> Option<WorkerEnd>,
    ) -> Result<Vec<Job>> {
        let running: Vec<(String, String, i64, Option<i64>)> =
            query("select kind, id, lease_epoch, lease_until from jobs where state = 'running'")
                .fetch_all(self.store.inner.database.read())
                .await?;
        // Where another server may renew a lease, a change of its end is a renewal.
        let shared = self.store.is_shared() && !self.store.inner.clock.is_simulated();
        let lease = |(kind, id, epoch, until): &(String, String, i64, Option<i64>)| {
            let renewal = until.filter(|_| shared);
            Some(RunningJob {
                job: JobId::stored(kind, id)?,
                epoch: (*epoch).max(0) as u64,
                renewal,
            })
        };
        let running: Vec<RunningJob> = running.iter().filter_map(lease).collect();
        let leases = &self.store.inner.leases;
        let expired = leases.sweep(&running, self.store.inner.clock.monotonic(), terms);
        let mut swept = Vec::new();
        for id in expired {
            let end = |row: &Row, database_time: Option<i64>| {
                let renewed = database_time.is_some_and(|time| row.lease_until > Some(time));
                let has_run_out = leases.has_run_out(id, row.epoch()) && !renewed;
                if has_run_out { lost(row, &worker_end) } else { None }
            };
            swept.extend(self.end_if(id, end).await?);
        }
        Ok(swept)
    }

    /// Ends all attempts of a worker that is known to be gone, without waiting for its leases.
    ///
    /// # Errors
    /// Database errors.
    pub async fn forfeit(&self, worker: WorkerId, worker_end: WorkerEnd) -> Result<Vec<Job>> {
        let worker = worker.uuid().to_string();
        let held: Vec<(String, String)> =
            query("select kind, id from jobs where state = 'running' and worker = $1")
                .bind(&worker)
                .fetch_all(self.store.inner.database.read())
                .await?;
        let mut ended = Vec::new();
        for id in held.iter().filter_map(|(kind, id)| JobId::stored(kind, id)) {
            let end = |row: &Row, _| match row.worker.as_ref() == Some(&worker) {
                true => lost(row, |_| Some(worker_end)),
                false => None,
            };
            ended.extend(self.end_if(id, end).await?);
        }
        Ok(ended)
    }

    /// Ends a running attempt in the way that `end` returns once the write lock is taken, if it
    /// returns one; `end` receives the database's time [us], if the database has a clock.
    async fn end_if(
        &self,
        id: JobId,
        end: impl Fn(&Row, Option<i64>) -> Option<AttemptEnd>,
    ) -> Result<Option<Job>> {
        let mut tx = self.store.inner.database.write().await?;
        let row = match row::fetch(&mut tx, id).await {
            Err(Error::NotFound { .. } | Error::InTrash { .. }) => return Ok(None),
            row => row?,
        };
        if row.state()? != State::Running {
            return Ok(None);
        }
        let Some(end) = end(&row, self.store.database_time(&tx)) else { return Ok(None) };
        let checkpoint = row.checkpoint.clone();
        let job = self.apply(&mut tx, row, end).await?;
        let followers = self.fail_followers(&mut tx, &job).await?;
        tx.commit().await?;
        self.settled(&job, checkpoint, followers).await?;
        Ok(Some(job))
    }

    /// Writes the next state of a running job.
    pub(super) async fn apply(
        &self,
        tx: &mut Transaction,
        row: Row,
        end: AttemptEnd,
    ) -> Result<Job> {
        let mut faults: Vec<Fault> = serde_json::from_str(&row.attempt_faults).unwrap_or_default();
        let stalled_out = row.stalled >= i64::from(MAX_STALLED_ATTEMPTS);
        let cancelling = row.cancel_requested;
        let (mut counted, mut interrupted) = (1, row.interrupted);
        let made_way = row.yield_us.is_some() && end == AttemptEnd::Released;
        let fruitless = if made_way { row.fruitless } else { (row.fruitless - 1).max(0) };
        let mut requirements = row.requirements;
        let end = match end {
            AttemptEnd::Interrupted(_) if interrupted < i64::from(MAX_INTERRUPTED_ATTEMPTS) => {
                interrupted += 1;
                AttemptEnd::Released
            }
            AttemptEnd::Interrupted(fault) => AttemptEnd::Failed(fault),
            end => end,
        };
        let (state, fault) = match end {
            AttemptEnd::Cancelled => (State::Cancelled, None),
            AttemptEnd::Released | AttemptEnd::Outgrown | AttemptEnd::Failed(_) if cancelling => {
                (State::Cancelled, None)
            }
            AttemptEnd::Released => {
                counted = 0;
                (State::Queued, None)
            }
            AttemptEnd::Outgrown => {
                counted = 0;
                let known = Requirements::from_text(&requirements).unwrap_or_default();
                requirements = Requirements { long: true, ..known }.to_text()?;
                (State::Queued, None)
            }
            AttemptEnd::FailedForGood(fault) => (State::Failed, Some(fault)),
            AttemptEnd::Failed(fault) if stalled_out => (State::Failed, Some(fault)),
            AttemptEnd::Failed(fault) | AttemptEnd::Interrupted(fault) => {
                faults.push(fault);
                (State::Queued, None)
            }
        };
        let ended = state.has_ended();
        let updated: Row = query(
            "update jobs set state = $2, fault = $3, attempt_faults = $4, attempts = $5,
                 stalled = $6, ended_at = $7, checkpoint = $8, interrupted = $9,
                 fruitless = $10, served_at = coalesce($11, served_at), requirements = $12,
                 yield_us = null, lease_until = null, worker = null,
                 revision = revision + 1
             where id = $1 returning *",
        )
        .bind(&row.id)
        .bind(state.as_str())
        .bind(fault.as_ref().map(to_json))
        .bind(to_json(&faults))
        .bind(row.attempts - 1 + counted)
        .bind((row.stalled - 1 + counted).max(0))
        .bind(ended.then(|| self.store.now_micros()))
        .bind(row.checkpoint.filter(|_| !ended))
        .bind(interrupted)
        .bind(fruitless)
        .bind(made_way.then(|| self.store.now_micros()))
        .bind(requirements)
        .fetch_one(&mut *tx)
        .await?;
        updated.try_into()
    }

    /// After the commit: notifies watchers and deletes content that nothing refers to any more.
    pub(super) async fn settled(
        &self,
        job: &Job,
        checkpoint: Option<String>,
        followers: Vec<(Job, Option<String>)>,
    ) -> Result<()> {
        self.changed(job);
        let mut obsolete: Vec<String> =
            checkpoint.filter(|_| job.state.has_ended()).into_iter().collect();
        for (fit, checkpoint) in followers {
            self.changed(&fit);
            obsolete.extend(checkpoint);
        }
        for digest in obsolete {
            self.store.release(&digest).await?;
        }
        Ok(())
    }
}

/// The end of an attempt whose worker is gone, if `worker_end` knows the cause.
fn lost(row: &Row, worker_end: impl Fn(WorkerId) -> Option<WorkerEnd>) -> Option<AttemptEnd> {
    let worker = row.worker.as_deref().unwrap_or("unknown");
    let fault = |what: &str| Fault {
        category: Category::Unavailable,
        reason: "WORKER_LOST".to_owned(),
        message: format!("workers/{worker} {what} in attempt {}", row.attempts),
    };
    let id = Uuid::try_parse(worker).ok().map(WorkerId::from);
    Some(match id.map_or(Some(WorkerEnd::Lost), worker_end)? {
        WorkerEnd::Lost => AttemptEnd::Failed(fault("stopped answering")),
        WorkerEnd::DuringRollout => {
            AttemptEnd::Interrupted(fault("ended while it answered rollouts"))
        }
        WorkerEnd::ByServer => AttemptEnd::Released,
    })
}
