//! Fit jobs: the queue. The design is in the crate's documentation; here are
//! the nouns and what users do, in `lease.rs` what workers do, in `end.rs` how
//! attempts end, in `row.rs` the row.

mod end;
mod lease;
mod row;

use std::time::Duration;

use bendtwin_core::{
    Fault, Progress,
    ids::{CaptureId, FitId, TwinId, WorkerId},
};
use jiff::Timestamp;
use tokio::sync::broadcast;

use crate::{Digest, Error, Page, PageRequest, Result, Store, failpoint::Failpoint};

pub use end::AttemptEnd;
pub use lease::{Lease, Reported};
pub use row::State;

use row::Row;

/// Attempts without progress after which a job fails.
pub const MAX_STALLED_ATTEMPTS: u32 = 3;

/// A fit job.
#[derive(Clone, Debug, PartialEq)]
pub struct Fit {
    /// Its id.
    pub id: FitId,
    /// What is fitted.
    pub capture: CaptureId,
    /// Where it is in its life.
    pub state: State,
    /// The settings in force, as JSON.
    pub settings: String,
    /// Higher runs earlier.
    pub priority: i32,
    /// Claims that counted.
    pub attempts: u32,
    /// The fencing number: how often it was claimed at all.
    pub lease_epoch: u64,
    /// When the lease runs out, while it runs.
    pub lease_until: Option<Timestamp>,
    /// Who runs it, while it runs.
    pub worker: Option<WorkerId>,
    /// The last report.
    pub progress: Option<Progress>,
    /// The newest checkpoint's digest, until it ends.
    pub checkpoint: Option<Digest>,
    /// Whether it has been asked to stop.
    pub cancel_requested: bool,
    /// What it made.
    pub twin: Option<TwinId>,
    /// Why it failed.
    pub fault: Option<Fault>,
    /// Why earlier attempts ended.
    pub attempt_faults: Vec<Fault>,
    /// W3C traceparent of the call that created it.
    pub trace_parent: Option<String>,
    /// The idempotency key it was created under.
    pub request_id: Option<String>,
    /// When it was created.
    pub created: Timestamp,
    /// When it was first claimed.
    pub started: Option<Timestamp>,
    /// When it ended.
    pub ended: Option<Timestamp>,
    /// Grows with every change.
    pub revision: u64,
}

/// A job to be queued.
#[derive(Clone, Debug, PartialEq)]
pub struct NewFit {
    /// What to fit.
    pub capture: CaptureId,
    /// Settings as JSON, the same text for the same settings.
    pub settings: String,
    /// Higher runs earlier.
    pub priority: i32,
    /// Makes creation idempotent, if given.
    pub request_id: Option<String>,
    /// W3C traceparent of the call.
    pub trace_parent: Option<String>,
}

/// How many jobs there are of each state, and how long the queue is in time.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct QueueDepth {
    /// Jobs by state; a state without jobs is left out.
    pub by_state: Vec<(State, u64)>,
    /// How long the oldest queued job has been there.
    pub oldest_queued: Option<Duration>,
}

/// The fit jobs of a store.
#[derive(Clone, Copy, Debug)]
pub struct Fits<'a> {
    pub(crate) store: &'a Store,
}

impl Fits<'_> {
    /// Queues a job. The same request id with the same payload gives the job
    /// that it made before.
    ///
    /// # Errors
    /// [`Error::NotFound`] if there is no such capture, [`Error::RequestIdTaken`].
    pub async fn create(&self, new: NewFit) -> Result<Fit> {
        let mut tx = self.store.inner.database.write().await?;
        if let Some(request_id) = &new.request_id {
            let row: Option<Row> = sqlx::query_as("select * from jobs where request_id = $1")
                .bind(request_id)
                .fetch_optional(&mut *tx)
                .await?;
            if let Some(row) = row {
                let before = Fit::try_from(row)?;
                let given = (new.capture, &new.settings, new.priority);
                if (before.capture, &before.settings, before.priority) == given {
                    return Ok(before);
                }
                let (request_id, name) = (request_id.clone(), before.id.to_string());
                return Err(Error::RequestIdTaken { request_id, name });
            }
        }
        let capture = new.capture.uuid().to_string();
        let exists: bool =
            sqlx::query_scalar("select exists (select 1 from captures where id = $1)")
                .bind(&capture)
                .fetch_one(&mut *tx)
                .await?;
        if !exists {
            return Err(Error::NotFound { name: new.capture.to_string() });
        }
        let row: Row = sqlx::query_as(
            "insert into jobs (id, kind, capture, state, priority, settings, trace_parent,
                 request_id, created_at)
             values ($1, 'fit', $2, 'queued', $3, $4, $5, $6, $7) returning *",
        )
        .bind(FitId::generate().uuid().to_string())
        .bind(capture)
        .bind(i64::from(new.priority))
        .bind(new.settings)
        .bind(new.trace_parent)
        .bind(new.request_id)
        .bind(self.store.now_micros())
        .fetch_one(&mut *tx)
        .await?;
        self.store.pass(Failpoint::BeforeCommit)?;
        tx.commit().await?;
        let fit = Fit::try_from(row)?;
        self.changed(&fit);
        self.store.pass(Failpoint::AfterCommit)?;
        Ok(fit)
    }

    /// One job.
    ///
    /// # Errors
    /// [`Error::NotFound`].
    pub async fn get(&self, id: FitId) -> Result<Fit> {
        let row: Option<Row> = sqlx::query_as("select * from jobs where id = $1")
            .bind(id.uuid().to_string())
            .fetch_optional(self.store.inner.database.read())
            .await?;
        row.ok_or_else(|| Error::NotFound { name: id.to_string() })?.try_into()
    }

    /// A page of jobs, newest first; only those of a capture, if one is given.
    ///
    /// # Errors
    /// [`Error::InvalidPageToken`].
    pub async fn list(&self, page: &PageRequest, capture: Option<CaptureId>) -> Result<Page<Fit>> {
        let capture = capture.map(|c| c.uuid().to_string());
        let listing = format!("fits/{}", capture.as_deref().unwrap_or_default());
        let rows: Vec<Row> = sqlx::query_as(
            "select * from jobs where id < $1 and ($3 is null or capture = $3)
             order by id desc limit $2",
        )
        .bind(page.before(&listing)?)
        .bind(page.fetch())
        .bind(capture)
        .fetch_all(self.store.inner.database.read())
        .await?;
        let items = rows.into_iter().map(Fit::try_from).collect::<Result<_>>()?;
        Ok(Page::cut(items, page, &listing, |f: &Fit| f.id.uuid()))
    }

    /// Asks a job to stop: a queued one has then ended, a running one ends when
    /// its worker hears of it, an ended one stays as it is.
    ///
    /// # Errors
    /// [`Error::NotFound`].
    pub async fn cancel(&self, id: FitId) -> Result<Fit> {
        let key = id.uuid().to_string();
        let mut tx = self.store.inner.database.write().await?;
        let row = row::fetch(&mut tx, id).await?;
        let checkpoint = row.checkpoint.clone();
        let row: Row = match row.state()? {
            State::Queued => {
                sqlx::query_as(
                    "update jobs set state = 'cancelled', cancel_requested = true,
                         checkpoint = null, ended_at = $2, revision = revision + 1
                     where id = $1 returning *",
                )
                .bind(key)
                .bind(self.store.now_micros())
                .fetch_one(&mut *tx)
                .await?
            }
            State::Running if !row.cancel_requested => {
                sqlx::query_as(
                    "update jobs set cancel_requested = true, revision = revision + 1
                     where id = $1 returning *",
                )
                .bind(key)
                .fetch_one(&mut *tx)
                .await?
            }
            _ => return row.try_into(),
        };
        tx.commit().await?;
        let fit = Fit::try_from(row)?;
        self.changed(&fit);
        if let (Some(digest), true) = (checkpoint, fit.state.has_ended()) {
            self.store.release(&digest).await?;
        }
        Ok(fit)
    }

    /// Deletes a job that does not run. Its twin stays.
    ///
    /// # Errors
    /// [`Error::NotFound`], [`Error::FitRunning`].
    pub async fn delete(&self, id: FitId) -> Result<()> {
        let mut tx = self.store.inner.database.write().await?;
        let row = row::fetch(&mut tx, id).await?;
        if row.state()? == State::Running {
            return Err(Error::FitRunning { fit: id });
        }
        sqlx::query("delete from jobs where id = $1")
            .bind(id.uuid().to_string())
            .execute(&mut *tx)
            .await?;
        tx.commit().await?;
        let _ = self.store.inner.changes.send(id);
        match row.checkpoint {
            Some(digest) => self.store.release(&digest).await,
            None => Ok(()),
        }
    }

    /// Tells the ids of jobs that change from now on. A receiver that lags
    /// behind should read again what it cares about.
    pub fn changes(&self) -> broadcast::Receiver<FitId> {
        self.store.inner.changes.subscribe()
    }

    /// How full the queue is.
    ///
    /// # Errors
    /// Database errors.
    pub async fn depth(&self) -> Result<QueueDepth> {
        let rows: Vec<(String, i64, i64)> =
            sqlx::query_as("select state, count(*), min(created_at) from jobs group by state")
                .fetch_all(self.store.inner.database.read())
                .await?;
        let mut depth = QueueDepth::default();
        for (name, count, oldest) in rows {
            let Some(state) = State::parse(&name) else { continue };
            depth.by_state.push((state, count.max(0) as u64));
            if state == State::Queued {
                let waited = self.store.now_micros().saturating_sub(oldest).max(0);
                depth.oldest_queued = Some(Duration::from_micros(waited as u64));
            }
        }
        Ok(depth)
    }

    /// Wakes watchers, and claimants if the job is for them.
    fn changed(&self, fit: &Fit) {
        // No receiver, no matter.
        let _ = self.store.inner.changes.send(fit.id);
        if fit.state == State::Queued {
            self.store.inner.queued.notify_waiters();
        }
    }
}

#[cfg(test)]
mod tests;
