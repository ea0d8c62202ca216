//! The one writer of an upload: appends, acknowledges, ends.

use std::{io::ErrorKind, path::PathBuf, time::Duration};

use bytes::{Bytes, BytesMut};
use tokio::{
    fs::File,
    io::{AsyncSeekExt as _, AsyncWriteExt as _, SeekFrom},
};

use super::{ResumableUpload, UploadBounds, UploadState, kept_room, row::Row, seat::Held};
use crate::{Digest, Error, Result, Staged, Store, sql::query};

/// Bytes buffered before they are written to the file.
const BUFFER: usize = 1 << 20;

/// Exclusive access to an upload. Bytes count once they are committed; others are cut off, at the
/// latest by the next writer.
#[derive(Debug)]
pub struct UploadWriter {
    store: Store,
    held: Held,
    upload: ResumableUpload,
    /// Opened by the first write, at the end of the acknowledged bytes.
    file: Option<File>,
    buffer: BytesMut,
    /// Bytes written or buffered since the last commit.
    pending: u64,
}

impl UploadWriter {
    pub(super) fn new(store: Store, held: Held, upload: ResumableUpload) -> Self {
        Self { store, held, upload, file: None, buffer: BytesMut::new(), pending: 0 }
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
    /// [`Error::UploadLength`] if it contradicts the known size; [`Error::UploadsFull`].
    pub async fn set_length(&mut self, length_bytes: u64, bounds: UploadBounds) -> Result<()> {
        let known = self.upload.length_bytes;
        if known == Some(length_bytes) {
            return Ok(());
        }
        if known.is_some() || length_bytes < self.upload.offset_bytes {
            let (known, offset) = (known, self.upload.offset_bytes);
            return Err(Error::UploadLength { given: length_bytes, known, offset });
        }
        let mut tx = self.store.inner.database.write().await?;
        bounds.room(&mut tx, Some(self.upload.id), length_bytes).await?;
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
    /// the room up to `limit`. To be asked again as bytes come, since the room that is kept for an
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

    /// Appends bytes; the caller has checked that there is room. After an error, call
    /// [`UploadWriter::discard`].
    ///
    /// # Errors
    /// [`Error::DiskFull`], file errors.
    pub async fn write(&mut self, chunk: &Bytes) -> Result<()> {
        self.buffer.extend_from_slice(chunk);
        self.pending += chunk.len() as u64;
        if self.buffer.len() >= BUFFER { self.flush().await } else { Ok(()) }
    }

    /// Makes the written bytes durable: syncs them, then moves the offset. The upload is kept for
    /// `keep` from now on.
    ///
    /// # Errors
    /// File and database errors: then none of these bytes count.
    pub async fn commit(&mut self, keep: Duration) -> Result<()> {
        if self.pending == 0 {
            return Ok(());
        }
        self.flush().await?;
        if let Some(file) = &mut self.file {
            file.flush().await?;
            file.sync_data().await?;
        }
        let offset = self.upload.offset_bytes + self.pending;
        let mut tx = self.store.inner.database.write().await?;
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
        Ok(())
    }

    /// Discards the bytes written since the last commit.
    ///
    /// # Errors
    /// File errors; the next writer tries again.
    pub async fn discard(&mut self) -> Result<()> {
        self.pending = 0;
        self.buffer.clear();
        let Some(mut file) = self.file.take() else { return Ok(()) };
        // What the file collected itself may still be on its way: let it arrive, then cut it off.
        file.flush().await.ok();
        file.set_len(self.upload.offset_bytes).await?;
        Ok(())
    }

    /// The complete content, to be given to [`crate::Captures::create`], which ends the upload.
    /// Hashes the file in a thread of its own unless that was done before a crash.
    ///
    /// # Errors
    /// [`Error::DigestMismatch`], [`Error::ContentLost`], file and database errors.
    pub async fn stage(&mut self) -> Result<Staged> {
        let (id, path) = (self.upload.id, self.path());
        self.file = None;
        let there = tokio::fs::try_exists(&path).await?;
        let digest = match self.upload.digest {
            Some(digest) => digest,
            None if there => self.hash(path).await?,
            None => return Err(self.lost()),
        };
        let blobs = self.store.blobs().clone();
        Ok(Staged::from_partial(blobs, id, there, digest, self.upload.offset_bytes))
    }

    async fn hash(&mut self, path: PathBuf) -> Result<Digest> {
        let hashing = tokio::task::spawn_blocking(move || {
            let mut hasher = blake3::Hasher::new();
            hasher.update_reader(std::fs::File::open(path)?)?;
            Ok::<_, std::io::Error>((hasher.count(), hasher.finalize()))
        });
        let (size_bytes, digest) = hashing.await.map_err(std::io::Error::other)??;
        if size_bytes != self.upload.offset_bytes {
            return Err(self.lost());
        }
        if let Some(given) = self.upload.expected_digest.filter(|given| *given != digest) {
            return Err(Error::DigestMismatch { given, actual: digest });
        }
        let mut tx = self.store.inner.database.write().await?;
        query("update uploads set digest = $2 where id = $1")
            .bind(self.key())
            .bind(digest.to_hex().as_str())
            .execute(&mut tx)
            .await?;
        tx.commit().await?;
        self.upload.digest = Some(digest);
        Ok(digest)
    }

    /// Ends the upload without a capture and frees its storage. The reason is remembered for
    /// `keep`. A capture that was made of it stays.
    ///
    /// # Errors
    /// Database and file errors.
    pub async fn end(self, why: &str, keep: Duration) -> Result<()> {
        let mut tx = self.store.inner.database.write().await?;
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
        self.store.blobs().remove_partial(self.upload.id).await?;
        match self.upload.digest {
            Some(digest) => self.store.release(&digest.to_hex()).await,
            None => Ok(()),
        }
    }

    /// True if its capture has been made.
    pub fn is_stored(&self) -> bool {
        matches!(self.upload.state, UploadState::Stored(_))
    }

    async fn flush(&mut self) -> Result<()> {
        self.store.admit()?;
        if self.file.is_none() {
            self.file = Some(self.open().await?);
        }
        if let Some(file) = &mut self.file {
            file.write_all(&self.buffer).await?;
            self.buffer.clear();
        }
        Ok(())
    }

    /// The file, cut off after the acknowledged bytes and positioned there.
    async fn open(&self) -> Result<File> {
        let offset = self.upload.offset_bytes;
        let opened = self.store.blobs().open_partial(self.upload.id, offset == 0).await;
        let mut file = match opened {
            Err(Error::Io(error)) if error.kind() == ErrorKind::NotFound => return Err(self.lost()),
            opened => opened?,
        };
        let length = file.metadata().await?.len();
        if length < offset {
            return Err(self.lost());
        }
        if length > offset {
            file.set_len(offset).await?;
        }
        file.seek(SeekFrom::Start(offset)).await?;
        Ok(file)
    }

    fn lost(&self) -> Error {
        let digest = self.upload.digest.map_or_else(|| "?".to_owned(), |d| d.to_hex().to_string());
        Error::ContentLost { name: self.upload.id.to_string(), digest }
    }

    fn path(&self) -> PathBuf {
        self.store.blobs().partial(self.upload.id)
    }

    fn key(&self) -> String {
        self.upload.id.uuid().to_string()
    }
}
