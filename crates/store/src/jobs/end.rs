//! Ends of attempts without a result, and the job's next state.

use bendtwin_core::{Category, Fault, ids::WorkerId};
use sqlx::{Sqlite, Transaction};

use super::{
    Job, JobId, Jobs, Lease, MAX_STALLED_ATTEMPTS,
    row::{self, Row, State, to_json},
};
use crate::{Error, Result, failpoint::Failpoint};

/// Reason for the end of an attempt.
#[derive(Clone, Debug, PartialEq)]
pub enum AttemptEnd {
    /// It failed; another attempt may do better.
    Failed(Fault),
    /// It failed because of its input: every attempt would.
    FailedForGood(Fault),
    /// It was asked to stop and did.
    Cancelled,
    /// The worker gave the job back in good order; the attempt does not count.
    Released,
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

    /// Ends all attempts whose leases have run out.
    ///
    /// # Errors
    /// Database errors.
    pub async fn sweep(&self) -> Result<Vec<Job>> {
        let expired: Vec<(String, String)> = sqlx::query_as(
            "select kind, id from jobs where state = 'running' and lease_until < $1 order by lease_until",
        )
        .bind(self.store.now_micros())
        .fetch_all(self.store.inner.database.read())
        .await?;
        let mut swept = Vec::new();
        for id in expired.iter().filter_map(|(kind, id)| JobId::stored(kind, id)) {
            swept.extend(self.lose(id, |row, now| row.lease_expired(now)).await?);
        }
        Ok(swept)
    }

    /// Ends all attempts of a worker that is known to be gone, without waiting for its leases.
    /// `counts` is false if its end has nothing to do with the job (the server itself went down).
    ///
    /// # Errors
    /// Database errors.
    pub async fn forfeit(&self, worker: WorkerId, counts: bool) -> Result<Vec<Job>> {
        let worker = worker.uuid().to_string();
        let held: Vec<(String, String)> =
            sqlx::query_as("select kind, id from jobs where state = 'running' and worker = $1")
                .bind(&worker)
                .fetch_all(self.store.inner.database.read())
                .await?;
        let mut lost = Vec::new();
        for id in held.iter().filter_map(|(kind, id)| JobId::stored(kind, id)) {
            let is_its = |row: &Row, _| row.worker.as_ref() == Some(&worker);
            lost.extend(if counts {
                self.lose(id, is_its).await?
            } else {
                self.end_if(id, is_its, |_| AttemptEnd::Released).await?
            });
        }
        Ok(lost)
    }

    async fn lose(&self, id: JobId, still: impl Fn(&Row, i64) -> bool) -> Result<Option<Job>> {
        let end = |row: &Row| {
            let worker = row.worker.as_deref().unwrap_or("unknown");
            AttemptEnd::Failed(Fault {
                category: Category::Unavailable,
                reason: "WORKER_LOST".to_owned(),
                message: format!("workers/{worker} stopped answering in attempt {}", row.attempts),
            })
        };
        self.end_if(id, still, end).await
    }

    /// Ends a running attempt if `still` holds once the write lock is taken.
    async fn end_if(
        &self,
        id: JobId,
        still: impl Fn(&Row, i64) -> bool,
        end: impl Fn(&Row) -> AttemptEnd,
    ) -> Result<Option<Job>> {
        let mut tx = self.store.inner.database.write().await?;
        let row = match row::fetch(&mut tx, id).await {
            Err(Error::NotFound { .. }) => return Ok(None),
            row => row?,
        };
        if row.state()? != State::Running || !still(&row, self.store.now_micros()) {
            return Ok(None);
        }
        let (checkpoint, end) = (row.checkpoint.clone(), end(&row));
        let job = self.apply(&mut tx, row, end).await?;
        let followers = self.fail_followers(&mut tx, &job).await?;
        tx.commit().await?;
        self.settled(&job, checkpoint, followers).await?;
        Ok(Some(job))
    }

    /// Writes the next state of a running job.
    pub(super) async fn apply(
        &self,
        tx: &mut Transaction<'_, Sqlite>,
        row: Row,
        end: AttemptEnd,
    ) -> Result<Job> {
        let mut faults: Vec<Fault> = serde_json::from_str(&row.attempt_faults).unwrap_or_default();
        let stalled_out = row.stalled >= i64::from(MAX_STALLED_ATTEMPTS);
        let cancelling = row.cancel_requested;
        let mut counted = 1;
        let (state, fault) = match end {
            AttemptEnd::Cancelled => (State::Cancelled, None),
            AttemptEnd::Released | AttemptEnd::Failed(_) if cancelling => (State::Cancelled, None),
            AttemptEnd::Released => {
                counted = 0;
                (State::Queued, None)
            }
            AttemptEnd::FailedForGood(fault) => (State::Failed, Some(fault)),
            AttemptEnd::Failed(fault) if stalled_out => (State::Failed, Some(fault)),
            AttemptEnd::Failed(fault) => {
                faults.push(fault);
                (State::Queued, None)
            }
        };
        let ended = state.has_ended();
        let updated: Row = sqlx::query_as(
            "update jobs set state = $2, fault = $3, attempt_faults = $4, attempts = $5,
                 stalled = $6, ended_at = $7, checkpoint = $8, lease_until = null, worker = null,
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
        .fetch_one(&mut **tx)
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
