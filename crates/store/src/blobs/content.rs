//! Reading content, and noticing that it is not what was stored. Disks lose and change bytes, and
//! people restore half of a backup: the size is compared before the first byte, and the digest
//! before the last one is handed out, so damaged content never arrives whole.

use std::ops::Range;

use bytes::Bytes;
use futures::{
    StreamExt as _, TryStreamExt as _,
    stream::{self, BoxStream},
};

use super::{Blobs, CHUNK, published};
use crate::{Digest, Error, Result};

/// A blob being read. The reader is not affected if it is deleted meanwhile.
pub struct Content {
    /// Size of all of it [bytes].
    pub size_bytes: u64,
    /// BLAKE3 of all of it.
    pub digest: Digest,
    /// The bytes, in chunks of up to 1 MiB. If they differ from those that were stored, an error
    /// comes in place of the last chunk.
    pub chunks: BoxStream<'static, Result<Bytes>>,
    blobs: Blobs,
    name: String,
}

impl std::fmt::Debug for Content {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Content").field("size_bytes", &self.size_bytes).finish_non_exhaustive()
    }
}

impl Content {
    /// Narrows the bytes to a range, cut off at the end of the content. A part has no separate
    /// digest, so only the size of the whole has been compared.
    ///
    /// # Errors
    /// [`Error::ContentLost`] if it has been deleted since; file errors, for an empty range, too.
    pub async fn range(self, range: Range<u64>) -> Result<Self> {
        let path = published(&self.digest.to_hex());
        let opened = self.blobs.place.read(&path, Some(range)).await?;
        let opened = opened.ok_or_else(|| lost(&self.digest, &self.name))?;
        Ok(Self { chunks: opened.chunks, ..self })
    }
}

impl Blobs {
    /// Opens the content that a row refers to. `size_bytes` is what the row says, if it says
    /// anything; `name` is the row's, for the error.
    ///
    /// # Errors
    /// [`Error::ContentLost`] if it is not there, [`Error::ContentDamaged`] if it is another.
    pub(crate) async fn read(
        &self,
        digest: &Digest,
        size_bytes: Option<u64>,
        name: &str,
    ) -> Result<Content> {
        let hex = digest.to_hex();
        let path = published(&hex);
        let opened = match self.place.read(&path, None).await? {
            None if self.place.take_back(&hex).await? => self.place.read(&path, None).await?,
            opened => opened,
        };
        let opened = opened.ok_or_else(|| lost(digest, name))?;
        let (digest, name) = (*digest, name.to_owned());
        let found = opened.size_bytes;
        if let Some(stored) = size_bytes.filter(|stored| *stored != found) {
            let fault = format!("it has {found} bytes and should have {stored}");
            return Err(damaged(&digest, &name, fault));
        }
        let checked = Verified::stream(opened.chunks, digest, name.clone());
        let chunks = if found <= CHUNK as u64 {
            let all: Vec<Bytes> = checked.try_collect().await?;
            stream::iter(all).map(Ok).boxed()
        } else {
            checked
        };
        Ok(Content { size_bytes: found, digest, chunks, blobs: self.clone(), name })
    }

    /// Checks that a published blob exists, and restores it from the trash if necessary.
    pub(super) async fn require(&self, digest: &str) -> Result<()> {
        if self.place.has(digest).await? || self.place.take_back(digest).await? {
            return Ok(());
        }
        let name = "an upload".to_owned();
        Err(Error::ContentLost { name, digest: digest.to_owned() })
    }
}

/// Chunks that are compared with a digest as they pass, each one step late, so that the last is
/// withheld if the digest is another.
struct Verified {
    chunks: stream::Fuse<BoxStream<'static, Result<Bytes>>>,
    hasher: Box<blake3::Hasher>,
    held: Option<Bytes>,
    digest: Digest,
    name: String,
}

impl Verified {
    fn stream(
        chunks: BoxStream<'static, Result<Bytes>>,
        digest: Digest,
        name: String,
    ) -> BoxStream<'static, Result<Bytes>> {
        let verified =
            Self { chunks: chunks.fuse(), hasher: Box::default(), held: None, digest, name };
        stream::try_unfold(verified, |mut verified| async move {
            Ok(verified.next().await?.map(|chunk| (chunk, verified)))
        })
        .boxed()
    }

    async fn next(&mut self) -> Result<Option<Bytes>> {
        while let Some(chunk) = self.chunks.try_next().await? {
            self.hasher.update(&chunk);
            if let Some(before) = self.held.replace(chunk) {
                return Ok(Some(before));
            }
        }
        if self.hasher.finalize() != self.digest {
            return Err(damaged(&self.digest, &self.name, "its digest is another".to_owned()));
        }
        Ok(self.held.take())
    }
}

fn lost(digest: &Digest, name: &str) -> Error {
    Error::ContentLost { name: name.to_owned(), digest: digest.to_hex().to_string() }
}

fn damaged(digest: &Digest, name: &str, fault: String) -> Error {
    Error::ContentDamaged { name: name.to_owned(), digest: digest.to_hex().to_string(), fault }
}
