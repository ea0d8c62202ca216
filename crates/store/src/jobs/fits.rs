//! Operations on fits alone: created, listed, ended with a twin.

use bendtwin_core::{
    Category, Fault, Problem as _,
    ids::{CaptureId, FitId, TwinId},
};

use uuid::Uuid;

use super::{
    Job, Jobs, Kind, Lease, Requirements, previews, requirements,
    row::{self, Row, State},
};
use crate::{
    Creator, Digest, Error, LabelChange, ListQuery, Page, Result, Staged, TwinFacts, captures,
    failpoint::Failpoint,
    keys::quotas::{self, More},
    labels::{self, Collection},
    owners::deleted_requests,
    owners::request_ids::{self, RequestId},
    sql::{Transaction, query, query_scalar},
    twins,
};

/// A fit to be queued.
#[derive(Clone, Debug, PartialEq)]
pub struct NewFit {
    /// The capture to be fitted.
    pub capture: CaptureId,
    /// Settings as JSON, the same text for the same settings.
    pub settings: String,
    /// Jobs of higher priority run earlier.
    pub priority: i32,
    /// Makes creation idempotent, if given.
    pub request_id: Option<String>,
    /// W3C traceparent of the call.
    pub trace_parent: Option<String>,
    /// Display name; empty means the capture's.
    pub display_name: String,
    /// The one who asks for it.
    pub creator: Creator,
    /// Worker that it asks for.
    pub requirements: Requirements,
}

impl Jobs<'_> {
    /// Queues a fit. It waits for its capture's ingest; if that has failed already, the fit fails
    /// with the same fault. The same request id with the same payload returns the job created
    /// before.
    ///
    /// # Errors
    /// [`Error::NotFound`] if there is no such capture, [`Error::CaptureHasNoPoints`] if its ingest
    /// ended with masks, [`Error::RequestIdTaken`], [`Error::DeletedSince`], [`Error::DiskFull`],
    /// [`Error::TooManyRequirements`].
    pub async fn create_fit(&self, new: NewFit) -> Result<Job> {
        self.store.admit()?;
        let requirements = new.requirements.to_text()?;
        let mut tx = self.store.inner.database.write().await?;
        let request = RequestId::of(&new.creator.owner, new.request_id.as_deref());
        if let Some(request) = request
            && let Some(row) = row::requested(&mut tx, request).await?
        {
            let same_name = row.first_name() == new.display_name;
            let before = Job::try_from(row)?;
            let given = (new.capture, &new.settings, new.priority);
            if before.id.fit().is_some()
                && same_name
                && (before.capture, &before.settings, before.priority) == given
                && before.requirements.to_text()? == requirements
            {
                return Ok(before);
            }
            let (request_id, name) = (request.id.to_owned(), before.id.to_string());
            return Err(Error::RequestIdTaken { request_id, name });
        }
        let kind = deleted_requests::Kind::Jobs;
        deleted_requests::refuse(&mut tx, kind, request, None).await?;
        let capture = new.capture.uuid().to_string();
        let capture_name = captures::fetch(&mut tx, new.capture).await?.labels.display_name;
        quotas::require(&mut tx, &new.creator, More::job()).await?;
        requirements::admit(&mut tx, Kind::Fit, &requirements).await?;
        let name = if new.display_name.is_empty() { &capture_name } else { &new.display_name };
        let ingest = row::ingest_of(&mut tx, &capture).await?.map(Job::try_from).transpose()?;
        if ingest.as_ref().is_some_and(|ingest| ingest.masks_only) {
            return Err(Error::CaptureHasNoPoints { name: new.capture });
        }
        let fault = ingest.as_ref().and_then(why_not);
        let now = self.store.now_micros();
        let request_id = request_ids::text_in(request, &mut tx, "jobs").await?;
        let row: Row = query(
            "insert into jobs (id, kind, capture, state, priority, settings, trace_parent,
                 request_id, created_at, fault, ended_at, display_name, first_name, name_key,
                 search_text, due_at, owner, requirements, max_running, max_run_s)
             values ($1, 'fit', $2, $3, $4, $5, $6, $7, $8, $9, $10, $11, $12, $13, $14, $8, $15,
                 $16, $17, $18)
             returning *",
        )
        .bind(FitId::generate().uuid().to_string())
        .bind(capture)
        .bind(if fault.is_some() { State::Failed } else { State::Queued }.as_str())
        .bind(i64::from(new.priority))
        .bind(new.settings)
        .bind(new.trace_parent)
        .bind(request_id)
        .bind(now)
        .bind(fault.as_ref().map(row::to_json))
        .bind(fault.is_some().then_some(now))
        .bind(name)
        .bind(&new.display_name)
        .bind(labels::name_key(name))
        .bind(labels::search_text(name, ""))
        .bind(new.creator.owner)
        .bind(requirements)
        .bind(new.creator.quotas.running_jobs.map(quotas::as_integer))
        .bind(new.creator.quotas.fit_run_s.map(quotas::as_integer))
        .fetch_one(&mut tx)
        .await?;
        self.store.pass(Failpoint::BeforeCommit)?;
        tx.commit().await?;
        let fit = Job::try_from(row)?;
        self.changed(&fit);
        self.store.pass(Failpoint::AfterCommit)?;
        Ok(fit)
    }

    /// A page of fits.
    ///
    /// # Errors
    /// [`Error::InvalidPageToken`].
    pub async fn fits(&self, query: &ListQuery) -> Result<Page<Job>> {
        let rows: Vec<Row> = query
            .select(Collection::Fits)?
            .build()
            .fetch_all(self.store.inner.database.read())
            .await?;
        let items = rows.into_iter().map(Job::try_from).collect::<Result<_>>()?;
        let listing = query.listing(Collection::Fits);
        let page = Page::cut(items, &query.page, &listing, |f: &Job| {
            let name_key = labels::name_key(&f.labels.display_name);
            (f.id.uuid(), query.key(&name_key, labels::key_of(f.error_m)))
        });
        Ok(page.of(query.total(self.store, Collection::Fits).await?))
    }

    /// Changes name, note and tags of a fit.
    ///
    /// # Errors
    /// [`Error::NotFound`], [`Error::TooManyTags`].
    pub async fn update_fit(&self, id: FitId, change: &LabelChange) -> Result<Job> {
        let key = id.uuid().to_string();
        let mut tx = self.store.inner.database.write().await?;
        let before = Job::try_from(row::fetch(&mut tx, id.into()).await?)?;
        if !labels::change(&mut tx, Collection::Fits, &key, &before.labels, change).await? {
            return Ok(before);
        }
        let row: Row = query("update jobs set revision = revision + 1 where id = $1 returning *")
            .bind(key)
            .fetch_one(&mut tx)
            .await?;
        tx.commit().await?;
        let fit = Job::try_from(row)?;
        let _ = self.store.inner.changes.send(fit.id);
        Ok(fit)
    }

    /// Stores the twin and ends the fit, in one transaction. Called again under the same lease with
    /// the same content, it returns the same.
    ///
    /// # Errors
    /// [`Error::StaleLease`], file errors.
    pub async fn complete_fit(
        &self,
        lease: Lease,
        facts: &TwinFacts,
        content: Staged,
    ) -> Result<TwinId> {
        let (digest, size_bytes) = (content.digest(), content.size_bytes());
        let guard = self.store.publish(content).await?;
        let stored = self.complete_published(lease, facts, digest, size_bytes).await;
        drop(guard);
        let obsolete = match &stored {
            Ok((_, checkpoint)) => checkpoint.clone(),
            Err(Error::Failpoint(_)) => None,
            Err(_) => Some(digest.to_hex().to_string()),
        };
        if stored.is_ok() {
            self.store.pass(Failpoint::AfterCommit)?;
            self.store.pass(Failpoint::BeforeRelease)?;
        }
        if let Some(obsolete) = obsolete {
            self.store.release(&obsolete).await?;
        }
        stored.map(|(twin, _)| twin)
    }

    /// The transaction of [`Jobs::complete_fit`]; also returns the checkpoint that is obsolete
    /// afterwards.
    pub(crate) async fn complete_published(
        &self,
        lease: Lease,
        facts: &TwinFacts,
        digest: Digest,
        size_bytes: u64,
    ) -> Result<(TwinId, Option<String>)> {
        let mut tx = self.store.inner.database.write().await?;
        let before = row::fetch(&mut tx, lease.job).await?;
        // A job that has ended has no worker any more: the digest is compared in its place.
        if let (State::Succeeded, true, Some(twin)) =
            (before.state()?, before.has_epoch_of(lease), &before.twin)
        {
            let stored: Option<String> = query_scalar("select digest from twins where id = $1")
                .bind(twin)
                .fetch_optional(&mut tx)
                .await?;
            if let (true, Ok(twin)) =
                (stored.as_deref() == Some(digest.to_hex().as_str()), Uuid::try_parse(twin))
            {
                return Ok((twin.into(), None));
            }
        }
        let before = row::fetch_leased(&mut tx, lease).await?;
        let twin = self.insert_twin(&mut tx, &before, facts, digest, size_bytes).await?;
        let row: Row = query(
            "update jobs set state = 'succeeded', twin = $2, ended_at = $3, lease_until = null,
                 worker = null, checkpoint = null, error_m = $4, measure = $5,
                 revision = revision + 1
             where id = $1 returning *",
        )
        .bind(&before.id)
        .bind(twin.uuid().to_string())
        .bind(self.store.now_micros())
        .bind(labels::error_key(&facts.quality))
        .bind(labels::headline(&facts.quality).map(|(measure, _)| measure.as_str()))
        .fetch_one(&mut tx)
        .await?;
        previews::forget(&mut tx, &before.id).await?;
        self.store.pass(Failpoint::BeforeCommit)?;
        tx.commit().await?;
        self.changed(&Job::try_from(row)?);
        Ok((twin, before.checkpoint))
    }

    /// A twin under its fit's name.
    async fn insert_twin(
        &self,
        tx: &mut Transaction,
        fit: &Row,
        facts: &TwinFacts,
        digest: Digest,
        size_bytes: u64,
    ) -> Result<TwinId> {
        let new = twins::Insert {
            display_name: &fit.display_name,
            origin: Some((&fit.capture, &fit.id)),
            size_bytes,
            digest,
            facts,
            request_id: None,
            owner: &fit.owner,
            now: self.store.now_micros(),
        };
        Ok(twins::insert(tx, new).await?.id)
    }

    /// Fails the fits that wait for an ingest that has ended without an observation. Returns each
    /// with its checkpoint.
    pub(super) async fn fail_followers(
        &self,
        tx: &mut Transaction,
        ingest: &Job,
    ) -> Result<Vec<(Job, Option<String>)>> {
        let Some(fault) = why_not(ingest) else { return Ok(Vec::new()) };
        let waiting: Vec<(String, Option<String>)> = query(
            "select id, checkpoint from jobs
             where capture = $1 and kind = 'fit' and state = 'queued'",
        )
        .bind(ingest.capture.uuid().to_string())
        .fetch_all(&mut *tx)
        .await?;
        let mut failed = Vec::with_capacity(waiting.len());
        for (id, checkpoint) in waiting {
            let row: Row = query(
                "update jobs set state = 'failed', fault = $2, ended_at = $3, checkpoint = null,
                     revision = revision + 1
                 where id = $1 returning *",
            )
            .bind(id)
            .bind(row::to_json(&fault))
            .bind(self.store.now_micros())
            .fetch_one(&mut *tx)
            .await?;
            failed.push((row.try_into()?, checkpoint));
        }
        Ok(failed)
    }
}

/// Reason for which fits of a capture cannot run, if its ingest has ended without an observation.
pub(super) fn why_not(ingest: &Job) -> Option<Fault> {
    match (ingest.id, ingest.state) {
        (super::JobId::Ingest(_), State::Failed) => ingest.fault.clone(),
        (super::JobId::Ingest(_), State::Succeeded) if ingest.masks_only => {
            Some(Error::CaptureHasNoPoints { name: ingest.capture }.fault())
        }
        (super::JobId::Ingest(_), State::Cancelled) => Some(Fault {
            category: Category::FailedPrecondition,
            reason: "INGEST_CANCELLED".to_owned(),
            message: format!(
                "the ingest of {} was cancelled: run it again, then fit",
                ingest.capture
            ),
        }),
        _ => None,
    }
}
