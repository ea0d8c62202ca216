//! `bendtwin.v1.TwinService`.

use bendtwin_proto::v1::{
    CreateTwinRequest, DeleteTwinRequest, DeleteTwinResponse, ExportTwinRequest,
    ExportTwinResponse, GetTwinGeometryRequest, GetTwinRequest, GetTwinSurfaceRequest,
    ListTwinsRequest, ListTwinsResponse, Twin, TwinGeometry, TwinSurface, UpdateTwinRequest,
    create_twin_request, twin_service_server::TwinService,
};
use tonic::{Request, Response, Status, Streaming};

use super::{Api, Reply, chunks, convert, upload};
use crate::app::Listing;

#[tonic::async_trait]
impl TwinService for Api {
    async fn create_twin(
        &self,
        request: Request<Streaming<CreateTwinRequest>>,
    ) -> Result<Response<Twin>, Status> {
        let (metadata, body) = upload::open(request.into_inner(), |m| match m.part {
            Some(create_twin_request::Part::Metadata(m)) => upload::Part::Metadata(m),
            Some(create_twin_request::Part::Chunk(c)) => upload::Part::Chunk(c),
            None => upload::Part::Neither,
        })
        .await?;
        Ok(Response::new(convert::twin(self.app.create_twin(metadata, body).await?)))
    }

    async fn get_twin(&self, request: Request<GetTwinRequest>) -> Result<Response<Twin>, Status> {
        let twin = self.app.twin(&request.get_ref().name).await?;
        Ok(Response::new(convert::twin(twin)))
    }

    async fn list_twins(
        &self,
        request: Request<ListTwinsRequest>,
    ) -> Result<Response<ListTwinsResponse>, Status> {
        let r = request.into_inner();
        let page = self
            .app
            .twins(Listing {
                page: convert::page(r.page_size, r.page_token),
                search: r.search,
                tag: r.tag,
                capture: r.capture,
                owner: r.owner,
                order_by: r.order_by,
                level: r.level,
                ..Listing::default()
            })
            .await?;
        Ok(Response::new(ListTwinsResponse {
            twins: page.items.into_iter().map(convert::twin).collect(),
            next_page_token: page.next_token,
            total_size: page.total,
        }))
    }

    async fn update_twin(
        &self,
        request: Request<UpdateTwinRequest>,
    ) -> Result<Response<Twin>, Status> {
        Ok(Response::new(convert::twin(self.app.update_twin(request.into_inner()).await?)))
    }

    async fn delete_twin(
        &self,
        request: Request<DeleteTwinRequest>,
    ) -> Result<Response<DeleteTwinResponse>, Status> {
        let r = request.into_inner();
        self.app.delete_twin(&r.name, r.purge).await?;
        Ok(Response::new(DeleteTwinResponse {}))
    }

    async fn get_twin_geometry(
        &self,
        request: Request<GetTwinGeometryRequest>,
    ) -> Result<Response<TwinGeometry>, Status> {
        let geometry = self.app.twin_geometry(&request.get_ref().name, false).await?;
        Ok(Response::new(geometry.message))
    }

    async fn get_twin_surface(
        &self,
        request: Request<GetTwinSurfaceRequest>,
    ) -> Result<Response<TwinSurface>, Status> {
        let surface = self.app.twin_surface(&request.get_ref().name, false).await?;
        Ok(Response::new(surface.message))
    }

    type ExportTwinStream = Reply<ExportTwinResponse>;

    async fn export_twin(
        &self,
        request: Request<ExportTwinRequest>,
    ) -> Result<Response<Self::ExportTwinStream>, Status> {
        let (_, content) = self.app.twin_content(&request.get_ref().name).await?;
        Ok(Response::new(chunks(content, |chunk| ExportTwinResponse { chunk })))
    }
}
