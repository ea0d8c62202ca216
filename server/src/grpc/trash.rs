//! `bendtwin.v1.TrashService`.

mod retention;

use bendtwin_proto::v1::{
    Capture, Fit, ListTrashedCapturesRequest, ListTrashedCapturesResponse, ListTrashedFitsRequest,
    ListTrashedFitsResponse, ListTrashedTwinsRequest, ListTrashedTwinsResponse, Twin,
    UndeleteCaptureRequest, UndeleteFitRequest, UndeleteTwinRequest,
    trash_service_server::TrashService,
};
use bendtwin_store::Collection;
use tonic::{Request, Response, Status};

use super::{Api, convert};

#[tonic::async_trait]
impl TrashService for Api {
    async fn list_trashed_captures(
        &self,
        request: Request<ListTrashedCapturesRequest>,
    ) -> Result<Response<ListTrashedCapturesResponse>, Status> {
        let r = request.into_inner();
        let page = convert::page(r.page_size, r.page_token);
        let page = self.app.trashed(Collection::Captures, r.owner, &page).await?;
        Ok(Response::new(ListTrashedCapturesResponse {
            resources: page.items.into_iter().map(convert::trashed).collect(),
            next_page_token: page.next_token,
        }))
    }

    async fn list_trashed_fits(
        &self,
        request: Request<ListTrashedFitsRequest>,
    ) -> Result<Response<ListTrashedFitsResponse>, Status> {
        let r = request.into_inner();
        let page = convert::page(r.page_size, r.page_token);
        let page = self.app.trashed(Collection::Fits, r.owner, &page).await?;
        Ok(Response::new(ListTrashedFitsResponse {
            resources: page.items.into_iter().map(convert::trashed).collect(),
            next_page_token: page.next_token,
        }))
    }

    async fn list_trashed_twins(
        &self,
        request: Request<ListTrashedTwinsRequest>,
    ) -> Result<Response<ListTrashedTwinsResponse>, Status> {
        let r = request.into_inner();
        let page = convert::page(r.page_size, r.page_token);
        let page = self.app.trashed(Collection::Twins, r.owner, &page).await?;
        Ok(Response::new(ListTrashedTwinsResponse {
            resources: page.items.into_iter().map(convert::trashed).collect(),
            next_page_token: page.next_token,
        }))
    }

    async fn undelete_capture(
        &self,
        request: Request<UndeleteCaptureRequest>,
    ) -> Result<Response<Capture>, Status> {
        let capture = self.app.undelete_capture(&request.get_ref().name).await?;
        Ok(Response::new(convert::capture(capture)))
    }

    async fn undelete_fit(
        &self,
        request: Request<UndeleteFitRequest>,
    ) -> Result<Response<Fit>, Status> {
        let fit = self.app.undelete_fit(&request.get_ref().name).await?;
        Ok(Response::new(convert::fit(fit)))
    }

    async fn undelete_twin(
        &self,
        request: Request<UndeleteTwinRequest>,
    ) -> Result<Response<Twin>, Status> {
        let twin = self.app.undelete_twin(&request.get_ref().name).await?;
        Ok(Response::new(convert::twin(twin)))
    }
}
