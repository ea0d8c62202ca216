//! `bendtwin.v1.KeyService`.

mod shares;
mod sign_ins;

use bendtwin_proto::v1::{
    CreateKeyRequest, CreateKeyResponse, DeleteKeyRequest, DeleteKeyResponse, GetKeyRequest, Key,
    ListKeysRequest, ListKeysResponse, key_service_server::KeyService,
};
use tonic::{Request, Response, Status};

use super::{Api, convert};
use crate::app::KeyOrder;

#[tonic::async_trait]
impl KeyService for Api {
    async fn create_key(
        &self,
        request: Request<CreateKeyRequest>,
    ) -> Result<Response<CreateKeyResponse>, Status> {
        let r = request.into_inner();
        let order = KeyOrder {
            display_name: r.display_name,
            owner: r.owner,
            scopes: r.scopes,
            expires: r.expire_time.map(convert::timestamp).transpose()?,
            quotas: r.quotas.map(convert::quotas).unwrap_or_default(),
        };
        let (key, secret_key) = self.app.create_key(order).await?;
        Ok(Response::new(CreateKeyResponse { key: Some(convert::key(key)), secret_key }))
    }

    async fn get_key(&self, request: Request<GetKeyRequest>) -> Result<Response<Key>, Status> {
        let key = self.app.key(&request.get_ref().name).await?;
        Ok(Response::new(convert::key(key)))
    }

    async fn list_keys(
        &self,
        request: Request<ListKeysRequest>,
    ) -> Result<Response<ListKeysResponse>, Status> {
        let r = request.into_inner();
        let page = self.app.list_keys(&convert::page(r.page_size, r.page_token)).await?;
        Ok(Response::new(ListKeysResponse {
            keys: page.items.into_iter().map(convert::key).collect(),
            next_page_token: page.next_token,
        }))
    }

    async fn delete_key(
        &self,
        request: Request<DeleteKeyRequest>,
    ) -> Result<Response<DeleteKeyResponse>, Status> {
        self.app.revoke_key(&request.get_ref().name).await?;
        Ok(Response::new(DeleteKeyResponse {}))
    }
}
