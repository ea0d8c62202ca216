//! Complete content that no row refers to yet, and its way to its place.

use bytes::Bytes;
use futures::TryStreamExt as _;
use object_store::path::Path;

use bendtwin_core::ids::UploadId;

use super::{Blobs, Place, partial, published};
use crate::{Digest, Error, Result, keys::quotas::reservation::Reservation};

/// Complete content that no row refers to yet: give it to the `create` of an aggregate.
#[derive(Debug)]
pub struct Staged {
    blobs: Blobs,
    at: At,
    digest: Digest,
    size_bytes: u64,
    /// The resumable upload of this content: its stored bytes stay until the upload has ended.
    upload: Option<UploadId>,
    /// Bytes that are set aside for it, until a resource is made of it.
    reservation: Option<Reservation>,
    /// True if it was received to be compared alone, and is nowhere.
    is_compared: bool,
}

/// Whereabouts of staged content.
#[derive(Clone, Debug)]
pub(crate) enum At {
    /// A local file, by its path in the folder of temporary files.
    File(Path),
    /// Another object of the bucket.
    Object(Path),
    /// At the final path.
    Published,
}

impl Staged {
    /// Content in a temporary file, which goes if it is not published.
    pub(super) fn new(blobs: Blobs, file: Path, digest: Digest, size_bytes: u64) -> Self {
        Self::at(blobs, At::File(file), digest, size_bytes)
    }

    /// Content that was received to be compared alone.
    pub(super) fn compared(blobs: Blobs, digest: Digest, size_bytes: u64) -> Self {
        let mut staged = Self::at(blobs, At::Published, digest, size_bytes);
        staged.is_compared = true;
        staged
    }

    fn at(blobs: Blobs, at: At, digest: Digest, size_bytes: u64) -> Self {
        let (upload, reservation) = (None, None);
        Self { blobs, at, digest, size_bytes, upload, reservation, is_compared: false }
    }

    /// The content with the bytes that are set aside for it.
    pub(super) fn within(mut self, reservation: Option<Reservation>) -> Self {
        self.reservation = reservation;
        self
    }

    /// The content of a resumable upload.
    pub(crate) fn of_upload(
        blobs: Blobs,
        id: UploadId,
        at: At,
        digest: Digest,
        size_bytes: u64,
    ) -> Self {
        let mut staged = Self::at(blobs, at, digest, size_bytes);
        staged.upload = Some(id);
        staged
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
    /// File errors; [`Error::ObjectsUnavailable`].
    pub async fn bytes(&self) -> Result<Bytes> {
        self.head(self.size_bytes).await
    }

    /// The first bytes of the content, `length` or as many as there are.
    ///
    /// # Errors
    /// File errors; [`Error::ObjectsUnavailable`].
    pub async fn head(&self, length: u64) -> Result<Bytes> {
        let range = 0..length.min(self.size_bytes);
        if range.is_empty() {
            return Ok(Bytes::new());
        }
        let opened = match &self.at {
            At::File(path) => self.blobs.staging.read(path, Some(range)).await?,
            At::Object(path) => self.blobs.place.read(path, Some(range)).await?,
            At::Published => {
                let path = published(&self.digest.to_hex());
                self.blobs.place.read(&path, Some(range)).await?
            }
        };
        let opened = opened.ok_or_else(|| self.lost())?;
        let chunks: Vec<Bytes> = opened.chunks.try_collect().await?;
        Ok(match <[Bytes; 1]>::try_from(chunks) {
            Ok([whole]) => whole,
            Err(chunks) => chunks.concat().into(),
        })
    }

    /// The resumable upload of this content.
    pub(crate) fn upload(&self) -> Option<UploadId> {
        self.upload
    }

    /// True if it was received to be compared alone, and is stored nowhere: compare its digest.
    pub fn is_compared(&self) -> bool {
        self.is_compared
    }

    /// The bytes that are set aside for it.
    pub(crate) fn take_reservation(&mut self) -> Option<Reservation> {
        self.reservation.take()
    }

    /// Puts it in its place, where it replaces equal content: that may have been damaged, and it
    /// is new from now on.
    pub(super) async fn publish(mut self) -> Result<()> {
        let digest = self.digest.to_hex();
        let to = published(&digest);
        match (&self.blobs.place, &self.at) {
            (Place::Folder(folder), At::File(path)) => {
                folder.rename(path, &to).await?;
                self.at = At::Published;
            }
            (Place::Bucket(bucket), At::File(path)) => {
                let file = self.blobs.staging.root().join(path.as_ref());
                bucket.send(&file, &to, self.size_bytes).await?;
            }
            (Place::Bucket(bucket), At::Object(path)) => {
                bucket.copy(path, &to, self.size_bytes).await?;
            }
            // Put in place before a crash.
            (Place::Folder(_), At::Object(_)) | (_, At::Published) => {
                self.blobs.require(&digest).await?;
            }
        }
        if let (Place::Bucket(bucket), Some(id)) = (&self.blobs.place, self.upload) {
            bucket.delete_below(&partial::object(id)).await?;
        }
        Ok(())
    }

    fn lost(&self) -> Error {
        let name = self.upload.map_or_else(|| "an upload".to_owned(), |id| id.to_string());
        Error::ContentLost { name, digest: self.digest.to_hex().to_string() }
    }
}

impl Drop for Staged {
    fn drop(&mut self) {
        if self.upload.is_some() {
            return;
        }
        // Without a runtime the next start removes it.
        if let (At::File(path), Ok(runtime)) = (&self.at, tokio::runtime::Handle::try_current()) {
            let (path, folder) = (path.clone(), self.blobs.staging.clone());
            runtime.spawn(async move {
                if let Err(error) = folder.delete(&path).await {
                    tracing::warn!(%error, "an unused upload stays until the next start");
                }
            });
        }
    }
}
