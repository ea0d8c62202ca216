//! `bendtwin.v1.WorkerService`.

use bendtwin_proto::v1::{
    DrainWorkerRequest, GetWorkerRequest, ListWorkersRequest, ListWorkersResponse, Worker,
    worker_service_server::WorkerService,
};
use tonic::{Request, Response, Status};

use super::{Api, convert};

#[tonic::async_trait]
impl WorkerService for Api {
    async fn get_worker(
        &self,
        request: Request<GetWorkerRequest>,
    ) -> Result<Response<Worker>, Status> {
        Ok(Response::new(convert::worker(self.app.worker(&request.get_ref().name).await?)))
    }

    async fn drain_worker(
        &self,
        request: Request<DrainWorkerRequest>,
    ) -> Result<Response<Worker>, Status> {
        let drained = self.app.drain_worker(&request.get_ref().name).await?;
        Ok(Response::new(convert::worker(drained)))
    }

    /// Workers are few, one a device: there is one page.
    async fn list_workers(
        &self,
        request: Request<ListWorkersRequest>,
    ) -> Result<Response<ListWorkersResponse>, Status> {
        let workers = self.app.workers(&request.get_ref().page_token).await?;
        Ok(Response::new(ListWorkersResponse {
            workers: workers.into_iter().map(convert::worker).collect(),
            next_page_token: String::new(),
        }))
    }
}
