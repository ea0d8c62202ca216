//! Evaluation: a twin's predictions beside a recording of its object.

use bendtwin_core::{
    Quality,
    ids::{CaptureId, TwinId},
};
use bendtwin_proto::v1::{EvaluateTwinRequest, evaluation_service_client::EvaluationServiceClient};

use crate::{Error, client::Channel};

/// Calls that score twins.
#[derive(Clone, Debug)]
pub struct Evaluations {
    service: EvaluationServiceClient<Channel>,
}

impl Evaluations {
    pub(crate) fn new(service: EvaluationServiceClient<Channel>) -> Self {
        Self { service }
    }

    /// The quality table of a twin on a capture, with its assessment. To a recording of its object
    /// that it was not fitted to the twin is registered first ([`Quality::recordings`]), and all
    /// frames count as future. Dropping the future stops the work at the server.
    ///
    /// # Errors
    /// If there is no such twin or capture, if the twin does not explain the recording's first frame
    /// (reason `OBSERVATION_NOT_EXPLAINED`), or the server cannot be asked.
    pub async fn run(&self, twin: TwinId, capture: CaptureId) -> Result<Quality, Error> {
        let (twin, capture) = (twin.to_string(), capture.to_string());
        let request = EvaluateTwinRequest { twin, capture, motion: None };
        let reply = self.service.clone().evaluate_twin(request).await?.into_inner();
        serde_json::from_str(&reply.quality_json).map_err(Error::malformed)
    }
}
