//! `bendtwin.v1.FitService`.

use bendtwin_proto::v1::{
    CancelFitRequest, CreateFitRequest, DeleteFitRequest, DeleteFitResponse, Fit, FitLosses,
    FitPreview, GetFitLossesRequest, GetFitPreviewRequest, GetFitRequest, ListFitsRequest,
    ListFitsResponse, UpdateFitRequest, WatchFitRequest, fit_service_server::FitService,
};
use tonic::{Request, Response, Status};

use super::{Api, Reply, convert, reply};
use crate::app::{FitOrder, Listing, requirements_of};

#[tonic::async_trait]
impl FitService for Api {
    async fn create_fit(
        &self,
        request: Request<CreateFitRequest>,
    ) -> Result<Response<Fit>, Status> {
        let r = request.into_inner();
        let order = FitOrder {
            capture: r.capture,
            settings_json: r.settings_json,
            priority: r.priority,
            request_id: r.request_id,
            display_name: r.display_name,
            requirements: requirements_of(r.requirements),
        };
        let fit = self.app.create_fit(order).await?;
        Ok(Response::new(convert::fit(fit)))
    }

    async fn get_fit(&self, request: Request<GetFitRequest>) -> Result<Response<Fit>, Status> {
        let fit = self.app.fit(&request.get_ref().name).await?;
        Ok(Response::new(convert::fit(fit)))
    }

    async fn list_fits(
        &self,
        request: Request<ListFitsRequest>,
    ) -> Result<Response<ListFitsResponse>, Status> {
        let r = request.into_inner();
        let page = self
            .app
            .fits(Listing {
                page: convert::page(r.page_size, r.page_token),
                search: r.search,
                tag: r.tag,
                capture: r.capture,
                state: convert::read_state(r.state)?,
                owner: r.owner,
                order_by: r.order_by,
                ..Listing::default()
            })
            .await?;
        Ok(Response::new(ListFitsResponse {
            fits: page.items.into_iter().map(convert::fit).collect(),
            next_page_token: page.next_token,
            total_size: page.total,
        }))
    }

    async fn update_fit(
        &self,
        request: Request<UpdateFitRequest>,
    ) -> Result<Response<Fit>, Status> {
        Ok(Response::new(convert::fit(self.app.update_fit(request.into_inner()).await?)))
    }

    async fn get_fit_losses(
        &self,
        request: Request<GetFitLossesRequest>,
    ) -> Result<Response<FitLosses>, Status> {
        let losses = self.app.fit_losses(&request.get_ref().name).await?;
        Ok(Response::new(convert::losses(losses)))
    }

    async fn get_fit_preview(
        &self,
        request: Request<GetFitPreviewRequest>,
    ) -> Result<Response<FitPreview>, Status> {
        let (preview, _) = self.app.fit_preview(&request.get_ref().name).await?;
        Ok(Response::new(preview))
    }

    async fn cancel_fit(
        &self,
        request: Request<CancelFitRequest>,
    ) -> Result<Response<Fit>, Status> {
        let fit = self.app.cancel_fit(&request.get_ref().name).await?;
        Ok(Response::new(convert::fit(fit)))
    }

    async fn delete_fit(
        &self,
        request: Request<DeleteFitRequest>,
    ) -> Result<Response<DeleteFitResponse>, Status> {
        let r = request.into_inner();
        self.app.delete_fit(&r.name, r.purge).await?;
        Ok(Response::new(DeleteFitResponse {}))
    }

    type WatchFitStream = Reply<Fit>;

    async fn watch_fit(
        &self,
        request: Request<WatchFitRequest>,
    ) -> Result<Response<Self::WatchFitStream>, Status> {
        let r = request.into_inner();
        let fits = self.app.watch_fit(&r.name, r.after_revision).await?;
        Ok(Response::new(reply(fits, convert::fit)))
    }
}
