//! Operations on ingests alone: one for each capture, created with it, ended with an observation
//! and a report, repeated on request.

use bendtwin_core::ids::{CaptureId, IngestId};

use super::{
    AttemptEnd, Job, JobId, Jobs, Kind, Lease, Requirements, requirements,
    row::{self, Row, State},
};
use crate::{
    Creator, Digest, Error, Result, Staged,
    captures::{
        self, observations,
        products::{self, Product},
    },
    failpoint::Failpoint,
    keys::quotas::{self, More},
    owners::deleted_requests,
    owners::request_ids::{self, RequestId},
    sql::{Builder, Transaction, query, query_scalar},
};

/// An ingest to be run again.
#[derive(Clone, Debug, PartialEq)]
pub struct NewIngest {
    /// The capture to be read.
    pub capture: CaptureId,
    /// Settings as JSON, the same text for the same settings.
    pub settings: String,
    /// Idempotency key; refused for a day once another ingest has replaced this one.
    pub request_id: Option<String>,
    /// W3C traceparent of the call.
    pub trace_parent: Option<String>,
    /// The one who asks for it.
    pub creator: Creator,
    /// Worker that it asks for.
    pub requirements: Requirements,
}

/// A report to be stored.
#[derive(Debug)]
pub struct NewReport {
    /// Verdict: one lower-case word.
    pub verdict: String,
    /// The report as JSON.
    pub json: Staged,
    /// The report as HTML.
    pub html: Staged,
}

/// End of an attempt at an ingest, with its results.
#[derive(Debug)]
pub struct IngestResult {
    /// The end.
    pub outcome: IngestOutcome,
    /// Playback for the player.
    pub playback: Option<Staged>,
    /// Masks that were made of strokes.
    pub masks: Option<Staged>,
    /// The report of the capture.
    pub report: NewReport,
}

/// End of an attempt at an ingest that has a report.
#[derive(Debug)]
pub enum IngestOutcome {
    /// The capture can be fitted: fits read this bundle.
    Observed(Box<Staged>),
    /// The ingest ended with masks, as it was to: there is nothing to fit yet.
    Masked,
    /// The capture cannot be fitted.
    Refused(AttemptEnd),
}

/// Origin of a job: its owner, the W3C traceparent of the call, the worker that it asks for, and how
/// many jobs of its owner may run beside it.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct JobOrigin<'a> {
    pub(crate) owner: &'a str,
    pub(crate) trace_parent: Option<&'a str>,
    pub(crate) requirements: &'a str,
    pub(crate) max_running: Option<u64>,
}

/// Refuses an ingest whose requirements would exceed the number of kinds that a claim checks.
pub(crate) async fn admit_ingest(tx: &mut Transaction, requirements: &str) -> Result<()> {
    requirements::admit(tx, Kind::Ingest, requirements).await
}

/// Queues the ingest of a new capture within the caller's transaction.
pub(crate) async fn enqueue(
    tx: &mut Transaction,
    capture: &str,
    settings: &str,
    asked: JobOrigin<'_>,
    now: i64,
) -> Result<Job> {
    let due = due(tx, capture, now).await?;
    let row: Row = query(
        "insert into jobs (id, kind, capture, state, priority, settings, created_at, due_at,
             owner, trace_parent, requirements, max_running)
         values ($1, 'ingest', $2, 'queued', 0, $3, $4, $5, $6, $7, $8, $9) returning *",
    )
    .bind(IngestId::generate().uuid().to_string())
    .bind(capture)
    .bind(settings)
    .bind(now)
    .bind(due)
    .bind(asked.owner)
    .bind(asked.trace_parent)
    .bind(asked.requirements)
    .bind(asked.max_running.map(quotas::as_integer))
    .fetch_one(&mut *tx)
    .await?;
    row.try_into()
}

/// Time at which the ingest of a capture that is queued now is due: it would be done first if each
/// began when it was queued and took a second for a megabyte, ten minutes at most [us].
async fn due(tx: &mut Transaction, capture: &str, now: i64) -> Result<i64> {
    const LONGEST: i64 = 600_000_000;
    let size: Option<i64> = query_scalar("select size_bytes from captures where id = $1")
        .bind(capture)
        .fetch_optional(tx)
        .await?;
    Ok(now.saturating_add(size.unwrap_or(0).clamp(0, LONGEST)))
}

/// Refuses a change of what ingests read of a capture while a job of it is queued or running: no job is
/// to see two states of it.
///
/// # Errors
/// [`Error::NotFound`], [`Error::IngestUnderWay`], [`Error::CaptureInUse`].
pub(crate) async fn require_idle(tx: &mut Transaction, capture: CaptureId) -> Result<()> {
    idle_ingest(tx, capture).await.map(drop)
}

/// The ingest of a capture of which no job is queued or running.
async fn idle_ingest(tx: &mut Transaction, capture: CaptureId) -> Result<Row> {
    let key = capture.uuid().to_string();
    captures::fetch(tx, capture).await?;
    let ingest = row::ingest_of(tx, &key).await?;
    let ingest = ingest.ok_or_else(|| Error::NotFound { name: capture.to_string() })?;
    if !ingest.state()?.has_ended() {
        return Err(Error::IngestUnderWay { name: capture.to_string() });
    }
    let fits = row::fits_under_way(tx, &key).await?;
    if fits > 0 {
        return Err(Error::CaptureInUse { name: capture.to_string(), fits });
    }
    Ok(ingest)
}

/// Forgets the ingest of a capture within the caller's transaction.
/// Returns its id and its checkpoint.
pub(crate) async fn dequeue(
    tx: &mut Transaction,
    capture: &str,
) -> Result<Option<(JobId, Option<String>)>> {
    let row: Option<Row> =
        query("delete from jobs where capture = $1 and kind = 'ingest' returning *")
            .bind(capture)
            .fetch_optional(&mut *tx)
            .await?;
    row.map(|row| Ok((row.job()?, row.checkpoint))).transpose()
}

impl Jobs<'_> {
    /// The ingest of a capture: the last one that was asked for.
    ///
    /// # Errors
    /// [`Error::NotFound`].
    pub async fn ingest_of(&self, capture: CaptureId) -> Result<Job> {
        let row: Option<Row> = query("select * from jobs where capture = $1 and kind = 'ingest'")
            .bind(capture.uuid().to_string())
            .fetch_optional(self.store.inner.database.read())
            .await?;
        row.ok_or_else(|| Error::NotFound { name: capture.to_string() })?.try_into()
    }

    /// The ingests of these captures, in any order.
    pub(crate) async fn ingests_of(&self, captures: &[String]) -> Result<Vec<Job>> {
        let mut sql = Builder::new("select * from jobs where kind = 'ingest' and capture in (");
        sql.push_list(captures).push(") and trashed_at is null");
        let rows: Vec<Row> = sql.build().fetch_all(self.store.inner.database.read()).await?;
        rows.into_iter().map(Job::try_from).collect()
    }

    /// Runs the ingest of a capture again, in place of the previous one, whose results stay until
    /// this one has replaced them.
    ///
    /// # Errors
    /// [`Error::NotFound`], [`Error::RequestIdTaken`], [`Error::DeletedSince`],
    /// [`Error::IngestUnderWay`], [`Error::TooManyRequirements`]; [`Error::CaptureInUse`] while fits of
    /// it are queued or running: they are not to see two observations.
    pub async fn create_ingest(&self, new: NewIngest) -> Result<Job> {
        let key = new.capture.uuid().to_string();
        let requirements = new.requirements.to_text()?;
        let mut tx = self.store.inner.database.write().await?;
        let request = RequestId::of(&new.creator.owner, new.request_id.as_deref());
        if let Some(request) = request
            && let Some(row) = row::requested(&mut tx, request).await?
        {
            let before = Job::try_from(row)?;
            if before.id.fit().is_none()
                && (before.capture, &before.settings) == (new.capture, &new.settings)
                && before.requirements.asked().to_text()? == requirements
            {
                return Ok(before);
            }
            let (request_id, name) = (request.id.to_owned(), before.id.to_string());
            return Err(Error::RequestIdTaken { request_id, name });
        }
        let kind = deleted_requests::Kind::Jobs;
        deleted_requests::refuse(&mut tx, kind, request, None).await?;
        let before = idle_ingest(&mut tx, new.capture).await?;
        quotas::require(&mut tx, &new.creator, More::job()).await?;
        admit_ingest(&mut tx, &requirements).await?;
        query("delete from jobs where id = $1").bind(&before.id).execute(&mut tx).await?;
        let replaced = before.request_id.as_deref();
        let replaced = replaced.map(|stored| RequestId::of_row(stored, &before.owner));
        let name = format!("ingests/{}", before.id);
        let kind = deleted_requests::Kind::Jobs;
        self.store.keep_request_id(&mut tx, kind, replaced, &name).await?;
        let now = self.store.now_micros();
        let due = due(&mut tx, &key, now).await?;
        let request_id = request_ids::text_in(request, &mut tx, "jobs").await?;
        let row: Row = query(
            "insert into jobs (id, kind, capture, state, priority, settings, trace_parent,
                 request_id, created_at, revision, due_at, owner, requirements, max_running)
             values ($1, 'ingest', $2, 'queued', 0, $3, $4, $5, $6, $7, $8, $9, $10, $11)
             returning *",
        )
        .bind(IngestId::generate().uuid().to_string())
        .bind(key)
        .bind(new.settings)
        .bind(new.trace_parent)
        .bind(request_id)
        .bind(now)
        .bind(before.revision + 1)
        .bind(due)
        .bind(new.creator.owner)
        .bind(requirements)
        .bind(new.creator.quotas.running_jobs.map(quotas::as_integer))
        .fetch_one(&mut tx)
        .await?;
        tx.commit().await?;
        let job = Job::try_from(row)?;
        self.changed(&job);
        Ok(job)
    }

    /// Stores the results of an ingest and ends its attempt, in one transaction. Called again under
    /// the same lease with the same results, it returns the same.
    ///
    /// # Errors
    /// [`Error::StaleLease`], file errors.
    pub async fn end_ingest(&self, lease: Lease, result: IngestResult) -> Result<Job> {
        let IngestResult { outcome, playback, masks, report } = result;
        let NewReport { verdict, json, html } = report;
        let (observation, end) = match outcome {
            IngestOutcome::Observed(observation) => (Some(*observation), None),
            IngestOutcome::Masked => (None, None),
            IngestOutcome::Refused(end) => (None, Some(end)),
        };
        let of = |content: &Staged| (content.digest(), content.size_bytes());
        let made = observations::NewResults {
            succeeded: end.is_none(),
            products: [&observation, &playback, &masks].map(|made| made.as_ref().map(of)),
            verdict,
            json: json.digest(),
            html: html.digest(),
            report_bytes: json.size_bytes() + html.size_bytes(),
        };
        let contents: Vec<Staged> =
            [observation, playback, masks].into_iter().flatten().chain([json, html]).collect();
        let new: Vec<Digest> = contents.iter().map(Staged::digest).collect();
        let guard = self.store.publish_all(contents).await?;
        let stored = self.end_published(lease, &made, end).await;
        drop(guard);
        let obsolete = match &stored {
            Ok((_, obsolete)) => obsolete.clone(),
            Err(Error::Failpoint(_)) => Vec::new(),
            Err(_) => new.iter().map(|d| d.to_hex().to_string()).collect(),
        };
        if stored.is_ok() {
            self.store.pass(Failpoint::AfterCommit)?;
            self.store.pass(Failpoint::BeforeRelease)?;
        }
        for digest in obsolete {
            self.store.release(&digest).await?;
        }
        stored.map(|(job, _)| job)
    }

    /// The transaction of [`Jobs::end_ingest`]; also returns the content that is obsolete
    /// afterwards.
    async fn end_published(
        &self,
        lease: Lease,
        made: &observations::NewResults,
        end: Option<AttemptEnd>,
    ) -> Result<(Job, Vec<String>)> {
        let mut tx = self.store.inner.database.write().await?;
        let before = row::fetch(&mut tx, lease.job).await?;
        // A job that has ended has no worker any more: digests are compared in its place.
        if before.state()? == State::Succeeded
            && before.has_epoch_of(lease)
            && end.is_none()
            && has_stored(&mut tx, &before.capture, made).await?
        {
            return Ok((before.try_into()?, Vec::new()));
        }
        let before = row::fetch_leased(&mut tx, lease).await?;
        let now = self.store.now_micros();
        let mut obsolete = observations::replace(&mut tx, &before.capture, made, now).await?;
        obsolete.extend(before.checkpoint.clone());
        let [observation, ..] = made.products;
        let job: Job = match end {
            Some(end) => self.apply(&mut tx, before, end).await?,
            None => {
                let row: Row = query(
                    "update jobs set state = 'succeeded', ended_at = $2, lease_until = null,
                         worker = null, checkpoint = null, masks_only = $3,
                         revision = revision + 1
                     where id = $1 returning *",
                )
                .bind(&before.id)
                .bind(now)
                .bind(observation.is_none())
                .fetch_one(&mut tx)
                .await?;
                row.try_into()?
            }
        };
        let followers = self.fail_followers(&mut tx, &job).await?;
        self.store.pass(Failpoint::BeforeCommit)?;
        tx.commit().await?;
        self.changed(&job);
        for (fit, checkpoint) in followers {
            self.changed(&fit);
            obsolete.extend(checkpoint);
        }
        // The content to which the job still refers is not released: the caller checks that.
        Ok((job, obsolete))
    }
}

/// True if observation and masks of a capture are these.
async fn has_stored(
    tx: &mut Transaction,
    capture: &str,
    made: &observations::NewResults,
) -> Result<bool> {
    let [observation, _, masks] = made.products;
    let hex = |made: Option<(Digest, u64)>| made.map(|(digest, _)| digest.to_hex().to_string());
    Ok(products::digest_of(tx, Product::Observation, capture).await? == hex(observation)
        && products::digest_of(tx, Product::Masks, capture).await? == hex(masks))
}
