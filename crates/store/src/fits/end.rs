//! How attempts end other than in a twin, and what becomes of the job then.

use bendtwin_core::{
    Category, Fault,
    ids::{FitId, WorkerId},
};
use sqlx::{Sqlite, Transaction};
use uuid::Uuid;

use super::{
    Fit, Fits, Lease, MAX_STALLED_ATTEMPTS,
    row::{self, Row, State},
};
use crate::{Error, Result, failpoint::Failpoint};

/// Why an attempt ended.
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

impl Fits<'_> {
    /// Ends the attempt under this lease.
    ///
    /// # Errors
    /// [`Error::StaleLease`].
    pub async fn end_attempt(&self, lease: Lease, end: AttemptEnd) -> Result<Fit> {
        let mut tx = self.store.inner.database.write().await?;
        let row = row::fetch_leased(&mut tx, lease.fit, lease.epoch).await?;
        let checkpoint = row.checkpoint.clone();
        let fit = self.apply(&mut tx, row, end).await?;
        self.store.pass(Failpoint::BeforeCommit)?;
        tx.commit().await?;
        self.settled(&fit, checkpoint).await?;
        Ok(fit)
    }

    /// Ends all attempts whose leases have run out.
    ///
    /// # Errors
    /// Database errors.
    pub async fn sweep(&self) -> Result<Vec<Fit>> {
        let expired: Vec<String> = sqlx::query_scalar(
            "select id from jobs where state = 'running' and lease_until < $1 order by lease_until",
        )
        .bind(self.store.now_micros())
        .fetch_all(self.store.inner.database.read())
        .await?;
        let mut swept = Vec::new();
        for id in expired {
            swept.extend(self.lose(&id, |row, now| row.lease_expired(now)).await?);
        }
        Ok(swept)
    }

    /// Ends all attempts of a worker that is known to be gone, without waiting
    /// for its leases. `counts` is false where its end says nothing about the job
    /// (the server itself went down).
    ///
    /// # Errors
    /// Database errors.
    pub async fn forfeit(&self, worker: WorkerId, counts: bool) -> Result<Vec<Fit>> {
        let worker = worker.uuid().to_string();
        let held: Vec<String> =
            sqlx::query_scalar("select id from jobs where state = 'running' and worker = $1")
                .bind(&worker)
                .fetch_all(self.store.inner.database.read())
                .await?;
        let mut lost = Vec::new();
        for id in held {
            let is_its = |row: &Row, _| row.worker.as_ref() == Some(&worker);
            lost.extend(if counts {
                self.lose(&id, is_its).await?
            } else {
                self.end_if(&id, is_its, |_| AttemptEnd::Released).await?
            });
        }
        Ok(lost)
    }

    async fn lose(&self, id: &str, still: impl Fn(&Row, i64) -> bool) -> Result<Option<Fit>> {
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
        id: &str,
        still: impl Fn(&Row, i64) -> bool,
        end: impl Fn(&Row) -> AttemptEnd,
    ) -> Result<Option<Fit>> {
        let Ok(id) = Uuid::try_parse(id).map(FitId::from) else { return Ok(None) };
        let mut tx = self.store.inner.database.write().await?;
        let row = match row::fetch(&mut tx, id).await {
            Err(Error::NotFound { .. }) => return Ok(None),
            row => row?,
        };
        if row.state()? != State::Running || !still(&row, self.store.now_micros()) {
            return Ok(None);
        }
        let (checkpoint, end) = (row.checkpoint.clone(), end(&row));
        let fit = self.apply(&mut tx, row, end).await?;
        tx.commit().await?;
        self.settled(&fit, checkpoint).await?;
        Ok(Some(fit))
    }

    /// Writes what becomes of a running job.
    async fn apply(
        &self,
        tx: &mut Transaction<'_, Sqlite>,
        row: Row,
        end: AttemptEnd,
    ) -> Result<Fit> {
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

    async fn settled(&self, fit: &Fit, checkpoint: Option<String>) -> Result<()> {
        self.changed(fit);
        match checkpoint {
            Some(digest) if fit.state.has_ended() => self.store.release(&digest).await,
            _ => Ok(()),
        }
    }
}

fn to_json(value: &impl serde::Serialize) -> String {
    // Faults are strings: they always serialise.
    serde_json::to_string(value).unwrap_or_default()
}
