//! The multipart upload of a resumable upload, which outlives the process: its id and the tags of its
//! parts are in rows.

use std::collections::BTreeSet;

use bendtwin_core::ids::UploadId;
use bytes::Bytes;
use futures::TryStreamExt as _;
use object_store::{
    multipart::{MultipartStore as _, PartId},
    path::Path,
};
use uuid::Uuid;

use super::{Bucket, found};
use crate::{Result, blobs::PARTIAL};

/// A multipart upload under way.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Multipart {
    /// The object that it becomes.
    pub(crate) object: Path,
    /// The id that S3 gave it.
    pub(crate) id: String,
}

impl Bucket {
    /// Begins one. Returns its id.
    pub(crate) async fn begin(&self, object: &Path) -> Result<String> {
        self.ask("write", self.store.create_multipart(&self.full(object))).await
    }

    /// Sends a part, counted from 0. Returns its tag; none if the upload is gone.
    pub(crate) async fn put_part(
        &self,
        upload: &Multipart,
        nth: usize,
        bytes: Bytes,
    ) -> Result<Option<String>> {
        let object = self.full(&upload.object);
        let sent = self.store.put_part(&object, &upload.id, nth, bytes.into());
        Ok(found(self.ask("write", sent).await)?.map(|part| part.content_id))
    }

    /// Makes the object of its parts. Returns false if the upload is gone: it may be complete.
    pub(crate) async fn complete(&self, upload: &Multipart, tags: Vec<String>) -> Result<bool> {
        let object = self.full(&upload.object);
        let parts = tags.into_iter().map(|content_id| PartId { content_id }).collect();
        let done = self.store.complete_multipart(&object, &upload.id, parts);
        Ok(found(self.ask("write", done).await)?.is_some())
    }

    /// Uploads that have objects.
    pub(crate) async fn partials(&self) -> Result<Vec<UploadId>> {
        let mut ids = BTreeSet::new();
        let mut listed = self.list(&Path::from(PARTIAL));
        while let Some(object) = listed.try_next().await? {
            let folder = object.location.parts().rev().nth(1);
            let id = folder.and_then(|name| Uuid::try_parse(name.as_ref()).ok());
            ids.extend(id.map(UploadId::from));
        }
        Ok(ids.into_iter().collect())
    }

    /// Ends it without an object.
    pub(crate) async fn abort(&self, upload: &Multipart) -> Result<()> {
        let object = self.full(&upload.object);
        found(self.ask("delete", self.store.abort_multipart(&object, &upload.id)).await).map(drop)
    }
}
