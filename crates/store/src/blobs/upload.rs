//! Receiving content: hashed and counted as it streams, synced when complete. Dropped at any point,
//! it removes what it wrote.

use bytes::{Bytes, BytesMut};
use object_store::{MultipartUpload, ObjectStoreExt as _, path::Path};

use bendtwin_core::ids::UploadId;

use super::{Blobs, partial};
use crate::{Digest, Error, Result};

/// Part size of multipart uploads: memory of each upload under way.
const PART: usize = 512 << 10;

/// An upload under way.
#[derive(Debug)]
pub struct Upload {
    blobs: Blobs,
    path: Path,
    sink: Box<dyn MultipartUpload>,
    hasher: Box<blake3::Hasher>,
    part: BytesMut,
    size_bytes: u64,
    limit: u64,
}

impl Upload {
    pub(super) fn new(
        blobs: Blobs,
        path: Path,
        sink: Box<dyn MultipartUpload>,
        limit: u64,
    ) -> Self {
        let (hasher, part) = (Box::default(), BytesMut::new());
        Self { blobs, path, sink, hasher, part, size_bytes: 0, limit }
    }

    /// Appends a chunk.
    ///
    /// # Errors
    /// [`Error::TooLarge`], [`Error::DiskFull`]; drop the upload then.
    pub async fn write(&mut self, chunk: Bytes) -> Result<()> {
        self.size_bytes = self.size_bytes.saturating_add(chunk.len() as u64);
        if self.size_bytes > self.limit {
            return Err(Error::TooLarge { limit: self.limit });
        }
        self.hasher.update(&chunk);
        self.part.extend_from_slice(&chunk);
        if self.part.len() >= PART {
            self.blobs.admit()?;
            let part = self.part.split().freeze();
            self.sink.put_part(part.into()).await?;
        }
        Ok(())
    }

    /// Ends the upload: checks the digest if one is given, and syncs.
    ///
    /// # Errors
    /// [`Error::DigestMismatch`], file errors.
    pub async fn finish(self, expected: Option<Digest>) -> Result<Staged> {
        let digest = self.hasher.finalize();
        if let Some(given) = expected.filter(|given| *given != digest) {
            return Err(Error::DigestMismatch { given, actual: digest });
        }
        let Self { blobs, path, mut sink, part, size_bytes, .. } = self;
        // In a task of its own: whoever waits here may be dropped half way through, when content is
        // no longer the upload's and not yet staged. Then the task drops what it staged.
        let whole = tokio::spawn(async move {
            sink.put_part(part.freeze().into()).await?;
            sink.complete().await?;
            Ok(Staged { blobs, path: Some(path), digest, size_bytes, upload: None })
        });
        whole.await.map_err(object_store::Error::from)?
    }
}

/// Complete content that no row refers to yet: give it to the `create` of an aggregate.
#[derive(Debug)]
pub struct Staged {
    blobs: Blobs,
    /// None once it is published.
    path: Option<Path>,
    digest: Digest,
    size_bytes: u64,
    /// The resumable upload of this content: its file stays until the upload has ended.
    upload: Option<UploadId>,
}

impl Staged {
    /// The content of a resumable upload, in its own file unless that is in its final place
    /// already.
    pub(crate) fn from_partial(
        blobs: Blobs,
        id: UploadId,
        in_file: bool,
        digest: Digest,
        size_bytes: u64,
    ) -> Self {
        let path = in_file.then(|| partial::object(id));
        Self { blobs, path, digest, size_bytes, upload: Some(id) }
    }

    /// BLAKE3 of the content.
    pub fn digest(&self) -> Digest {
        self.digest
    }

    /// Size [bytes].
    pub fn size_bytes(&self) -> u64 {
        self.size_bytes
    }

    /// The content, to be checked before a row refers to it.
    ///
    /// # Errors
    /// File errors.
    pub async fn bytes(&self) -> Result<Bytes> {
        Ok(self.blobs.objects.get(&self.place()).await?.bytes().await?)
    }

    /// The first bytes of the content, `length` or as many as there are.
    ///
    /// # Errors
    /// File errors.
    pub async fn head(&self, length: u64) -> Result<Bytes> {
        let range = 0..length.min(self.size_bytes);
        if range.is_empty() {
            return Ok(Bytes::new());
        }
        Ok(self.blobs.objects.get_range(&self.place(), range).await?)
    }

    /// Path of the content at present.
    fn place(&self) -> Path {
        self.path.clone().unwrap_or_else(|| super::published(&self.digest.to_hex()))
    }

    /// The resumable upload of this content.
    pub(crate) fn upload(&self) -> Option<UploadId> {
        self.upload
    }

    pub(super) fn path(&self) -> Option<&Path> {
        self.path.as_ref()
    }

    pub(super) fn disarm(mut self) {
        self.path = None;
    }
}

impl Drop for Staged {
    fn drop(&mut self) {
        if self.upload.is_some() {
            return;
        }
        // Without a runtime the next start removes it.
        if let (Some(path), Ok(runtime)) = (self.path.take(), tokio::runtime::Handle::try_current())
        {
            let blobs = self.blobs.clone();
            runtime.spawn(async move {
                if let Err(error) = blobs.delete_path(&path).await {
                    tracing::warn!(%error, "an unused upload stays until the next start");
                }
            });
        }
    }
}
