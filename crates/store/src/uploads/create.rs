//! Creating an upload, or finding the one created before under the same request id.

use std::time::Duration;

use bendtwin_core::ids::UploadId;

use super::{IN_USE, ResumableUpload, UploadState, Uploads, row::Row};
use crate::{
    Creator, Digest, Error, Result,
    keys::quotas::{self, More},
    owners::deleted_requests,
    owners::request_ids::{self, RequestId},
    sql::{Transaction, query, query_scalar},
};

/// An upload to be created.
#[derive(Clone, Debug)]
pub struct NewResumableUpload {
    /// Display name of the capture.
    pub display_name: String,
    /// Idempotency key for the upload and its capture, if given.
    pub request_id: Option<String>,
    /// BLAKE3 of the whole, checked at the end, if given.
    pub expected_digest: Option<Digest>,
    /// Metadata of the client, verbatim.
    pub metadata: String,
    /// Size of the whole, if known.
    pub length_bytes: Option<u64>,
    /// True if the request that creates it brings content.
    pub has_content: bool,
    /// Time for which it is kept without a first byte.
    pub keep: Duration,
    /// Time for which it is remembered if its capture exists.
    pub remember: Duration,
    /// The one who begins it.
    pub creator: Creator,
}

/// Bounds on all unfinished uploads together.
#[derive(Clone, Copy, Debug)]
pub struct UploadBounds {
    /// Number of uploads.
    pub count: u64,
    /// Disk space reserved for them together ([`UploadUse::bytes`](super::UploadUse)) [bytes].
    pub bytes: u64,
}

impl UploadBounds {
    /// Disk space for an upload of at least `length_bytes` beside all others [bytes].
    pub(super) async fn room(
        &self,
        tx: &mut Transaction,
        except: Option<UploadId>,
        length_bytes: u64,
    ) -> Result<u64> {
        let except = except.map(|id| id.uuid().to_string()).unwrap_or_default();
        let (count, bytes): (i64, i64) = query(IN_USE).bind(except).fetch_one(&mut *tx).await?;
        let (count, bytes) = (count.max(0) as u64, bytes.max(0) as u64);
        let room = self.bytes.saturating_sub(bytes);
        if count >= self.count || length_bytes > room {
            return Err(Error::UploadsFull { count, bytes });
        }
        Ok(room)
    }
}

impl Uploads<'_> {
    /// Creates an upload. The same request id with the same length and metadata returns the upload
    /// created before, at any progress. If a capture of the declared digest exists under that
    /// request id, the upload is complete immediately. Beyond the limit on uploads, the oldest
    /// upload without any content is dropped.
    ///
    /// If the capture of that request id has been deleted, the upload starts again. A request with
    /// content does not start it: it may be a late attempt at one that has been answered.
    ///
    /// # Errors
    /// [`Error::RequestIdTaken`]; [`Error::DeletedSince`]; [`Error::UploadsFull`] beyond `bounds`;
    /// [`Error::QuotaJobs`], [`Error::QuotaBytes`]; [`Error::DiskFull`].
    pub async fn create(
        &self,
        new: NewResumableUpload,
        bounds: UploadBounds,
    ) -> Result<ResumableUpload> {
        self.store.admit()?;
        loop {
            match self.try_create(&new, bounds).await {
                Err(Error::UploadsFull { count, bytes }) if count >= bounds.count => {
                    if !self.end_an_empty_one(new.keep).await? {
                        return Err(Error::UploadsFull { count, bytes });
                    }
                }
                created => return created,
            }
        }
    }

    /// Ends the oldest upload that is empty and has no writer. Returns true if there was one.
    async fn end_an_empty_one(&self, remember: Duration) -> Result<bool> {
        let empty = "select id from uploads where state = 'receiving' and offset_bytes = 0
                     order by created_at, id";
        for id in self.ids(empty).await? {
            let Some(writer) = self.claim_idle(id).await? else { continue };
            let upload = writer.upload();
            if upload.state == UploadState::Receiving && upload.offset_bytes == 0 {
                let why = "nothing of it had come when others needed its place: begin a new one";
                writer.end(why, remember).await?;
                return Ok(true);
            }
        }
        Ok(false)
    }

    async fn try_create(
        &self,
        new: &NewResumableUpload,
        bounds: UploadBounds,
    ) -> Result<ResumableUpload> {
        let mut tx = self.store.inner.database.write().await?;
        let mut capture = None;
        let request = RequestId::of(&new.creator.owner, new.request_id.as_deref());
        if let Some(request) = request {
            if let Some(before) = begun_before(&mut tx, new, request).await? {
                tx.commit().await?;
                return Ok(before);
            }
            capture = made_before(&mut tx, new, request).await?;
            if new.has_content && capture.is_none() {
                let kind = deleted_requests::Kind::Captures;
                deleted_requests::refuse(&mut tx, kind, Some(request), None).await?;
            }
        }
        let length = match &capture {
            Some((_, size)) => Some(*size),
            None => {
                bounds.room(&mut tx, None, new.length_bytes.unwrap_or(0)).await?;
                let bytes = new.length_bytes.unwrap_or(1);
                quotas::require(&mut tx, &new.creator, More { jobs: 1, bytes, held: None }).await?;
                new.length_bytes.map(|n| i64::try_from(n).unwrap_or(i64::MAX))
            }
        };
        let id = UploadId::generate().uuid().to_string();
        if let (Some(request), None) = (request, &capture) {
            deleted_requests::begin_again(&mut tx, request, &id).await?;
        }
        let request_id = request_ids::text_in(request, &mut tx, "uploads").await?;
        let keep = if capture.is_some() { new.remember } else { new.keep };
        let row: Row = query(
            "insert into uploads (id, state, display_name, request_id, expected_digest, metadata,
                length_bytes, offset_bytes, capture, created_at, expires_at, owner)
             values ($1, $2, $3, $4, $5, $6, $7, $8, $9, $10, $11, $12) returning *",
        )
        .bind(id)
        .bind(if capture.is_some() { "stored" } else { "receiving" })
        .bind(&new.display_name)
        .bind(request_id)
        .bind(new.expected_digest.map(|d| d.to_hex().to_string()))
        .bind(&new.metadata)
        .bind(length)
        .bind(capture.as_ref().map_or(0, |(_, size)| *size))
        .bind(capture.map(|(id, _)| id))
        .bind(self.store.now_micros())
        .bind(self.store.expiry_micros(keep))
        .bind(&new.creator.owner)
        .fetch_one(&mut tx)
        .await?;
        tx.commit().await?;
        row.try_into()
    }
}

/// The upload created under the same request id, unless its capture has been deleted since.
async fn begun_before(
    tx: &mut Transaction,
    new: &NewResumableUpload,
    request: RequestId<'_>,
) -> Result<Option<ResumableUpload>> {
    let row: Option<Row> = request.find(&mut *tx, "*", "uploads").await?;
    let Some(row) = row else { return Ok(None) };
    let before = ResumableUpload::try_from(row)?;
    if let UploadState::Stored(capture) = before.state {
        let there: bool = query_scalar(
            "select exists (select 1 from captures where id = $1 and trashed_at is null)",
        )
        .bind(capture.uuid().to_string())
        .fetch_one(&mut *tx)
        .await?;
        if !there {
            query("update uploads set request_id = null where id = $1")
                .bind(before.id.uuid().to_string())
                .execute(&mut *tx)
                .await?;
            return Ok(None);
        }
    }
    let same_length = new.length_bytes.is_none() || new.length_bytes == before.length_bytes;
    let same = same_length
        && before.metadata == new.metadata
        && before.display_name == new.display_name
        && before.expected_digest == new.expected_digest;
    if same {
        return Ok(Some(before));
    }
    let (request_id, name) = (request.id.to_owned(), before.id.to_string());
    Err(Error::RequestIdTaken { request_id, name })
}

/// Id and size of the capture that was made under the same request id, if it is known to be the
/// same.
async fn made_before(
    tx: &mut Transaction,
    new: &NewResumableUpload,
    request: RequestId<'_>,
) -> Result<Option<(String, i64)>> {
    let columns = "id, coalesce(first_name, display_name), size_bytes, digest";
    let row: Option<(String, String, i64, String)> = request.find(tx, columns, "captures").await?;
    let Some((id, display_name, size, digest)) = row else { return Ok(None) };
    let given = new.expected_digest.map(|d| d.to_hex().to_string());
    let differs = display_name != new.display_name
        || given.as_ref().is_some_and(|given| *given != digest)
        || new.length_bytes.is_some_and(|n| i64::try_from(n).ok() != Some(size));
    if differs {
        let (request_id, name) = (request.id.to_owned(), format!("captures/{id}"));
        return Err(Error::RequestIdTaken { request_id, name });
    }
    // Without a digest only the content itself could be compared.
    Ok(given.map(|_| (id, size)))
}
