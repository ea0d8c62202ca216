//! Worker processes.

use bendtwin_core::ids::WorkerId;
use bendtwin_proto::v1::{
    DrainWorkerRequest, GetWorkerRequest, ListWorkersRequest,
    worker_service_client::WorkerServiceClient,
};

use crate::{
    Error, Worker,
    client::Channel,
    page::{self, Page, PageRequest},
};

/// Calls about worker processes.
#[derive(Clone, Debug)]
pub struct Workers {
    service: WorkerServiceClient<Channel>,
}

impl Workers {
    pub(crate) fn new(service: WorkerServiceClient<Channel>) -> Self {
        Self { service }
    }

    /// Returns a worker.
    ///
    /// # Errors
    /// If it is not known, or the server cannot be asked.
    pub async fn get(&self, name: WorkerId) -> Result<Worker, Error> {
        let request = GetWorkerRequest { name: name.to_string() };
        self.service.clone().get_worker(request).await?.into_inner().try_into()
    }

    /// Asks a worker to take no more work, to hand back its job, to finish its rollouts and to end.
    ///
    /// # Errors
    /// If it is not known, or the server cannot be asked.
    pub async fn drain(&self, name: WorkerId) -> Result<Worker, Error> {
        let request = DrainWorkerRequest { name: name.to_string() };
        self.service.clone().drain_worker(request).await?.into_inner().try_into()
    }

    /// A page of the workers.
    ///
    /// # Errors
    /// If the server cannot be asked.
    pub async fn list(&self, page: PageRequest) -> Result<Page<Worker>, Error> {
        let request = ListWorkersRequest { page_size: page.size, page_token: page.token };
        let reply = self.service.clone().list_workers(request).await?.into_inner();
        Page::new(reply.workers, reply.next_page_token, Worker::try_from)
    }

    /// All workers.
    ///
    /// # Errors
    /// If the server cannot be asked.
    pub async fn all(&self) -> Result<Vec<Worker>, Error> {
        page::all(|page| self.list(page)).await
    }
}
