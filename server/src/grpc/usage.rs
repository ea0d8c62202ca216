//! `bendtwin.v1.UsageService`.

use bendtwin_proto::v1::{
    GetUsageRequest, ListOwnerUsageRequest, ListOwnerUsageResponse, OwnerUsage,
    usage_service_server::UsageService,
};
use tonic::{Request, Response, Status};

use super::{Api, convert};

#[tonic::async_trait]
impl UsageService for Api {
    async fn get_usage(&self, _: Request<GetUsageRequest>) -> Result<Response<OwnerUsage>, Status> {
        Ok(Response::new(convert::usage(self.app.usage().await?)))
    }

    async fn list_owner_usage(
        &self,
        request: Request<ListOwnerUsageRequest>,
    ) -> Result<Response<ListOwnerUsageResponse>, Status> {
        let r = request.into_inner();
        let page = self.app.owner_usage(&convert::page(r.page_size, r.page_token)).await?;
        Ok(Response::new(ListOwnerUsageResponse {
            owners: page.items.into_iter().map(convert::usage).collect(),
            next_page_token: page.next_token,
        }))
    }
}
