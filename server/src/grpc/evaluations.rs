//! `bendtwin.v1.EvaluationService`.

use bendtwin_proto::{
    deadline::timeout,
    v1::{EvaluateTwinRequest, Evaluation, evaluation_service_server::EvaluationService},
};
use tonic::{Request, Response, Status};

use super::Api;

#[tonic::async_trait]
impl EvaluationService for Api {
    async fn evaluate_twin(
        &self,
        request: Request<EvaluateTwinRequest>,
    ) -> Result<Response<Evaluation>, Status> {
        let timeout = timeout(request.metadata());
        Ok(Response::new(self.app.evaluate_twin(request.into_inner(), timeout).await?))
    }
}
