//! The bytes of an upload in a bucket: whole parts of a multipart upload, and an object with the bytes
//! after them. Any server continues it, from the rows.
//!
//! A part is sent as soon as more bytes have arrived, so there are always some after the last part.
//! They are rewritten with every commit, under another name: acknowledged bytes are never
//! overwritten. The multipart upload becomes the blob itself if the client has declared a digest,
//! else an object that is copied there.

use std::sync::Arc;

use bytes::{Bytes, BytesMut};
use object_store::path::Path;
use uuid::Uuid;

use super::{ResumableUpload, tree};
use crate::{
    Digest, Error, Result, Store,
    blobs::{At, Bucket, Multipart, PART, partial_objects, published},
    sql::{Transaction, query},
};

/// Name of the whole, where no digest was declared.
const WHOLE: &str = "whole";

/// The parts that an upload is written to.
#[derive(Debug)]
pub(super) struct PartSink {
    bucket: Arc<Bucket>,
    /// Read from the rows by the first write.
    open: Option<PartsState>,
}

#[derive(Debug)]
struct PartsState {
    multipart: Option<Multipart>,
    parts: Vec<Part>,
    /// Number of parts that have rows.
    committed: usize,
    /// The bytes after the parts.
    rest: BytesMut,
    /// Object that has them, as of the last commit.
    tail: Option<Path>,
}

#[derive(Clone, Debug)]
struct Part {
    tag: String,
    chaining: [u8; 32],
}

impl PartSink {
    pub(super) fn new(bucket: Arc<Bucket>) -> Self {
        Self { bucket, open: None }
    }

    pub(super) async fn write(
        &mut self,
        store: &Store,
        upload: &ResumableUpload,
        chunk: &Bytes,
    ) -> Result<()> {
        let mut chunk = chunk.clone();
        while !chunk.is_empty() {
            let open = self.open(store, upload).await?;
            let room = PART - open.rest.len();
            if room == 0 {
                self.send_part(store, upload).await?;
                continue;
            }
            let taken = chunk.split_to(room.min(chunk.len()));
            open.rest.extend_from_slice(&taken);
        }
        Ok(())
    }

    /// Sends the received bytes as the next part.
    async fn send_part(&mut self, store: &Store, upload: &ResumableUpload) -> Result<()> {
        let bucket = self.bucket.clone();
        let open = self.open(store, upload).await?;
        let multipart = match &open.multipart {
            Some(multipart) => multipart.clone(),
            None => begin(&bucket, store, upload).await?,
        };
        open.multipart = Some(multipart.clone());
        let (nth, bytes) = (open.parts.len(), open.rest.split().freeze());
        let hashed = bytes.clone();
        let chaining =
            tokio::task::spawn_blocking(move || tree::chaining((nth * PART) as u64, &hashed));
        let sent = bucket.put_part(&multipart, nth, bytes).await?;
        let tag = sent.ok_or_else(|| upload.lost())?;
        let chaining = chaining.await.map_err(std::io::Error::other)?;
        open.parts.push(Part { tag, chaining });
        Ok(())
    }

    /// Makes the written bytes durable, under names that no row has yet.
    pub(super) async fn sync(&mut self, store: &Store, upload: &ResumableUpload) -> Result<Path> {
        let bucket = self.bucket.clone();
        let open = self.open(store, upload).await?;
        let name = format!("tail-{}", Uuid::new_v4().simple());
        let tail = partial_objects(upload.id).join(name);
        bucket.put(&tail, Bytes::copy_from_slice(&open.rest)).await?;
        Ok(tail)
    }

    /// Writes into rows what [`PartSink::sync`] made durable, within a transaction.
    pub(super) async fn record(
        &self,
        tx: &mut Transaction,
        upload: &ResumableUpload,
        tail: &Path,
    ) -> Result<()> {
        let Some(open) = &self.open else { return Ok(()) };
        let id = upload.id.uuid().to_string();
        for (number, part) in open.parts.iter().enumerate().skip(open.committed) {
            query(
                "insert into upload_parts (upload, number, tag, chaining) values ($1, $2, $3, $4)",
            )
            .bind(&id)
            .bind(i64::try_from(number).unwrap_or(i64::MAX))
            .bind(&part.tag)
            .bind(Digest::from_bytes(part.chaining).to_hex().as_str())
            .execute(&mut *tx)
            .await?;
        }
        query("update uploads set tail = $2 where id = $1")
            .bind(&id)
            .bind(tail.as_ref())
            .execute(tx)
            .await?;
        Ok(())
    }

    /// After the commit: the object that the new one replaces goes.
    pub(super) async fn recorded(&mut self, tail: Path) {
        let Some(open) = &mut self.open else { return };
        open.committed = open.parts.len();
        if let Some(before) = open.tail.replace(tail)
            && let Err(error) = self.bucket.delete(&before).await
        {
            tracing::debug!(%error, "it goes with the upload");
        }
    }

    /// Forgets what no row has.
    pub(super) fn discard(&mut self) {
        self.open = None;
    }

    /// Hash of all received bytes.
    pub(super) async fn hash(&mut self, store: &Store, upload: &ResumableUpload) -> Result<Digest> {
        let open = self.open(store, upload).await?;
        let parts: Vec<_> = open.parts.iter().map(|part| part.chaining).collect();
        let rest = open.rest.clone();
        let hashing = tokio::task::spawn_blocking(move || {
            tree::root(&parts, (parts.len() * PART) as u64, &rest)
        });
        Ok(hashing.await.map_err(std::io::Error::other)?)
    }

    /// Makes one object of the parts, unless that was done before a crash. Returns it.
    pub(super) async fn join(
        &mut self,
        store: &Store,
        upload: &ResumableUpload,
        digest: &Digest,
    ) -> Result<At> {
        let bucket = self.bucket.clone();
        let size_bytes = upload.offset_bytes;
        if bucket.size(&published(&digest.to_hex())).await? == Some(size_bytes) {
            return Ok(At::Published);
        }
        let (multipart, tail) = stored_names(store, upload).await?;
        let Some(multipart) = multipart else {
            return tail.map(At::Object).ok_or_else(|| upload.lost());
        };
        let joined = match multipart.object == published(&digest.to_hex()) {
            true => At::Published,
            false => At::Object(multipart.object.clone()),
        };
        if bucket.size(&multipart.object).await? == Some(size_bytes) {
            return Ok(joined);
        }
        let open = self.open(store, upload).await?;
        let rest = open.rest.clone().freeze();
        let last = bucket.put_part(&multipart, open.parts.len(), rest).await?;
        let mut tags: Vec<String> = open.parts.iter().map(|part| part.tag.clone()).collect();
        tags.push(last.ok_or_else(|| upload.lost())?);
        // One that is gone may be complete, by a request whose answer was lost.
        bucket.complete(&multipart, tags).await?;
        match bucket.size(&multipart.object).await? {
            Some(found) if found == size_bytes => Ok(joined),
            _ => Err(upload.lost()),
        }
    }

    async fn open(&mut self, store: &Store, upload: &ResumableUpload) -> Result<&mut PartsState> {
        if self.open.is_none() {
            self.open = Some(read(&self.bucket, store, upload).await?);
        }
        self.open.as_mut().ok_or_else(|| upload.lost())
    }
}

/// Removes what an upload has in the bucket. Its row keeps the names until then.
pub(super) async fn remove(bucket: &Bucket, store: &Store, upload: &ResumableUpload) -> Result<()> {
    if let (Some(multipart), _) = stored_names(store, upload).await? {
        bucket.abort(&multipart).await?;
    }
    bucket.delete_below(&partial_objects(upload.id)).await
}

/// Begins the multipart upload, and remembers it before it has any part.
async fn begin(bucket: &Bucket, store: &Store, upload: &ResumableUpload) -> Result<Multipart> {
    let object = object(upload);
    let id = bucket.begin(&object).await?;
    let mut tx = store.inner.database.write().await?;
    let changed = query(
        "update uploads set multipart = $2
         where id = $1 and lease_epoch = $3 and multipart is null and state = 'receiving'",
    )
    .bind(upload.id.uuid().to_string())
    .bind(&id)
    .bind(upload.lease_epoch)
    .execute(&mut tx)
    .await?;
    tx.commit().await?;
    let multipart = Multipart { object, id };
    if changed == 0 {
        bucket.abort(&multipart).await?;
        return Err(Error::UploadLocked { name: upload.id.to_string() });
    }
    Ok(multipart)
}

/// The object that the multipart upload becomes.
fn object(upload: &ResumableUpload) -> Path {
    match upload.expected_digest {
        Some(digest) => published(&digest.to_hex()),
        None => partial_objects(upload.id).join(WHOLE),
    }
}

/// The names that the row has: of the multipart upload, and of the bytes after its parts.
async fn stored_names(
    store: &Store,
    upload: &ResumableUpload,
) -> Result<(Option<Multipart>, Option<Path>)> {
    let row: Option<(Option<String>, Option<String>)> =
        query("select multipart, tail from uploads where id = $1")
            .bind(upload.id.uuid().to_string())
            .fetch_optional(store.inner.database.read())
            .await?;
    let (multipart, tail) = row.unwrap_or_default();
    let multipart = multipart.map(|id| Multipart { object: object(upload), id });
    Ok((multipart, tail.map(Path::from)))
}

/// Parts and tail of an upload, by its rows.
async fn read(bucket: &Bucket, store: &Store, upload: &ResumableUpload) -> Result<PartsState> {
    let (multipart, tail) = stored_names(store, upload).await?;
    let rows: Vec<(String, String)> =
        query("select tag, chaining from upload_parts where upload = $1 order by number")
            .bind(upload.id.uuid().to_string())
            .fetch_all(store.inner.database.read())
            .await?;
    let part = |(tag, chaining): (String, String)| {
        let chaining = Digest::from_hex(chaining).map_err(|_| upload.lost())?;
        Ok(Part { tag, chaining: *chaining.as_bytes() })
    };
    let parts: Vec<Part> = rows.into_iter().map(part).collect::<Result<_>>()?;
    let mut rest = BytesMut::with_capacity(PART);
    if let Some(tail) = &tail {
        rest.extend_from_slice(&bucket.get(tail).await?.ok_or_else(|| upload.lost())?);
    }
    if (parts.len() * PART + rest.len()) as u64 != upload.offset_bytes || rest.len() > PART {
        return Err(upload.lost());
    }
    Ok(PartsState { multipart, committed: parts.len(), parts, rest, tail })
}
