//! `bendtwin.v1.CaptureService`.

use bendtwin_proto::v1::{
    AddSupplementRequest, AddSupplementResponse, CancelIngestRequest, Capture,
    CreateCaptureRequest, CreateCaptureResponse, DeleteCaptureRequest, DeleteCaptureResponse,
    DeleteSupplementRequest, DeleteSupplementResponse, ExportMasksRequest, ExportMasksResponse,
    ExportObservationRequest, ExportObservationResponse, ExportSupplementRequest,
    ExportSupplementResponse, GetCaptureReportRequest, GetCaptureReportResponse, GetCaptureRequest,
    IngestCaptureRequest, ListCapturesRequest, ListCapturesResponse, UpdateCaptureRequest,
    WatchIngestRequest, add_supplement_request, capture_service_server::CaptureService,
    create_capture_request, get_capture_report_request::Format,
};
use tonic::{Request, Response, Status, Streaming};

use super::{Api, Reply, chunks, convert, reply, upload};
use crate::app::requirements_of;

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
        let capture = convert::capture(self.app.create_capture(metadata, body).await?);
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
        let page = self.app.captures(request.into_inner()).await?;
        Ok(Response::new(ListCapturesResponse {
            captures: page.items.into_iter().map(convert::capture).collect(),
            next_page_token: page.next_token,
            total_size: page.total,
        }))
    }

    async fn update_capture(
        &self,
        request: Request<UpdateCaptureRequest>,
    ) -> Result<Response<Capture>, Status> {
        let capture = self.app.update_capture(request.into_inner()).await?;
        Ok(Response::new(convert::capture(capture)))
    }

    async fn delete_capture(
        &self,
        request: Request<DeleteCaptureRequest>,
    ) -> Result<Response<DeleteCaptureResponse>, Status> {
        let r = request.into_inner();
        self.app.delete_capture(&r.name, r.purge).await?;
        Ok(Response::new(DeleteCaptureResponse {}))
    }
    async fn ingest_capture(
        &self,
        request: Request<IngestCaptureRequest>,
    ) -> Result<Response<Capture>, Status> {
        let r = request.into_inner();
        let requirements = requirements_of(r.requirements);
        let capture =
            self.app.ingest_capture(&r.name, &r.settings_json, requirements, r.request_id).await?;
        Ok(Response::new(convert::capture(capture)))
    }

    async fn cancel_ingest(
        &self,
        request: Request<CancelIngestRequest>,
    ) -> Result<Response<Capture>, Status> {
        let capture = self.app.cancel_ingest(&request.get_ref().name).await?;
        Ok(Response::new(convert::capture(capture)))
    }

    type WatchIngestStream = Reply<Capture>;

    async fn watch_ingest(
        &self,
        request: Request<WatchIngestRequest>,
    ) -> Result<Response<Self::WatchIngestStream>, Status> {
        let r = request.into_inner();
        let captures = self.app.watch_ingest(&r.name, r.after_revision).await?;
        Ok(Response::new(reply(captures, convert::capture)))
    }

    type GetCaptureReportStream = Reply<GetCaptureReportResponse>;

    async fn get_capture_report(
        &self,
        request: Request<GetCaptureReportRequest>,
    ) -> Result<Response<Self::GetCaptureReportStream>, Status> {
        let r = request.into_inner();
        let content = self.app.capture_report(&r.name, r.format() == Format::Html).await?;
        Ok(Response::new(chunks(content, |chunk| GetCaptureReportResponse { chunk })))
    }

    type ExportObservationStream = Reply<ExportObservationResponse>;

    async fn export_observation(
        &self,
        request: Request<ExportObservationRequest>,
    ) -> Result<Response<Self::ExportObservationStream>, Status> {
        let (.., content) = self.app.observation(&request.get_ref().name).await?;
        Ok(Response::new(chunks(content, |chunk| ExportObservationResponse { chunk })))
    }

    type ExportMasksStream = Reply<ExportMasksResponse>;

    async fn export_masks(
        &self,
        request: Request<ExportMasksRequest>,
    ) -> Result<Response<Self::ExportMasksStream>, Status> {
        let (.., content) = self.app.masks(&request.get_ref().name).await?;
        Ok(Response::new(chunks(content, |chunk| ExportMasksResponse { chunk })))
    }

    async fn add_supplement(
        &self,
        request: Request<Streaming<AddSupplementRequest>>,
    ) -> Result<Response<AddSupplementResponse>, Status> {
        let (metadata, body) = upload::open(request.into_inner(), |m| match m.part {
            Some(add_supplement_request::Part::Metadata(m)) => upload::Part::Metadata(m),
            Some(add_supplement_request::Part::Chunk(c)) => upload::Part::Chunk(c),
            None => upload::Part::Neither,
        })
        .await?;
        let capture = convert::capture(self.app.add_supplement(metadata, body).await?);
        Ok(Response::new(AddSupplementResponse { capture: Some(capture) }))
    }

    type ExportSupplementStream = Reply<ExportSupplementResponse>;

    async fn export_supplement(
        &self,
        request: Request<ExportSupplementRequest>,
    ) -> Result<Response<Self::ExportSupplementStream>, Status> {
        let r = request.get_ref();
        let (.., content) = self.app.supplement(&r.name, &r.kind).await?;
        Ok(Response::new(chunks(content, |chunk| ExportSupplementResponse { chunk })))
    }

    async fn delete_supplement(
        &self,
        request: Request<DeleteSupplementRequest>,
    ) -> Result<Response<DeleteSupplementResponse>, Status> {
        let r = request.get_ref();
        self.app.delete_supplement(&r.name, &r.kind).await?;
        Ok(Response::new(DeleteSupplementResponse {}))
    }
}
