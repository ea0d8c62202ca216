//! `bendtwin.v1.ShareService`.

use bendtwin_proto::v1::{
    DeleteShareRequest, DeleteShareResponse, ListSharesRequest, ListSharesResponse,
    ShareTwinRequest, ShareTwinResponse, share_service_server::ShareService,
};
use tonic::{Request, Response, Status};

use crate::{
    app::ShareOrder,
    grpc::{Api, convert},
};

#[tonic::async_trait]
impl ShareService for Api {
    async fn share_twin(
        &self,
        request: Request<ShareTwinRequest>,
    ) -> Result<Response<ShareTwinResponse>, Status> {
        let r = request.into_inner();
        let order = ShareOrder {
            twin: r.twin,
            display_name: r.display_name,
            ttl_s: r.ttl_s,
            expires: r.expire_time.map(convert::timestamp).transpose()?,
            may_export: r.allow_export,
        };
        let (key, secret_key) = self.app.share_twin(order).await?;
        Ok(Response::new(ShareTwinResponse { share: Some(convert::share(key)), secret_key }))
    }

    async fn list_shares(
        &self,
        request: Request<ListSharesRequest>,
    ) -> Result<Response<ListSharesResponse>, Status> {
        let r = request.into_inner();
        let page = convert::page(r.page_size, r.page_token);
        let page = self.app.list_shares(&r.twin, &page).await?;
        Ok(Response::new(ListSharesResponse {
            shares: page.items.into_iter().map(convert::share).collect(),
            next_page_token: page.next_token,
        }))
    }

    async fn delete_share(
        &self,
        request: Request<DeleteShareRequest>,
    ) -> Result<Response<DeleteShareResponse>, Status> {
        self.app.revoke_share(&request.get_ref().name).await?;
        Ok(Response::new(DeleteShareResponse {}))
    }
}
