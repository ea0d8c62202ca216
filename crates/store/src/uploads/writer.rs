//! The one writer of an upload: appends, acknowledges, ends.

use std::time::Duration;

use bytes::Bytes;

use super::{
    ResumableUpload, UploadBounds, UploadState, WriteLease, file, file::FileSink, kept_room, parts,
    parts::PartSink, row::Row,
};
use crate::{
    Creator, Digest, Error, Quotas, Result, Staged, Store,
    blobs::{At, Place, partial_objects},
    keys::quotas::{self, reservation::with_step},
    sql::{Transaction, query},
};

/// Exclusive access to an upload. Bytes count once they are committed; others are cut off, at the
/// latest by the next writer.
#[derive(Debug)]
pub struct UploadWriter {
    store: Store,
    held: WriteLease,
    upload: ResumableUpload,
    sink: Sink,
    /// Bytes written or buffered since the last commit.
    pending: u64,
    /// Bounds of the key that is used.
    quotas: Quotas,
}

/// The place that the bytes go to.
#[derive(Debug)]
enum Sink {
    File(FileSink),
    Parts(PartSink),
}

impl UploadWriter {
    pub(super) fn new(store: Store, held: WriteLease, upload: ResumableUpload) -> Self {
        let sink = match store.blobs().place() {
            Place::Folder(folder) => Sink::File(FileSink::new(folder.clone())),
            Place::Bucket(bucket) => Sink::Parts(PartSink::new(bucket.clone())),
        };
        Self { store, held, upload, sink, pending: 0, quotas: Quotas::default() }
    }

    /// Lets the upload grow only within the bounds of a key on its owner.
    pub fn bind(&mut self, quotas: Quotas) {
        self.quotas = quotas;
    }

    /// The owner of the upload, with the bounds of the key that is used.
    pub fn creator(&self) -> Creator {
        Creator { owner: self.upload.owner.clone(), quotas: self.quotas }
    }

    /// The upload in its current state.
    pub fn upload(&self) -> &ResumableUpload {
        &self.upload
    }

    /// Bytes that have been written and not committed.
    pub fn pending(&self) -> u64 {
        self.pending
    }

    /// Waits until another writer wants the upload: commit and drop this one then.
    pub fn wanted(&self) -> impl Future<Output = ()> + Send + use<> {
        self.held.wanted()
    }

    /// Sets the size of the whole, once.
    ///
    /// # Errors
    /// [`Error::UploadLength`] if it contradicts the known size; [`Error::UploadsFull`];
    /// [`Error::QuotaBytes`]; [`Error::UploadLocked`] if another server has taken the upload.
    pub async fn set_length(&mut self, length_bytes: u64, bounds: UploadBounds) -> Result<()> {
        let known = self.upload.length_bytes;
        if known == Some(length_bytes) {
            return Ok(());
        }
        if known.is_some() || length_bytes < self.upload.offset_bytes {
            let (known, offset) = (known, self.upload.offset_bytes);
            return Err(Error::UploadLength { given: length_bytes, known, offset });
        }
        let mut tx = self.begin().await?;
        bounds.room(&mut tx, Some(self.upload.id), length_bytes).await?;
        if length_bytes > self.counted() {
            let bytes = length_bytes..=length_bytes;
            quotas::grant(&mut tx, &self.creator(), Some(&self.key()), bytes).await?;
        }
        query("update uploads set length_bytes = $2 where id = $1")
            .bind(self.key())
            .bind(i64::try_from(length_bytes).unwrap_or(i64::MAX))
            .execute(&mut tx)
            .await?;
        tx.commit().await?;
        self.upload.length_bytes = Some(length_bytes);
        Ok(())
    }

    /// Number of bytes that may still be appended: the missing ones, or, while the size is unknown,
    /// the space up to `limit`. To be asked again as bytes arrive, since the space reserved for an
    /// upload grows with them.
    ///
    /// # Errors
    /// If the database fails; [`Error::UploadsFull`].
    pub async fn room(&self, limit: u64, bounds: UploadBounds) -> Result<u64> {
        let ResumableUpload { id, offset_bytes, length_bytes, .. } = self.upload;
        let mut tx = self.store.inner.database.write().await?;
        let needed = kept_room(offset_bytes, length_bytes);
        let room = bounds.room(&mut tx, Some(id), needed).await?;
        let end = length_bytes.unwrap_or(room.min(limit));
        Ok(end.saturating_sub(offset_bytes))
    }

    /// Sets bytes aside in the quota of the owner for an upload of unknown size, `more` than have
    /// arrived. One of a known size has all of them.
    ///
    /// # Errors
    /// [`Error::QuotaBytes`]; [`Error::UploadLocked`] if another server has taken the upload.
    pub async fn reserve(&mut self, more: u64) -> Result<()> {
        let total = self.upload.offset_bytes.saturating_add(more);
        self.set_aside(total..=total).await
    }

    /// Gives back the bytes that were set aside and did not arrive. To be called at the end of a
    /// request, after what has arrived is committed or discarded; without that they are given back
    /// with the next request, or the upload.
    ///
    /// # Errors
    /// Database errors, [`Error::UploadLocked`].
    pub async fn give_back(&mut self) -> Result<()> {
        let upload = &self.upload;
        if upload.length_bytes.is_some() || upload.reserved_bytes <= upload.offset_bytes {
            return Ok(());
        }
        self.write_reserved(self.begin().await?, 0).await
    }

    /// Bytes that an upload of unknown size counts for.
    fn counted(&self) -> u64 {
        self.upload.reserved_bytes.max(self.upload.offset_bytes)
    }

    async fn set_aside(&mut self, bytes: std::ops::RangeInclusive<u64>) -> Result<()> {
        if self.upload.length_bytes.is_some() || *bytes.start() <= self.counted() {
            return Ok(());
        }
        let mut tx = self.begin().await?;
        let granted = quotas::grant(&mut tx, &self.creator(), Some(&self.key()), bytes).await?;
        self.write_reserved(tx, granted).await
    }

    async fn write_reserved(&mut self, mut tx: Transaction, bytes: u64) -> Result<()> {
        query("update uploads set reserved_bytes = $2 where id = $1")
            .bind(self.key())
            .bind(i64::try_from(bytes).unwrap_or(i64::MAX))
            .execute(&mut tx)
            .await?;
        tx.commit().await?;
        self.upload.reserved_bytes = bytes;
        Ok(())
    }

    /// Appends bytes; the caller has checked that there is room among all uploads. After an error,
    /// call [`UploadWriter::discard`], except after [`Error::QuotaBytes`]: then these bytes were not
    /// appended, and those before them are sound.
    ///
    /// # Errors
    /// [`Error::QuotaBytes`] before anything is written; [`Error::DiskFull`], file errors;
    /// [`Error::ObjectsUnavailable`]; [`Error::UploadLocked`] if another server has taken the
    /// upload.
    pub async fn write(&mut self, chunk: &Bytes) -> Result<()> {
        self.require_held()?;
        let pending = self.pending + chunk.len() as u64;
        let total = self.upload.offset_bytes.saturating_add(pending);
        self.set_aside(total..=with_step(total)).await?;
        self.pending = pending;
        match &mut self.sink {
            Sink::File(file) => file.write(&self.store, &self.upload, chunk).await,
            Sink::Parts(parts) => parts.write(&self.store, &self.upload, chunk).await,
        }
    }

    /// Makes the written bytes durable: syncs them, then moves the offset. The upload is kept for
    /// `keep` from now on.
    ///
    /// # Errors
    /// File and database errors, [`Error::ObjectsUnavailable`], [`Error::UploadLocked`]: then none
    /// of these bytes count.
    pub async fn commit(&mut self, keep: Duration) -> Result<()> {
        if self.pending == 0 {
            return Ok(());
        }
        self.require_held()?;
        let tail = match &mut self.sink {
            Sink::File(file) => {
                file.sync(&self.store, &self.upload).await?;
                None
            }
            Sink::Parts(parts) => Some(parts.sync(&self.store, &self.upload).await?),
        };
        let offset = self.upload.offset_bytes + self.pending;
        let mut tx = self.begin().await?;
        if let (Sink::Parts(parts), Some(tail)) = (&self.sink, &tail) {
            parts.record(&mut tx, &self.upload, tail).await?;
        }
        let row: Row = query(
            "update uploads set offset_bytes = $2, expires_at = $3 where id = $1 returning *",
        )
        .bind(self.key())
        .bind(i64::try_from(offset).unwrap_or(i64::MAX))
        .bind(self.store.expiry_micros(keep))
        .fetch_one(&mut tx)
        .await?;
        tx.commit().await?;
        self.pending = 0;
        self.upload = row.try_into()?;
        if let (Sink::Parts(parts), Some(tail)) = (&mut self.sink, tail) {
            parts.recorded(tail).await;
        }
        Ok(())
    }

    /// Discards the bytes written since the last commit.
    ///
    /// # Errors
    /// File errors; the next writer tries again.
    pub async fn discard(&mut self) -> Result<()> {
        self.pending = 0;
        match &mut self.sink {
            Sink::File(file) => file.discard(&self.upload).await,
            Sink::Parts(parts) => {
                parts.discard();
                Ok(())
            }
        }
    }

    /// The complete content, for [`crate::Captures::create`], which ends the upload. A file is
    /// hashed in a separate thread unless that was done before a crash; the hashes of parts are
    /// known.
    ///
    /// # Errors
    /// [`Error::DigestMismatch`], [`Error::ContentLost`], [`Error::ObjectsUnavailable`],
    /// [`Error::ContentBusy`], [`Error::UploadLocked`]; file and database errors.
    pub async fn stage(&mut self) -> Result<Staged> {
        let (digest, at) = match &self.sink {
            Sink::File(_) => self.stage_file().await?,
            Sink::Parts(_) => self.stage_parts().await?,
        };
        let (id, size_bytes) = (self.upload.id, self.upload.offset_bytes);
        Ok(Staged::of_upload(self.store.blobs().clone(), id, at, digest, size_bytes))
    }

    async fn stage_file(&mut self) -> Result<(Digest, At)> {
        let path = match &mut self.sink {
            Sink::File(file) => file.close(&self.upload).await?,
            Sink::Parts(_) => None,
        };
        // Renamed before a crash, if it is not there.
        let at = path.as_ref().map_or(At::Published, |_| At::File(partial_objects(self.upload.id)));
        match (self.upload.digest, path) {
            (Some(digest), _) => Ok((digest, at)),
            (None, Some(path)) => {
                let (digest, size_bytes) = file::hash(path).await?;
                if size_bytes != self.upload.offset_bytes {
                    return Err(self.upload.lost());
                }
                self.refer(digest).await?;
                Ok((digest, at))
            }
            (None, None) => Err(self.upload.lost()),
        }
    }

    async fn stage_parts(&mut self) -> Result<(Digest, At)> {
        let Sink::Parts(parts) = &mut self.sink else { return Err(self.upload.lost()) };
        let digest = match self.upload.digest {
            Some(digest) => digest,
            None => {
                let digest = parts.hash(&self.store, &self.upload).await?;
                self.refer(digest).await?;
                digest
            }
        };
        // The row keeps it from now on: what deletes it began before, and ends.
        self.store.await_deletions(&[digest.to_hex().to_string()]).await?;
        let Sink::Parts(parts) = &mut self.sink else { return Err(self.upload.lost()) };
        Ok((digest, parts.join(&self.store, &self.upload, &digest).await?))
    }

    /// Checks the digest, and makes the row refer to it, which keeps its blob.
    async fn refer(&mut self, digest: Digest) -> Result<()> {
        if let Some(given) = self.upload.expected_digest.filter(|given| *given != digest) {
            return Err(Error::DigestMismatch { given, actual: digest });
        }
        let mut tx = self.begin().await?;
        query("update uploads set digest = $2 where id = $1")
            .bind(self.key())
            .bind(digest.to_hex().as_str())
            .execute(&mut tx)
            .await?;
        tx.commit().await?;
        self.upload.digest = Some(digest);
        Ok(())
    }

    /// Ends the upload without a capture and frees its storage. The reason is remembered for
    /// `keep`. A capture that was made of it stays.
    ///
    /// # Errors
    /// Database and file errors.
    pub async fn end(self, why: &str, keep: Duration) -> Result<()> {
        let mut tx = self.begin().await?;
        query(
            "update uploads set state = 'gone', why = $2, digest = null, request_id = null,
                metadata = '', expires_at = $3 where id = $1",
        )
        .bind(self.key())
        .bind(why)
        .bind(self.store.expiry_micros(keep))
        .execute(&mut tx)
        .await?;
        tx.commit().await?;
        self.store.remove_arrived(&self.upload).await?;
        match self.upload.digest {
            Some(digest) => self.store.release(&digest.to_hex()).await,
            None => Ok(()),
        }
    }

    /// True if its capture has been made.
    pub fn is_stored(&self) -> bool {
        matches!(self.upload.state, UploadState::Stored(_))
    }

    /// A transaction in which the upload is this writer's.
    async fn begin(&self) -> Result<Transaction> {
        self.require_held()?;
        let mut tx = self.store.inner.database.write().await?;
        let mine = "select lease_epoch from uploads where id = $1";
        let epoch: Option<(i64,)> = query(mine).bind(self.key()).fetch_optional(&mut tx).await?;
        match epoch {
            Some((epoch,)) if epoch == self.upload.lease_epoch => Ok(tx),
            _ => Err(Error::UploadLocked { name: self.upload.id.to_string() }),
        }
    }

    fn require_held(&self) -> Result<()> {
        if self.held.is_lost() {
            return Err(Error::UploadLocked { name: self.upload.id.to_string() });
        }
        Ok(())
    }

    fn key(&self) -> String {
        self.upload.id.uuid().to_string()
    }
}

impl Store {
    /// Removes the received bytes of an upload.
    pub(crate) async fn remove_arrived(&self, upload: &ResumableUpload) -> Result<()> {
        match self.blobs().place() {
            Place::Folder(folder) => folder.remove_partial(upload.id).await?,
            Place::Bucket(bucket) => parts::remove(bucket, self, upload).await?,
        }
        let mut tx = self.inner.database.write().await?;
        let id = upload.id.uuid().to_string();
        for statement in [
            "delete from upload_parts where upload = $1",
            "update uploads set multipart = null, tail = null where id = $1",
        ] {
            query(statement).bind(&id).execute(&mut tx).await?;
        }
        tx.commit().await
    }
}
