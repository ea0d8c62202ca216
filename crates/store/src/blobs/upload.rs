//! Receiving content: hashed and counted as it streams, synced when complete. Dropped at any point,
//! it removes what it wrote.

use bytes::{Bytes, BytesMut};
use object_store::{MultipartUpload, path::Path};

use super::{Blobs, Staged};
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
        // In a separate task: the caller's future may be dropped half way through, when content is
        // no longer the upload's and not yet staged. Then the task drops what it staged.
        let whole = tokio::spawn(async move {
            let written = async {
                sink.put_part(part.freeze().into()).await?;
                sink.complete().await?;
                Ok(())
            };
            blobs.staging.meter.measure("write", written).await?;
            Ok(Staged::new(blobs, path, digest, size_bytes))
        });
        whole.await.map_err(object_store::Error::from)?
    }
}
