//! Typed calls to a server, over one gRPC channel that survives its restarts.

use std::time::Duration;

use bendtwin_proto::v1::{
    CancelFitRequest, Capture, CaptureMetadata, CreateCaptureRequest, CreateFitRequest,
    CreateTwinRequest, ExportTwinRequest, Fit, GetFitRequest, GetTwinRequest, ListCapturesRequest,
    ListFitsRequest, ListTwinsRequest, ListWorkersRequest, RollOutRequest, RollOutResponse, Twin,
    TwinMetadata, Worker, capture_service_client::CaptureServiceClient, create_capture_request,
    create_twin_request, fit_service_client::FitServiceClient, job::State,
    rollout_service_client::RolloutServiceClient, session_service_client::SessionServiceClient,
    twin_service_client::TwinServiceClient, worker_service_client::WorkerServiceClient,
};
use bytes::Bytes;
use tonic::{
    Status,
    transport::{Channel, Endpoint},
};

use crate::waiting::until;

const CHUNK: usize = 256 * 1024;

/// A server's API.
#[derive(Clone, Debug)]
pub struct Api {
    /// The channel; it connects again by itself.
    pub channel: Channel,
}

impl Api {
    /// The API at `host:port`.
    pub fn new(address: &str) -> Self {
        let endpoint = Endpoint::from_shared(format!("http://{address}")).unwrap();
        Self { channel: endpoint.tcp_nodelay(true).connect_lazy() }
    }

    /// Captures.
    pub fn captures(&self) -> CaptureServiceClient<Channel> {
        CaptureServiceClient::new(self.channel.clone())
    }

    /// Fits.
    pub fn fits(&self) -> FitServiceClient<Channel> {
        FitServiceClient::new(self.channel.clone())
    }

    /// Twins.
    pub fn twins(&self) -> TwinServiceClient<Channel> {
        TwinServiceClient::new(self.channel.clone())
    }

    /// Rollouts, of messages of up to a gibibyte.
    pub fn rollouts(&self) -> RolloutServiceClient<Channel> {
        RolloutServiceClient::new(self.channel.clone())
            .max_decoding_message_size(1 << 30)
            .max_encoding_message_size(1 << 30)
    }

    /// Sessions, with states of up to a gibibyte.
    pub fn sessions(&self) -> SessionServiceClient<Channel> {
        SessionServiceClient::new(self.channel.clone()).max_decoding_message_size(1 << 30)
    }

    /// Workers.
    pub fn workers(&self) -> WorkerServiceClient<Channel> {
        WorkerServiceClient::new(self.channel.clone())
    }

    /// Uploads a capture archive.
    pub async fn upload(&self, archive: &Bytes, request_id: &str) -> Result<Capture, Status> {
        self.upload_as(archive, "e2e", request_id).await
    }

    /// Uploads a capture archive under a name.
    pub async fn upload_as(
        &self,
        archive: &Bytes,
        display_name: &str,
        request_id: &str,
    ) -> Result<Capture, Status> {
        use create_capture_request::Part;
        let metadata = CaptureMetadata {
            display_name: display_name.to_owned(),
            request_id: request_id.to_owned(),
            ..CaptureMetadata::default()
        };
        let parts = std::iter::once(Part::Metadata(metadata))
            .chain(chunks(archive).map(Part::Chunk))
            .map(|part| CreateCaptureRequest { part: Some(part) });
        let messages: Vec<_> = parts.collect();
        let reply = self.captures().create_capture(futures::stream::iter(messages)).await?;
        Ok(reply.into_inner().capture.unwrap())
    }

    /// Stores a twin file.
    pub async fn import(&self, file: &Bytes) -> Result<Twin, Status> {
        use create_twin_request::Part;
        let metadata = TwinMetadata { display_name: "e2e".to_owned(), ..TwinMetadata::default() };
        let parts = std::iter::once(Part::Metadata(metadata))
            .chain(chunks(file).map(Part::Chunk))
            .map(|part| CreateTwinRequest { part: Some(part) });
        let messages: Vec<_> = parts.collect();
        Ok(self.twins().create_twin(futures::stream::iter(messages)).await?.into_inner())
    }

    /// The content of a twin file.
    pub async fn export(&self, name: &str) -> Result<Bytes, Status> {
        let request = ExportTwinRequest { name: name.to_owned() };
        let mut parts = self.twins().export_twin(request).await?.into_inner();
        let mut file = Vec::new();
        while let Some(part) = parts.message().await? {
            file.extend_from_slice(&part.chunk);
        }
        Ok(file.into())
    }

    /// Starts a fit.
    pub async fn fit(&self, capture: &str, settings: &str, priority: i32) -> Result<Fit, Status> {
        let request = CreateFitRequest {
            capture: capture.to_owned(),
            settings_json: settings.to_owned(),
            priority,
            ..CreateFitRequest::default()
        };
        Ok(self.fits().create_fit(request).await?.into_inner())
    }

    /// A fit by its name.
    pub async fn get_fit(&self, name: &str) -> Result<Fit, Status> {
        Ok(self.fits().get_fit(GetFitRequest { name: name.to_owned() }).await?.into_inner())
    }

    /// Asks a fit to stop.
    pub async fn cancel(&self, name: &str) -> Result<Fit, Status> {
        Ok(self.fits().cancel_fit(CancelFitRequest { name: name.to_owned() }).await?.into_inner())
    }

    /// A twin by its name.
    pub async fn get_twin(&self, name: &str) -> Result<Twin, Status> {
        Ok(self.twins().get_twin(GetTwinRequest { name: name.to_owned() }).await?.into_inner())
    }

    /// A rollout.
    pub async fn roll_out(&self, request: RollOutRequest) -> Result<RollOutResponse, Status> {
        Ok(self.rollouts().roll_out(request).await?.into_inner())
    }

    /// The newest thousand captures.
    pub async fn list_captures(&self) -> Result<Vec<Capture>, Status> {
        let request = ListCapturesRequest { page_size: 1000, ..Default::default() };
        Ok(self.captures().list_captures(request).await?.into_inner().captures)
    }

    /// The newest thousand fits.
    pub async fn list_fits(&self) -> Result<Vec<Fit>, Status> {
        let request = ListFitsRequest { page_size: 1000, ..Default::default() };
        Ok(self.fits().list_fits(request).await?.into_inner().fits)
    }

    /// The newest thousand twins.
    pub async fn list_twins(&self) -> Result<Vec<Twin>, Status> {
        let request = ListTwinsRequest { page_size: 1000, ..Default::default() };
        Ok(self.twins().list_twins(request).await?.into_inner().twins)
    }

    /// The workers that are connected.
    pub async fn list_workers(&self) -> Result<Vec<Worker>, Status> {
        let request = ListWorkersRequest { page_size: 1000, ..Default::default() };
        Ok(self.workers().list_workers(request).await?.into_inner().workers)
    }

    /// Waits until a fit is in the wanted state; failed calls are repeated.
    pub async fn fit_when(
        &self,
        name: &str,
        what: &str,
        deadline: Duration,
        wanted: impl Fn(&Fit) -> bool,
    ) -> Fit {
        until(&format!("{name} to be {what}"), deadline, async || {
            self.get_fit(name).await.ok().filter(|fit| wanted(fit))
        })
        .await
    }

    /// Waits until a fit has succeeded; fails the test as soon as it ends otherwise.
    pub async fn succeeded(&self, name: &str, deadline: Duration) -> Fit {
        let fit = self.fit_when(name, "over", deadline, has_ended).await;
        assert_eq!(fit.state(), State::Succeeded, "{:?}", fit.job);
        fit
    }
}

/// True if the state of a fit is final.
pub fn has_ended(fit: &Fit) -> bool {
    !matches!(fit.state(), State::Queued | State::Running)
}

/// The worker that runs a fit; empty if none does.
pub fn worker(fit: &Fit) -> &str {
    fit.job.as_ref().map_or("", |job| &job.worker)
}

/// Progress of a fit, 0..=1.
pub fn fraction(fit: &Fit) -> f64 {
    let progress = fit.job.as_ref().and_then(|job| job.progress.as_ref());
    progress.map_or(0.0, |p| p.fraction)
}

fn chunks(content: &Bytes) -> impl Iterator<Item = Bytes> + '_ {
    (0..content.len()).step_by(CHUNK).map(|at| content.slice(at..content.len().min(at + CHUNK)))
}
