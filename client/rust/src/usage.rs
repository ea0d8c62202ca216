//! What is stored for the owners of keys, and their jobs.

use bendtwin_proto::v1::{
    self, GetUsageRequest, KeyQuotas, ListOwnerUsageRequest, StoredBytes,
    usage_service_client::UsageServiceClient,
};
use serde::Serialize;

use crate::{
    Error,
    client::Channel,
    page::{self, Page, PageRequest},
    resources::resource,
};

resource! { v1::OwnerUsage =>
/// Usage of one owner.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct OwnerUsage {
    /// Name of the owner; empty for what was made where no key was required.
    pub owner: String,
    /// Number of captures.
    pub captures: u64,
    /// Number of fits, ended ones included.
    pub fits: u64,
    /// Number of twins.
    pub twins: u64,
    /// Sizes of what is stored [bytes].
    pub stored_bytes: StoredBytes,
    /// Fits and ingests that wait for a worker.
    pub queued_jobs: u64,
    /// Fits and ingests that run.
    pub running_jobs: u64,
    /// Bounds of the key that is used; in a list, the widest of the owner's valid keys.
    pub quotas: KeyQuotas,
}
}

/// Calls about usage.
#[derive(Clone, Debug)]
pub struct Usage {
    service: UsageServiceClient<Channel>,
}

impl Usage {
    pub(crate) fn new(service: UsageServiceClient<Channel>) -> Self {
        Self { service }
    }

    /// Usage of the owner of the key that is used.
    ///
    /// # Errors
    /// If the server cannot be asked.
    pub async fn get(&self) -> Result<OwnerUsage, Error> {
        self.service.clone().get_usage(GetUsageRequest {}).await?.into_inner().try_into()
    }

    /// A page of the usage of all owners, by name. It takes the scope `admin`.
    ///
    /// # Errors
    /// If it is refused, or the server cannot be asked.
    pub async fn list(&self, page: PageRequest) -> Result<Page<OwnerUsage>, Error> {
        let request = ListOwnerUsageRequest { page_size: page.size, page_token: page.token };
        let reply = self.service.clone().list_owner_usage(request).await?.into_inner();
        Page::new(reply.owners, reply.next_page_token, OwnerUsage::try_from)
    }

    /// Usage of all owners, by name. It takes the scope `admin`.
    ///
    /// # Errors
    /// If it is refused, or the server cannot be asked.
    pub async fn all(&self) -> Result<Vec<OwnerUsage>, Error> {
        page::all(|page| self.list(page)).await
    }
}
