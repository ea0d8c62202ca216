//! `bendtwin.v1.RetentionService`.

use bendtwin_proto::v1::{
    CreateRetentionRuleRequest, DeleteRetentionRuleRequest, DeleteRetentionRuleResponse,
    GetRetentionRuleRequest, ListRetentionRulesRequest, ListRetentionRulesResponse,
    PreviewRetentionRequest, PreviewRetentionResponse, RetentionRule as Message,
    retention_service_server::RetentionService,
};
use tonic::{Request, Response, Status};

use crate::grpc::{Api, convert};
use crate::options::RetentionRule;

#[tonic::async_trait]
impl RetentionService for Api {
    async fn create_retention_rule(
        &self,
        request: Request<CreateRetentionRuleRequest>,
    ) -> Result<Response<Message>, Status> {
        let r = request.into_inner();
        let rule = RetentionRule {
            display_name: r.display_name,
            collection: r.collection,
            min_age_days: r.min_age_days,
            owner: r.owner,
            tag: r.tag,
            verdict: r.verdict,
        };
        let rule = self.app.create_retention_rule(rule).await?;
        Ok(Response::new(convert::retention_rule(rule)))
    }

    async fn get_retention_rule(
        &self,
        request: Request<GetRetentionRuleRequest>,
    ) -> Result<Response<Message>, Status> {
        let rule = self.app.retention_rule(&request.get_ref().name).await?;
        Ok(Response::new(convert::retention_rule(rule)))
    }

    async fn list_retention_rules(
        &self,
        _request: Request<ListRetentionRulesRequest>,
    ) -> Result<Response<ListRetentionRulesResponse>, Status> {
        let (configured, stored) = self.app.retention_rules().await?;
        let configured = configured.into_iter().map(convert::retention_conditions);
        let rules = configured.chain(stored.into_iter().map(convert::retention_rule)).collect();
        Ok(Response::new(ListRetentionRulesResponse { rules }))
    }

    async fn delete_retention_rule(
        &self,
        request: Request<DeleteRetentionRuleRequest>,
    ) -> Result<Response<DeleteRetentionRuleResponse>, Status> {
        self.app.delete_retention_rule(&request.get_ref().name).await?;
        Ok(Response::new(DeleteRetentionRuleResponse {}))
    }

    async fn preview_retention(
        &self,
        _request: Request<PreviewRetentionRequest>,
    ) -> Result<Response<PreviewRetentionResponse>, Status> {
        let preview = self.app.preview_retention().await?;
        Ok(Response::new(PreviewRetentionResponse {
            outcomes: preview.matches.into_iter().map(convert::retention_outcome).collect(),
            truncated: preview.truncated,
        }))
    }
}
