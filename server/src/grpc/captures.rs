//! `bendtwin.v1.CaptureService`.

use bendtwin_proto::v1::{
    Capture, CreateCaptureRequest, CreateCaptureResponse, DeleteCaptureRequest,
    DeleteCaptureResponse, GetCaptureRequest, ListCapturesRequest, ListCapturesResponse,
    capture_service_server::CaptureService, create_capture_request,
};
use tonic::{Request, Response, Status, Streaming};

use super::{Api, convert, upload};
use crate::app::CaptureUpload;

#[tonic::async_trait]
impl CaptureService for Api {
    async fn create_capture(
        &self,
        request: Request<Streaming<CreateCaptureRequest>>,
    ) -> Result<Response<CreateCaptureResponse>, Status> {
        let (metadata, body) = upload::open(request.into_inner(), |m| match m.part {
            Some(create_capture_request::Part::Metadata(m)) => upload::Part::Metadata(m),
            Some(create_capture_request::Part::Chunk(c)) => upload::Part::Chunk(c),
            None => upload::Part::Neither,
        })
        .await?;
        let upload = CaptureUpload {
            display_name: metadata.display_name,
            request_id: metadata.request_id,
            digest: metadata.digest,
            body,
        };
        let capture = convert::capture(self.app.create_capture(upload).await?);
        Ok(Response::new(CreateCaptureResponse { capture: Some(capture) }))
    }

    async fn get_capture(
        &self,
        request: Request<GetCaptureRequest>,
    ) -> Result<Response<Capture>, Status> {
        let capture = self.app.capture(&request.get_ref().name).await?;
        Ok(Response::new(convert::capture(capture)))
    }

    async fn list_captures(
        &self,
        request: Request<ListCapturesRequest>,
    ) -> Result<Response<ListCapturesResponse>, Status> {
        let request = request.into_inner();
        let page = self.app.captures(&convert::page(request.page_size, request.page_token)).await?;
        Ok(Response::new(ListCapturesResponse {
            captures: page.items.into_iter().map(convert::capture).collect(),
            next_page_token: page.next_token,
        }))
    }

    async fn delete_capture(
        &self,
        request: Request<DeleteCaptureRequest>,
    ) -> Result<Response<DeleteCaptureResponse>, Status> {
        self.app.delete_capture(&request.get_ref().name).await?;
        Ok(Response::new(DeleteCaptureResponse {}))
    }
}
