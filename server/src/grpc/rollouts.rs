//! `bendtwin.v1.RolloutService`.

use std::time::Duration;

use bendtwin_proto::deadline::timeout;
use bendtwin_proto::v1::{RollOutRequest, RollOutResponse, rollout_service_server::RolloutService};
use tonic::{Request, Response, Status};

use super::{Api, Reply, counted::memory_of, reply};
use crate::app::{InParts, RollOut, Whole};

#[tonic::async_trait]
impl RolloutService for Api {
    async fn roll_out(
        &self,
        request: Request<RollOutRequest>,
    ) -> Result<Response<RollOutResponse>, Status> {
        let timeout = timeout(request.metadata());
        let Whole { response, held } = self.app.roll_out(rollout(request, timeout, false)).await?;
        let mut response = Response::new(response);
        response.extensions_mut().insert(held.memory());
        Ok(response)
    }

    type StreamRollOutStream = Reply<RollOutResponse>;

    async fn stream_roll_out(
        &self,
        request: Request<RollOutRequest>,
    ) -> Result<Response<Self::StreamRollOutStream>, Status> {
        let timeout = timeout(request.metadata());
        let InParts { parts, held } =
            self.app.roll_out_in_parts(rollout(request, timeout, true)).await?;
        let mut response = Response::new(reply(parts, |part| part));
        response.extensions_mut().insert(held.memory());
        Ok(response)
    }
}

fn rollout(request: Request<RollOutRequest>, timeout: Option<Duration>, in_parts: bool) -> RollOut {
    let memory = memory_of(&request);
    RollOut {
        request: request.into_inner(),
        timeout,
        in_parts,
        as_lists: false,
        commit_slots: Vec::new(),
        memory,
    }
}
