//! Receiving content: hashed and counted as it streams, synced when complete. Dropped at any point,
//! it removes what it wrote. No byte is written for which its owner has no room.

use bytes::{Bytes, BytesMut};
use object_store::{MultipartUpload, path::Path};

use super::{Blobs, Staged};
use crate::{Digest, Error, Result, keys::quotas::reservation::Reservation};

/// Part size of multipart uploads: memory of each upload under way.
const PART: usize = 512 << 10;

/// An upload under way.
#[derive(Debug)]
pub struct Upload {
    blobs: Blobs,
    /// The temporary file; none if the content is only compared with what is stored.
    file: Option<TemporaryFile>,
    /// Bytes that are set aside for it, if it is a client's.
    reservation: Option<Reservation>,
    hasher: Box<blake3::Hasher>,
    part: BytesMut,
    size_bytes: u64,
    limit: u64,
}

/// A temporary file that is written.
#[derive(Debug)]
pub(super) struct TemporaryFile {
    pub(super) path: Path,
    pub(super) sink: Box<dyn MultipartUpload>,
}

impl Upload {
    pub(super) fn new(blobs: Blobs, file: Option<TemporaryFile>, limit: u64) -> Self {
        let (hasher, part) = (Box::default(), BytesMut::new());
        Self { blobs, file, reservation: None, hasher, part, size_bytes: 0, limit }
    }

    /// The upload with bytes set aside for it, and more of them as it grows.
    pub(crate) fn within(self, reservation: Reservation) -> Self {
        Self { reservation: Some(reservation), ..self }
    }

    /// Appends a chunk.
    ///
    /// # Errors
    /// [`Error::TooLarge`], [`Error::QuotaBytes`], [`Error::DiskFull`]; drop the upload then.
    pub async fn write(&mut self, chunk: Bytes) -> Result<()> {
        self.size_bytes = self.size_bytes.saturating_add(chunk.len() as u64);
        if self.size_bytes > self.limit {
            return Err(Error::TooLarge { limit: self.limit });
        }
        if let Some(reservation) = &mut self.reservation {
            reservation.cover(self.size_bytes).await?;
        }
        self.hasher.update(&chunk);
        let Some(file) = &mut self.file else { return Ok(()) };
        self.part.extend_from_slice(&chunk);
        if self.part.len() >= PART {
            self.blobs.admit()?;
            let part = self.part.split().freeze();
            file.sink.put_part(part.into()).await?;
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
        let Self { blobs, file, part, size_bytes, reservation, .. } = self;
        let Some(TemporaryFile { path, mut sink }) = file else {
            return Ok(Staged::compared(blobs, digest, size_bytes));
        };
        // In a separate task: the caller's future may be dropped half way through, when content is
        // no longer the upload's and not yet staged. Then the task drops what it staged.
        let whole = tokio::spawn(async move {
            let written = async {
                sink.put_part(part.freeze().into()).await?;
                sink.complete().await?;
                Ok(())
            };
            blobs.staging.meter.measure("write", written).await?;
            Ok(Staged::new(blobs, path, digest, size_bytes).within(reservation))
        });
        whole.await.map_err(object_store::Error::from)?
    }
}
