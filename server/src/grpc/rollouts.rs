//! `bendtwin.v1.RolloutService`.

use bendtwin_proto::deadline::timeout;
use bendtwin_proto::v1::{RollOutRequest, RollOutResponse, rollout_service_server::RolloutService};
use tonic::{Request, Response, Status};

use super::{Api, Reply, reply};
use crate::dispatch::RollOut;

#[tonic::async_trait]
impl RolloutService for Api {
    async fn roll_out(
        &self,
        request: Request<RollOutRequest>,
    ) -> Result<Response<RollOutResponse>, Status> {
        let timeout = timeout(request.metadata());
        let rollout = RollOut { request: request.into_inner(), timeout, in_parts: false };
        Ok(Response::new(self.app.dispatch.roll_out(rollout).await?))
    }

    type StreamRollOutStream = Reply<RollOutResponse>;

    async fn stream_roll_out(
        &self,
        request: Request<RollOutRequest>,
    ) -> Result<Response<Self::StreamRollOutStream>, Status> {
        let timeout = timeout(request.metadata());
        let rollout = RollOut { request: request.into_inner(), timeout, in_parts: true };
        let parts = self.app.dispatch.parts(rollout).await?;
        Ok(Response::new(reply(parts, |part| part)))
    }
}
