//! Uploads that survive broken connections and failures of client and server.
//!
//! An upload is a row and a file under `blobs/partial/`. Bytes are appended to the file and synced,
//! then the row's offset moves. The row gives the acknowledged bytes; the next writer cuts off
//! anything beyond them. There is one writer at a time ([`UploadWriter`]), among the requests of a
//! server by `seat`, among servers by `lease`. In a bucket the bytes are in `parts` in place of a
//! file.
//!
//! Complete content becomes a blob without being copied:
//!
//! 1. the file is hashed, and the row refers to the digest, which keeps its blob;
//! 2. the file is renamed to the path derived from the digest;
//! 3. one transaction inserts the capture and ends the upload.
//!
//! After a crash, the remaining steps are repeated.

mod create;
mod file;
mod lease;
mod parts;
mod row;
mod seat;
mod tree;
mod writer;

use std::time::{Duration, Instant};

use bendtwin_core::ids::{CaptureId, UploadId};

use uuid::Uuid;

use crate::{
    Error, Page, PageRequest, Result, Store,
    blobs::{PART, Place, partial_objects},
    owners::projects,
    sql::{Builder, Transaction, query, query_scalar},
    store::clock::micros_after,
};
use lease::{WriteLease, locked};
use row::Row;

pub use create::{NewResumableUpload, UploadBounds};
pub use row::{ResumableUpload, UploadState};
pub(crate) use seat::Seats;
pub use writer::UploadWriter;

/// The resumable uploads of a store.
#[derive(Clone, Copy, Debug)]
pub struct Uploads<'a> {
    pub(crate) store: &'a Store,
}

/// Resources held by unfinished uploads.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct UploadUse {
    /// Uploads that are neither stored nor gone.
    pub count: u64,
    /// Disk space reserved for them [bytes]: none for uploads without any bytes; then four times
    /// what has arrived, at least [`FIRST_ROOM`] and at most the declared size.
    pub bytes: u64,
}

impl Uploads<'_> {
    /// Returns an upload in its current state.
    ///
    /// # Errors
    /// [`Error::NotFound`].
    pub async fn get(&self, id: UploadId) -> Result<ResumableUpload> {
        let row: Option<Row> = query("select * from uploads where id = $1")
            .bind(id.uuid().to_string())
            .fetch_optional(self.store.inner.database.read())
            .await?;
        row.ok_or_else(|| Error::NotFound { name: id.to_string() })?.try_into()
    }

    /// Uploads, newest first: those under way, and those that ended and are remembered still. All,
    /// or those of an owner and of owners who share a project with it.
    ///
    /// # Errors
    /// [`Error::InvalidPageToken`].
    pub async fn list(
        &self,
        page: &PageRequest,
        shared_with: Option<&str>,
    ) -> Result<Page<ResumableUpload>> {
        const LISTING: &str = "uploads";
        let mut sql = Builder::new("select u.* from uploads as u where u.id < ");
        sql.push_bind(page.before(LISTING)?);
        if let Some(owner) = shared_with {
            projects::push_shared_with(&mut sql, "u.owner", owner);
        }
        sql.push(" order by u.id desc limit ").push_bind(page.fetch());
        let rows: Vec<Row> = sql.build().fetch_all(self.store.inner.database.read()).await?;
        let items = rows.into_iter().map(ResumableUpload::try_from).collect::<Result<_>>()?;
        Ok(Page::cut(items, page, LISTING, |u: &ResumableUpload| (u.id.uuid(), String::new())))
    }

    /// Claims an upload, to write to it or to end it. Its current writer is asked to save the bytes
    /// that have arrived and to release it.
    ///
    /// # Errors
    /// [`Error::NotFound`], [`Error::UploadGone`]; [`Error::UploadLocked`] if it is not free in
    /// time.
    pub async fn claim(&self, id: UploadId, patience: Duration) -> Result<UploadWriter> {
        // Names that do not exist are not worth a seat.
        self.get(id).await?;
        let began = Instant::now();
        let sitting = self.store.inner.seats.take(id, patience).await;
        let sitting = sitting.ok_or_else(|| locked(id))?;
        let left = patience.saturating_sub(began.elapsed());
        let held = WriteLease::among_servers(self.store, id, sitting, left).await?;
        let held = held.ok_or_else(|| locked(id))?;
        // Read again: it is ours only now.
        let upload = self.get(id).await?;
        if let UploadState::Gone(why) = upload.state {
            return Err(Error::UploadGone { name: id.to_string(), why });
        }
        Ok(UploadWriter::new(self.store.clone(), held, upload))
    }

    /// Claims an upload that has no writer.
    async fn claim_idle(&self, id: UploadId) -> Result<Option<UploadWriter>> {
        let Some(sitting) = self.store.inner.seats.take_idle(id) else { return Ok(None) };
        let held = WriteLease::among_servers(self.store, id, sitting, Duration::ZERO).await?;
        let Some(held) = held else { return Ok(None) };
        let upload = self.get(id).await?;
        Ok(Some(UploadWriter::new(self.store.clone(), held, upload)))
    }

    /// Memory of one that is being written [bytes].
    pub fn buffers(&self) -> u64 {
        match self.store.blobs().place() {
            Place::Folder(_) => file::BUFFER as u64,
            // The bytes after the last part, and what is sent of them.
            Place::Bucket(_) => 2 * PART as u64,
        }
    }

    /// Complete uploads without a capture, interrupted by a crash.
    ///
    /// # Errors
    /// If the database fails.
    pub async fn whole(&self) -> Result<Vec<UploadId>> {
        self.ids("select id from uploads where state = 'receiving' and offset_bytes = length_bytes")
            .await
    }

    /// Resources held by all unfinished uploads.
    ///
    /// # Errors
    /// If the database fails.
    pub async fn in_use(&self) -> Result<UploadUse> {
        let (count, bytes): (i64, i64) =
            query(IN_USE).bind("").fetch_one(self.store.inner.database.read()).await?;
        Ok(UploadUse { count: count.max(0) as u64, bytes: bytes.max(0) as u64 })
    }

    /// Ends expired uploads, unless a writer holds them, and forgets those that ended long ago.
    /// Those that expire now are remembered for `keep`. Bytes that a server which has died set aside
    /// for content in one request are free again. Returns the number of expired uploads.
    ///
    /// # Errors
    /// Database and file errors.
    pub async fn sweep(&self, keep: Duration) -> Result<usize> {
        self.store.sweep_reservations().await?;
        let now = self.store.now_micros();
        let mut tx = self.store.inner.database.write().await?;
        query("delete from uploads where state <> 'receiving' and expires_at < $1")
            .bind(now)
            .execute(&mut tx)
            .await?;
        tx.commit().await?;
        let query =
            format!("select id from uploads where state = 'receiving' and expires_at < {now}");
        let mut given_up = 0;
        for id in self.ids(sqlx::AssertSqlSafe(query)).await? {
            let Some(writer) = self.claim_idle(id).await? else { continue };
            let upload = writer.upload();
            // It may have moved on since the list was made.
            if upload.state == UploadState::Receiving && upload.expires < self.store.now() {
                writer.end("it expired before it was whole: begin a new one", keep).await?;
                given_up += 1;
            }
        }
        Ok(given_up)
    }

    /// Removes what crashes left of uploads that have ended, and ends those whose bytes stayed in a
    /// folder when content moved to a bucket.
    pub(crate) async fn collect_garbage(&self) -> Result<()> {
        if let Place::Bucket(_) = self.store.blobs().place() {
            let mut tx = self.store.inner.database.write().await?;
            query(LEFT_BEHIND).bind(self.store.expiry_micros(REMEMBERED)).execute(&mut tx).await?;
            tx.commit().await?;
        }
        let partials = match self.store.blobs().place() {
            Place::Folder(folder) => folder.partials().await?,
            Place::Bucket(bucket) => bucket.partials().await?,
        };
        for id in partials {
            match self.get(id).await {
                Ok(upload) if upload.state == UploadState::Receiving => {}
                Ok(upload) => self.store.remove_arrived(&upload).await?,
                Err(Error::NotFound { .. }) => match self.store.blobs().place() {
                    Place::Folder(folder) => folder.remove_partial(id).await?,
                    Place::Bucket(bucket) => bucket.delete_below(&partial_objects(id)).await?,
                },
                Err(error) => return Err(error),
            }
        }
        Ok(())
    }

    async fn ids(&self, query: impl sqlx::SqlSafeStr) -> Result<Vec<UploadId>> {
        let ids: Vec<String> =
            query_scalar(query).fetch_all(self.store.inner.database.read()).await?;
        Ok(ids.iter().filter_map(|id| Some(Uuid::try_parse(id).ok()?.into())).collect())
    }
}

/// Disk space reserved for an upload with its first byte, if its declared size is not less [bytes].
pub const FIRST_ROOM: u64 = 64 << 20;

/// Count of uploads under way other than $1, and the disk space reserved for them: [`kept_room`] in
/// SQL. A declared size alone reserves none, or a few requests could take it all.
const IN_USE: &str = "select count(*), cast(coalesce(sum(case
        when offset_bytes = 0 then 0
        when length_bytes is null then offset_bytes
        when length_bytes <= 67108864 or length_bytes <= 4 * offset_bytes then length_bytes
        when 4 * offset_bytes <= 67108864 then 67108864
        else 4 * offset_bytes end), 0) as bigint)
     from uploads where state = 'receiving' and id <> $1";

/// Ends uploads with bytes that are not in the bucket.
const LEFT_BEHIND: &str = "update uploads set state = 'gone', digest = null, request_id = null,
        why = 'the content of the server has moved: begin a new one', expires_at = $1
     where state = 'receiving' and offset_bytes > 0 and tail is null";
/// Time for which these are remembered.
const REMEMBERED: Duration = Duration::from_secs(86_400);

/// Disk space reserved for the rest of an upload, given the bytes that have arrived [bytes].
fn kept_room(offset_bytes: u64, length_bytes: Option<u64>) -> u64 {
    match length_bytes {
        Some(length) => length.min(FIRST_ROOM.max(offset_bytes.saturating_mul(4))),
        None => offset_bytes,
    }
}

/// Ends an upload within the transaction that makes its capture.
pub(crate) async fn stored(tx: &mut Transaction, id: UploadId, capture: CaptureId) -> Result<()> {
    let changed = query(
        "update uploads set state = 'stored', capture = $2, digest = null
         where id = $1 and state = 'receiving'",
    )
    .bind(id.uuid().to_string())
    .bind(capture.uuid().to_string())
    .execute(&mut *tx)
    .await?;
    let forget = "delete from upload_parts where upload = $1";
    query(forget).bind(id.uuid().to_string()).execute(tx).await?;
    // Another server may have ended it meanwhile.
    if changed == 0 { Err(locked(id)) } else { Ok(()) }
}

impl Store {
    fn expiry_micros(&self, keep: Duration) -> i64 {
        micros_after(self.now(), keep)
    }
}

#[cfg(test)]
pub(crate) mod tests;
