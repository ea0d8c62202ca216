//! `bendtwin.v1.PlanningService`.

use bendtwin_proto::{
    deadline::timeout,
    v1::{PlanRequest, PlanUpdate, planning_service_server::PlanningService},
};
use tonic::{Request, Response, Status};

use super::{Api, Reply, counted::memory_of, reply};
use crate::app::Plan;

#[tonic::async_trait]
impl PlanningService for Api {
    type PlanStream = Reply<PlanUpdate>;

    async fn plan(
        &self,
        request: Request<PlanRequest>,
    ) -> Result<Response<Self::PlanStream>, Status> {
        let (timeout, memory) = (timeout(request.metadata()), memory_of(&request));
        let plan = Plan { request: request.into_inner(), timeout, as_lists: false, memory };
        let updates = self.app.plan(plan).await?;
        Ok(Response::new(reply(updates, |update| update)))
    }
}
