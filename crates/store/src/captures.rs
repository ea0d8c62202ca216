//! Captures: immutable content with a name, and the state of their ingest.

pub(crate) mod observations;
pub(crate) mod products;
pub(crate) mod supplements;

use std::collections::HashMap;

use bendtwin_core::ids::CaptureId;
use jiff::Timestamp;
use uuid::Uuid;

use crate::{
    Content, Creator, Digest, Error, Job, LabelChange, Labels, ListQuery, Page, Report,
    Requirements, Result, Staged, Store, Supplement,
    failpoint::Failpoint,
    jobs::{self, JobOrigin},
    keys::quotas::{self, More, reservation::Reservation},
    labels::{self, Collection},
    owners::deleted_requests::{self, Kind},
    owners::request_ids::{self, RequestId},
    sql::{Transaction, query, query_scalar, row::row},
    store::clock::from_micros,
    trash::{self, Remove},
    uploads,
};

/// A stored capture.
#[derive(Clone, Debug, PartialEq)]
pub struct Capture {
    /// Id of the capture.
    pub id: CaptureId,
    /// Display name, note and tags.
    pub labels: Labels,
    /// Time of storage.
    pub created: Timestamp,
    /// Size of the archive [bytes].
    pub size_bytes: u64,
    /// BLAKE3 of the archive.
    pub digest: Digest,
    /// Owner of the key with which it was uploaded; empty if that is not known.
    pub owner: String,
    /// Who recorded it; empty if that was not stated.
    pub recorded_by: String,
}

/// A capture with its ingest, its report and what was added to it.
#[derive(Clone, Debug, PartialEq)]
pub struct Overview {
    /// The capture.
    pub capture: Capture,
    /// The job that reads it.
    pub ingest: Job,
    /// Report, once an ingest has made it.
    pub report: Option<Report>,
    /// Files that were added to it, in the order of their kinds.
    pub supplements: Vec<Supplement>,
    /// True if the last ingest made masks of strokes.
    pub has_masks: bool,
}

/// Facts of a capture that its uploader states.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CaptureFacts {
    /// Display name.
    pub display_name: String,
    /// Who recorded it; empty if that is not stated.
    pub recorded_by: String,
    /// Settings of its ingest as JSON, the same text for the same settings.
    pub ingest: String,
    /// Worker that its ingest asks for.
    pub requirements: Requirements,
}

/// A change of what people state about a capture.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct CaptureChange {
    /// Changes of display name, note and tags.
    pub labels: LabelChange,
    /// New name of who recorded it.
    pub recorded_by: Option<String>,
}

impl From<LabelChange> for CaptureChange {
    fn from(labels: LabelChange) -> Self {
        Self { labels, ..Self::default() }
    }
}

/// A capture to be stored.
#[derive(Debug)]
pub struct NewCapture {
    /// What the uploader states about it.
    pub facts: CaptureFacts,
    /// Idempotency key, if given.
    pub request_id: Option<String>,
    /// The archive.
    pub content: Staged,
    /// The uploader.
    pub creator: Creator,
    /// W3C traceparent of the call.
    pub trace_parent: Option<String>,
}

/// The captures of a store.
#[derive(Clone, Copy, Debug)]
pub struct Captures<'a> {
    pub(crate) store: &'a Store,
}

row! {
    struct Row {
        id: String,
        display_name: String,
        created_at: i64,
        size_bytes: i64,
        digest: String,
        note: String,
        tags: String,
        first_name: Option<String>,
        owner: String,
        recorded_by: String,
        trashed_at: Option<i64>,
        purge_at: Option<i64>,
    }
}

impl Row {
    /// The name that it was created with.
    fn first_name(&self) -> &str {
        self.first_name.as_ref().unwrap_or(&self.display_name)
    }

    /// The capture, if the request that made it is this one.
    fn repeated(
        self,
        request: RequestId<'_>,
        display_name: &str,
        digest: Digest,
    ) -> Result<Capture> {
        let same_name = self.first_name() == display_name;
        let before = Capture::try_from(self)?;
        request.require_same(before.digest == digest && same_name, before.id)?;
        Ok(before)
    }
}

impl TryFrom<Row> for Capture {
    type Error = Error;
    fn try_from(row: Row) -> Result<Self> {
        let corrupt = |fault: &str| Error::CorruptRow {
            name: format!("captures/{}", row.id),
            fault: fault.to_owned(),
        };
        let id: CaptureId = Uuid::try_parse(&row.id).map_err(|_| corrupt("id"))?.into();
        trash::refuse(id, row.trashed_at, row.purge_at)?;
        Ok(Self {
            id,
            created: from_micros(row.created_at),
            size_bytes: row.size_bytes.max(0) as u64,
            digest: Digest::from_hex(&row.digest).map_err(|_| corrupt("digest"))?,
            labels: Labels::of_row(row.display_name, row.note, &row.tags),
            owner: row.owner,
            recorded_by: row.recorded_by,
        })
    }
}

/// Returns a capture within a transaction.
pub(crate) async fn fetch(tx: &mut Transaction, id: CaptureId) -> Result<Capture> {
    let row: Option<Row> = query("select * from captures where id = $1")
        .bind(id.uuid().to_string())
        .fetch_optional(tx)
        .await?;
    row.ok_or_else(|| Error::NotFound { name: id.to_string() })?.try_into()
}

impl Captures<'_> {
    /// True if there is a capture that was made under a request id.
    ///
    /// # Errors
    /// Database errors.
    pub async fn has_requested(&self, owner: &str, request_id: &str) -> Result<bool> {
        let request = RequestId { owner, id: request_id };
        let row: Option<Row> =
            request.find(self.store.inner.database.read(), "*", "captures").await?;
        Ok(row.is_some())
    }

    /// The capture that the same request made before, by the digest of its content. Nothing else is
    /// made.
    ///
    /// # Errors
    /// [`Error::RequestIdTaken`] if that has other content or another name,
    /// [`Error::DeletedSince`].
    pub async fn repeated(
        &self,
        owner: &str,
        request_id: &str,
        name: &str,
        digest: Digest,
    ) -> Result<Capture> {
        let request = RequestId { owner, id: request_id };
        let row: Option<Row> =
            request.find(self.store.inner.database.read(), "*", "captures").await?;
        match row {
            Some(row) => row.repeated(request, name, digest),
            None => Err(self.store.vanished(Kind::Captures, request).await),
        }
    }

    /// Stores a capture and queues its ingest. The same request id with the same content and name
    /// returns the capture created before.
    ///
    /// # Errors
    /// [`Error::RequestIdTaken`], [`Error::DeletedSince`], [`Error::QuotaJobs`],
    /// [`Error::QuotaBytes`], [`Error::DiskFull`], [`Error::TooManyRequirements`], database and file
    /// errors.
    pub async fn create(&self, new: NewCapture) -> Result<Capture> {
        self.store.admit()?;
        let NewCapture { facts, request_id, mut content, creator, trace_parent } = new;
        let requirements = facts.requirements.to_text()?;
        let (digest, size_bytes) = (content.digest(), content.size_bytes());
        let (upload, reservation) = (content.upload(), content.take_reservation());
        let guard = self.store.publish(content).await?;
        let mut tx = self.store.inner.database.write().await?;
        let request = RequestId::of(&creator.owner, request_id.as_deref());
        if let Some(request) = request
            && let Some(row) = request.find::<Row>(&mut tx, "*", "captures").await?
        {
            match row.repeated(request, &facts.display_name, digest) {
                Ok(before) => {
                    if let Some(upload) = upload {
                        uploads::stored(&mut tx, upload, before.id).await?;
                        tx.commit().await?;
                    }
                    return Ok(before);
                }
                Err(error) => {
                    drop((tx, guard));
                    self.store.release(&digest.to_hex()).await?;
                    return Err(error);
                }
            }
        }
        let held = reservation.as_ref().map(Reservation::held);
        let held = held.or(upload.map(|upload| upload.uuid().to_string()));
        let more = More { jobs: 1, bytes: size_bytes, held };
        let admitted = async {
            deleted_requests::refuse(&mut tx, Kind::Captures, request, upload).await?;
            quotas::require(&mut tx, &creator, more).await?;
            jobs::admit_ingest(&mut tx, &requirements).await
        }
        .await;
        if let Err(error) = admitted {
            drop((tx, guard));
            self.store.release(&digest.to_hex()).await?;
            return Err(error);
        }
        let id = CaptureId::generate();
        let request_id = request_ids::text_in(request, &mut tx, "captures").await?;
        let row: Row = query(
            "insert into captures (id, display_name, created_at, size_bytes, digest, request_id,
                 name_key, search_text, owner, recorded_by)
             values ($1, $2, $3, $4, $5, $6, $7, $8, $9, $10) returning *",
        )
        .bind(id.uuid().to_string())
        .bind(&facts.display_name)
        .bind(self.store.now_micros())
        .bind(i64::try_from(size_bytes).unwrap_or(i64::MAX))
        .bind(digest.to_hex().as_str())
        .bind(request_id)
        .bind(labels::name_key(&facts.display_name))
        .bind(labels::search_text(&facts.display_name, ""))
        .bind(&creator.owner)
        .bind(&facts.recorded_by)
        .fetch_one(&mut tx)
        .await?;
        if let Some(upload) = upload {
            uploads::stored(&mut tx, upload, id).await?;
        }
        let asked = JobOrigin {
            owner: &creator.owner,
            trace_parent: trace_parent.as_deref(),
            requirements: &requirements,
            max_running: creator.quotas.running_jobs,
        };
        let now = self.store.now_micros();
        let ingest = jobs::enqueue(&mut tx, &row.id, &facts.ingest, asked, now).await?;
        if let Some(reservation) = &reservation {
            reservation.settle(&mut tx).await?;
        }
        self.store.pass(Failpoint::BeforeCommit)?;
        tx.commit().await?;
        drop(guard);
        if let Some(reservation) = reservation {
            reservation.settled();
        }
        self.store.jobs().changed(&ingest);
        self.store.pass(Failpoint::AfterCommit)?;
        row.try_into()
    }

    /// Returns a capture.
    ///
    /// # Errors
    /// [`Error::NotFound`].
    pub async fn get(&self, id: CaptureId) -> Result<Capture> {
        let row: Option<Row> = query("select * from captures where id = $1")
            .bind(id.uuid().to_string())
            .fetch_optional(self.store.inner.database.read())
            .await?;
        row.ok_or_else(|| Error::NotFound { name: id.to_string() })?.try_into()
    }

    /// Refuses what there is not, or what is in the trash.
    pub(crate) async fn require(&self, id: CaptureId) -> Result<()> {
        self.get(id).await.map(drop)
    }

    /// Returns a capture with its ingest, report and supplements.
    ///
    /// # Errors
    /// [`Error::NotFound`].
    pub async fn overview(&self, id: CaptureId) -> Result<Overview> {
        let capture = self.get(id).await?;
        // In this order: an ingest that has ended has its report.
        let ingest = self.store.jobs().ingest_of(id).await?;
        let report = self.report(id).await?;
        let supplements = self.supplements(id).await?;
        let has_masks = self.masks_digest(id).await?.is_some();
        Ok(Overview { capture, ingest, report, supplements, has_masks })
    }

    /// A page of captures with their ingests, reports and supplements.
    ///
    /// # Errors
    /// [`Error::InvalidPageToken`].
    pub async fn overviews(&self, query: &ListQuery) -> Result<Page<Overview>> {
        let Page { items, next_token, total } = self.list(query).await?;
        let key = |capture: &Capture| capture.id.uuid().to_string();
        let keys: Vec<String> = items.iter().map(key).collect();
        let ingests = self.store.jobs().ingests_of(&keys).await?;
        let mut ingests: HashMap<CaptureId, Job> =
            ingests.into_iter().map(|job| (job.capture, job)).collect();
        let mut reports: HashMap<String, Report> =
            self.reports_of(&keys).await?.into_iter().collect();
        let with_masks = self.with_masks(&keys).await?;
        let mut supplements: HashMap<String, Vec<Supplement>> = HashMap::new();
        for (capture, supplement) in self.supplements_of(&keys).await? {
            supplements.entry(capture).or_default().push(supplement);
        }
        let items = items.into_iter().filter_map(|capture| {
            let key = key(&capture);
            let report = reports.remove(&key);
            let supplements = supplements.remove(&key).unwrap_or_default();
            let has_masks = with_masks.contains(&key);
            // One without an ingest was deleted in this moment.
            let ingest = ingests.remove(&capture.id)?;
            Some(Overview { capture, ingest, report, supplements, has_masks })
        });
        Ok(Page { items: items.collect(), next_token, total })
    }

    /// A page of captures.
    ///
    /// # Errors
    /// [`Error::InvalidPageToken`].
    pub async fn list(&self, query: &ListQuery) -> Result<Page<Capture>> {
        let rows: Vec<Row> = query
            .select(Collection::Captures)?
            .build()
            .fetch_all(self.store.inner.database.read())
            .await?;
        let items = rows.into_iter().map(Capture::try_from).collect::<Result<_>>()?;
        let listing = query.listing(Collection::Captures);
        let page = Page::cut(items, &query.page, &listing, |c: &Capture| {
            (c.id.uuid(), query.key(&labels::name_key(&c.labels.display_name), 0.0))
        });
        Ok(page.of(query.total(self.store, Collection::Captures).await?))
    }

    /// Changes what people state about a capture.
    ///
    /// # Errors
    /// [`Error::NotFound`], [`Error::TooManyTags`].
    pub async fn update(&self, id: CaptureId, change: &CaptureChange) -> Result<Capture> {
        let key = id.uuid().to_string();
        let mut tx = self.store.inner.database.write().await?;
        let before = fetch(&mut tx, id).await?.labels;
        labels::change(&mut tx, Collection::Captures, &key, &before, &change.labels).await?;
        if let Some(recorded_by) = &change.recorded_by {
            let update = "update captures set recorded_by = $2 where id = $1";
            query(update).bind(&key).bind(recorded_by).execute(&mut tx).await?;
        }
        let changed = fetch(&mut tx, id).await?;
        tx.commit().await?;
        Ok(changed)
    }

    /// The archive of a capture.
    ///
    /// # Errors
    /// [`Error::NotFound`], [`Error::ContentLost`], [`Error::ContentDamaged`].
    pub async fn content(&self, id: CaptureId) -> Result<(Capture, Content)> {
        let capture = self.get(id).await?;
        let content = self
            .store
            .blobs()
            .read(&capture.digest, Some(capture.size_bytes), &id.to_string())
            .await?;
        Ok((capture, content))
    }

    /// Deletes a capture for good, also one in the trash, with its ingest, what ingests made of it,
    /// and its supplements. Its twins and ended fits stay. Its request id makes no other for a day.
    ///
    /// # Errors
    /// [`Error::NotFound`]; [`Error::CaptureInUse`] while fits of it are queued or running.
    pub async fn delete(&self, id: CaptureId) -> Result<()> {
        self.remove(id, Remove::Any).await
    }

    /// Deletes a capture for good if it is one of these.
    pub(crate) async fn remove(&self, id: CaptureId, which: Remove) -> Result<()> {
        let key = id.uuid().to_string();
        let mut tx = self.store.inner.database.write().await?;
        let fits = jobs::fits_under_way(&mut tx, &key).await?;
        if fits > 0 {
            return Err(Error::CaptureInUse { name: id.to_string(), fits });
        }
        let deleted: Option<(String, Option<String>, String)> = query(
            "delete from captures where id = $1 and ($2 or purge_at <= $3)
             returning digest, request_id, owner",
        )
        .bind(&key)
        .bind(which.is_any())
        .bind(which.until())
        .fetch_optional(&mut tx)
        .await?;
        let (digest, request_id, owner) =
            deleted.ok_or_else(|| Error::NotFound { name: id.to_string() })?;
        let request = request_id.as_deref().map(|stored| RequestId::of_row(stored, &owner));
        self.store.keep_request_id(&mut tx, Kind::Captures, request, &id.to_string()).await?;
        labels::forget(&mut tx, Collection::Captures, &key).await?;
        let mut obsolete = vec![digest];
        // Its worker learns that the job is gone, and stops.
        let ingest = jobs::dequeue(&mut tx, &key).await?;
        obsolete.extend(ingest.iter().filter_map(|(_, checkpoint)| checkpoint.clone()));
        obsolete.extend(observations::forget(&mut tx, &key).await?);
        obsolete.extend(supplements::forget(&mut tx, &key).await?);
        self.store.pass(Failpoint::BeforeCommit)?;
        tx.commit().await?;
        if let Some((ingest, _)) = ingest {
            let _ = self.store.inner.changes.send(ingest);
        }
        self.store.pass(Failpoint::BeforeRelease)?;
        for digest in obsolete {
            self.store.release(&digest).await?;
        }
        Ok(())
    }

    /// Queues the ingests of captures that have none: they are from before ingests existed.
    pub(crate) async fn ingest_old(&self) -> Result<()> {
        let mut tx = self.store.inner.database.write().await?;
        let old: Vec<String> = query_scalar(
            "select id from captures where not exists (
                 select 1 from jobs where kind = 'ingest' and jobs.capture = captures.id)",
        )
        .fetch_all(&mut tx)
        .await?;
        for capture in &old {
            jobs::enqueue(&mut tx, capture, "{}", JobOrigin::default(), self.store.now_micros())
                .await?;
        }
        tx.commit().await?;
        if !old.is_empty() {
            tracing::info!(captures = old.len(), "ingests of captures from before queued");
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests;
