//! Content on its way into a bucket: from a local file, or from another object.

use bytes::{Bytes, BytesMut};
use futures::{StreamExt as _, stream::FuturesOrdered};
use object_store::{
    ObjectStoreExt as _,
    multipart::{MultipartStore as _, PartId},
    path::Path,
};
use tokio::{fs::File, io::AsyncReadExt as _};

use super::{Bucket, PART};
use crate::Result;

/// Parts in flight per object.
const AT_ONCE: usize = 2;
/// Most parts that a multipart upload may have, with some to spare.
const MOST_PARTS: u64 = 9_000;
/// Size up to which S3 copies an object by itself [bytes].
const MOST_COPIED: u64 = 5 << 30;

/// The content of an object to be, piece by piece.
enum Source<'a> {
    File(File),
    Object { bucket: &'a Bucket, path: &'a Path, at: u64, end: u64 },
}

impl Bucket {
    /// Sends a local file. The object is durable afterwards, and either whole or not there.
    pub(crate) async fn send(
        &self,
        file: &std::path::Path,
        to: &Path,
        size_bytes: u64,
    ) -> Result<()> {
        let _permit = self.senders.acquire().await.map_err(std::io::Error::other)?;
        let mut source = Source::File(File::open(file).await?);
        if size_bytes <= PART as u64 {
            let whole = source.next(PART).await?;
            return self.put(to, whole).await;
        }
        self.send_parts(to, source, size_bytes).await
    }

    /// Copies an object within the bucket: by itself, or if it is too large for that, through here.
    pub(in crate::blobs) async fn copy(
        &self,
        from: &Path,
        to: &Path,
        size_bytes: u64,
    ) -> Result<()> {
        if size_bytes <= MOST_COPIED {
            return self.ask("write", self.store.copy(&self.full(from), &self.full(to))).await;
        }
        let source = Source::Object { bucket: self, path: from, at: 0, end: size_bytes };
        self.send_parts(to, source, size_bytes).await
    }

    async fn send_parts(&self, to: &Path, source: Source<'_>, size_bytes: u64) -> Result<()> {
        let full = self.full(to);
        let id = self.ask("write", self.store.create_multipart(&full)).await?;
        let part = (PART as u64).max(size_bytes.div_ceil(MOST_PARTS)) as usize;
        let done = async {
            let parts = self.put_parts(&full, &id, source, part).await?;
            self.ask("write", self.store.complete_multipart(&full, &id, parts)).await.map(drop)
        };
        let done = done.await;
        if done.is_err() {
            // What stays of it costs money until the bucket's own rule removes it.
            self.ask("delete", self.store.abort_multipart(&full, &id)).await.ok();
        }
        done
    }

    async fn put_parts(
        &self,
        full: &Path,
        id: &String,
        mut source: Source<'_>,
        part: usize,
    ) -> Result<Vec<PartId>> {
        let (mut under_way, mut parts) = (FuturesOrdered::new(), Vec::new());
        for nth in 0.. {
            let bytes = source.next(part).await?;
            if bytes.is_empty() {
                break;
            }
            if under_way.len() >= AT_ONCE
                && let Some(put) = under_way.next().await
            {
                parts.push(put?);
            }
            under_way
                .push_back(self.ask("write", self.store.put_part(full, id, nth, bytes.into())));
        }
        while let Some(put) = under_way.next().await {
            parts.push(put?);
        }
        Ok(parts)
    }
}

impl Source<'_> {
    /// The next `length` bytes, or those up to the end.
    async fn next(&mut self, length: usize) -> Result<Bytes> {
        match self {
            Self::Object { bucket, path, at, end } => {
                let range = *at..(*end).min(*at + length as u64);
                *at = range.end;
                if range.is_empty() { Ok(Bytes::new()) } else { bucket.range(path, range).await }
            }
            Self::File(file) => {
                let mut bytes = BytesMut::with_capacity(length);
                while bytes.len() < length {
                    let left = length - bytes.len();
                    if (&mut *file).take(left as u64).read_buf(&mut bytes).await? == 0 {
                        break;
                    }
                }
                Ok(bytes.freeze())
            }
        }
    }
}
