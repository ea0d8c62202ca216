//! Owners of resources. The owner of a resource never changes.

pub(crate) mod deleted_requests;
pub(crate) mod projects;
pub(crate) mod request_ids;

use bendtwin_core::ids::{CaptureId, FitId, TwinId, UploadId};
use uuid::Uuid;

use crate::{Error, Result, Store, sql::query_scalar};

/// The owners of what is in a store.
#[derive(Clone, Copy, Debug)]
pub struct Owners<'a> {
    pub(crate) store: &'a Store,
}

impl Owners<'_> {
    /// The owner of a capture; empty if it is not known.
    ///
    /// # Errors
    /// [`Error::NotFound`].
    pub async fn of_capture(&self, id: CaptureId) -> Result<String> {
        self.of("select owner from captures where id = $1", id.uuid(), &id).await
    }

    /// The owner of a fit, as [`Owners::of_capture`].
    ///
    /// # Errors
    /// [`Error::NotFound`].
    pub async fn of_fit(&self, id: FitId) -> Result<String> {
        self.of("select owner from jobs where id = $1 and kind = 'fit'", id.uuid(), &id).await
    }

    /// The owner of a twin, as [`Owners::of_capture`].
    ///
    /// # Errors
    /// [`Error::NotFound`].
    pub async fn of_twin(&self, id: TwinId) -> Result<String> {
        self.of("select owner from twins where id = $1", id.uuid(), &id).await
    }

    /// The owner of a resumable upload, as [`Owners::of_capture`].
    ///
    /// # Errors
    /// [`Error::NotFound`].
    pub async fn of_upload(&self, id: UploadId) -> Result<String> {
        self.of("select owner from uploads where id = $1", id.uuid(), &id).await
    }

    async fn of(
        &self,
        select: &'static str,
        id: Uuid,
        name: &(dyn std::fmt::Display + Sync),
    ) -> Result<String> {
        let owner: Option<String> = query_scalar(select)
            .bind(id.to_string())
            .fetch_optional(self.store.inner.database.read())
            .await?;
        owner.ok_or_else(|| Error::NotFound { name: name.to_string() })
    }
}
