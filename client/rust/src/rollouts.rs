//! Predictions: robot actions in, motion, costs or gradients out.

mod cost;
mod reply;
mod request;
mod state;
mod world;

pub use bendtwin_proto::v1::roll_out_response::{Deviation, Timing as RolloutTiming};
use bendtwin_proto::v1::rollout_service_client::RolloutServiceClient;
use futures::{Stream, StreamExt as _};

pub use self::{
    cost::{Cost, ForceBy, Line},
    reply::{Diagnostics, Divergence, Forces, Implausible, Reply},
    request::{GripperPoses, Rollout},
    state::{Grasping, State},
    world::{Collider, Grasp, Shape, Statistic, Vary, WirePose, World},
};
use crate::{Error, client::Channel};

/// Calls for predictions.
#[derive(Clone, Debug)]
pub struct Rollouts {
    service: RolloutServiceClient<Channel>,
}

impl Rollouts {
    pub(crate) fn new(service: RolloutServiceClient<Channel>) -> Self {
        Self { service }
    }

    /// Simulates a batch. Dropping the future stops the work at the server.
    ///
    /// # Errors
    /// If the request is wrong or too large, or the server cannot be asked.
    pub async fn run(&self, rollout: Rollout) -> Result<Reply, Error> {
        let request = rollout.into_request()?;
        self.service.clone().roll_out(request).await?.into_inner().try_into()
    }

    /// Simulates a batch; the reply is sent in parts, as instances finish. Dropping the stream
    /// stops the work at the server.
    ///
    /// # Errors
    /// Those of [`Rollouts::run`].
    pub async fn stream(
        &self,
        rollout: Rollout,
    ) -> Result<impl Stream<Item = Result<Reply, Error>> + use<>, Error> {
        let request = rollout.into_request()?;
        let parts = self.service.clone().stream_roll_out(request).await?.into_inner();
        Ok(parts.map(|part| Reply::try_from(part?)))
    }
}

#[cfg(test)]
mod tests;
