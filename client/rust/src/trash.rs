//! Deleted captures, fits and twins, which can be restored until they are purged.

pub(crate) mod retention;

use bendtwin_core::ids::{CaptureId, FitId, TwinId};
use bendtwin_proto::v1::{
    self, ListTrashedCapturesRequest, ListTrashedFitsRequest, ListTrashedTwinsRequest,
    UndeleteCaptureRequest, UndeleteFitRequest, UndeleteTwinRequest,
    trash_service_client::TrashServiceClient,
};
use jiff::Timestamp;
use serde::Serialize;

use crate::{
    Capture, Error, Fit, Twin,
    client::Channel,
    page::{self, Page},
    resources::resource,
};

resource! { v1::TrashedResource =>
/// A deleted capture, fit or twin.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Trashed {
    /// Name of the resource.
    pub name: String,
    /// Display name.
    pub display_name: String,
    /// Owner of the key with which it was made; empty if that is not known.
    pub owner: String,
    /// Time of creation.
    pub create_time: Timestamp,
    /// Time of the deletion.
    pub delete_time: Timestamp,
    /// Time from which it is purged; earlier if the disk of the server gets full.
    pub purge_time: Timestamp,
    /// Owner of the key that deleted it, or the rule that did; empty if that is not known.
    pub deleted_by: String,
    /// Size of the archive of a capture, or of a twin file; 0 for a fit [bytes].
    pub size_bytes: u64,
}
}

/// Calls about the trash.
#[derive(Clone, Debug)]
pub struct Trash {
    service: TrashServiceClient<Channel>,
}

/// All deleted resources of a collection, page by page.
macro_rules! list {
    ($self:ident, $owner:ident, $call:ident, $request:ident) => {
        page::all(|page| async move {
            let owner = $owner.to_owned();
            let request = $request { page_size: page.size, page_token: page.token, owner };
            let reply = $self.service.clone().$call(request).await?.into_inner();
            Page::new(reply.resources, reply.next_page_token, Trashed::try_from)
        })
        .await
    };
}

impl Trash {
    pub(crate) fn new(service: TrashServiceClient<Channel>) -> Self {
        Self { service }
    }

    /// Deleted captures, the last one first, of an owner; an empty name is any.
    ///
    /// # Errors
    /// If the server cannot be asked.
    pub async fn captures(&self, owner: &str) -> Result<Vec<Trashed>, Error> {
        list!(self, owner, list_trashed_captures, ListTrashedCapturesRequest)
    }

    /// Deleted fits, the last one first, of an owner; an empty name is any.
    ///
    /// # Errors
    /// If the server cannot be asked.
    pub async fn fits(&self, owner: &str) -> Result<Vec<Trashed>, Error> {
        list!(self, owner, list_trashed_fits, ListTrashedFitsRequest)
    }

    /// Deleted twins, the last one first, of an owner; an empty name is any.
    ///
    /// # Errors
    /// If the server cannot be asked.
    pub async fn twins(&self, owner: &str) -> Result<Vec<Trashed>, Error> {
        list!(self, owner, list_trashed_twins, ListTrashedTwinsRequest)
    }

    /// Restores a deleted capture, with its ingest. One that is not in the trash is returned
    /// unchanged.
    ///
    /// # Errors
    /// If it has been purged, or the server cannot be asked.
    pub async fn restore_capture(&self, name: CaptureId) -> Result<Capture, Error> {
        let request = UndeleteCaptureRequest { name: name.to_string() };
        self.service.clone().undelete_capture(request).await?.into_inner().try_into()
    }

    /// Restores a deleted fit; one that was queued is queued again. One that is not in the trash is
    /// returned unchanged.
    ///
    /// # Errors
    /// If it has been purged, or the server cannot be asked.
    pub async fn restore_fit(&self, name: FitId) -> Result<Fit, Error> {
        let request = UndeleteFitRequest { name: name.to_string() };
        self.service.clone().undelete_fit(request).await?.into_inner().try_into()
    }

    /// Restores a deleted twin. One that is not in the trash is returned unchanged.
    ///
    /// # Errors
    /// If it has been purged, or the server cannot be asked.
    pub async fn restore_twin(&self, name: TwinId) -> Result<Twin, Error> {
        let request = UndeleteTwinRequest { name: name.to_string() };
        self.service.clone().undelete_twin(request).await?.into_inner().try_into()
    }
}
