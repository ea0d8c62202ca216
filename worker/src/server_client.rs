//! Client of the server: typed calls, and errors that tell whether another attempt makes sense.

mod channel;
mod retry;
mod upload;

use std::time::Duration;

use bendtwin_core::{Category, Fault, Problem as _};
use bendtwin_proto::{
    fault,
    worker::v1::{
        CompleteFitRequest, DownloadRequest, EndIngestRequest, FailJobRequest, HeartbeatRequest,
        HeartbeatResponse, JobWrite, Lease, LeaseJobRequest, RegisterRequest, RegisterResponse,
        ReportJobRequest, ReportJobResponse, SaveCheckpointRequest, TwinWrite,
        lease_job_request::Kind, worker_link_client::WorkerLinkClient,
    },
    worker_key,
};
use bendtwin_tls::{Mutual, Reloaded, TlsError};
use bytes::Bytes;
use futures::Stream;
use tonic::{
    Request, Status, Streaming,
    metadata::AsciiMetadataValue,
    service::{Interceptor, interceptor::InterceptedService},
    transport::Channel,
};

pub(crate) use self::retry::Backoff;
use crate::Error;

/// Longest time of an ordinary call.
const CALL_TIMEOUT: Duration = Duration::from_secs(20);
/// Longest time of an upload of a checkpoint or a twin.
const UPLOAD_TIMEOUT: Duration = Duration::from_secs(300);
/// Longest reply that is accepted [bytes]; chunks are far smaller.
const MAX_MESSAGE: usize = 32 << 20;

/// Failure of a call about a job.
#[derive(Debug)]
pub(crate) enum CallError {
    /// Another worker has the job by now: stop at once, write nothing more.
    Stale,
    /// The server cannot be reached or asks to try again.
    Unavailable(Fault),
    /// The server refuses; trying again would not help.
    Refused(Fault),
}

impl CallError {
    /// The fault behind the failure.
    pub(crate) fn fault(self) -> Fault {
        match self {
            Self::Stale => Fault {
                category: Category::Aborted,
                reason: "STALE_LEASE".to_owned(),
                message: "another worker has the job".to_owned(),
            },
            Self::Unavailable(fault) | Self::Refused(fault) => fault,
        }
    }
}

impl From<Status> for CallError {
    fn from(status: Status) -> Self {
        if let Some(found) = TlsError::find(&status, "the server") {
            // Certificates are replaced while a worker waits.
            return Self::Unavailable(found.fault());
        }
        let fault = fault::fault(&status);
        match fault.category {
            Category::Aborted if fault.reason == "STALE_LEASE" => Self::Stale,
            // A transport that breaks in mid-call shows as unknown or internal, which the server
            // never sends for a reason that would not pass.
            Category::Unavailable
            | Category::DeadlineExceeded
            | Category::ResourceExhausted
            | Category::Aborted
            | Category::Cancelled
            | Category::Internal => Self::Unavailable(fault),
            _ => Self::Refused(fault),
        }
    }
}

/// The server as a worker sees it. Clones share one connection.
#[derive(Clone)]
pub(crate) struct ServerClient {
    client: WorkerLinkClient<InterceptedService<Channel, Credentials>>,
}

/// Interceptor that adds the worker token and the worker's key to every call.
#[derive(Clone)]
pub(crate) struct Credentials {
    token: AsciiMetadataValue,
    key: AsciiMetadataValue,
}

impl Interceptor for Credentials {
    fn call(&mut self, mut request: Request<()>) -> Result<Request<()>, Status> {
        request.metadata_mut().insert("authorization", self.token.clone());
        request.metadata_mut().insert(worker_key::METADATA, self.key.clone());
        Ok(request)
    }
}

impl ServerClient {
    /// Prepares the connection; it is made with the first call and again whenever it breaks. `key`
    /// is the one that the worker's id follows from.
    pub(crate) fn new(
        server: &str,
        token: &str,
        key: &str,
        tls: Option<&Reloaded<Mutual>>,
    ) -> Result<Self, Error> {
        let channel = channel::open(server, tls)?;
        let secret = |text: String| {
            let mut value = AsciiMetadataValue::try_from(text).map_err(|_| {
                let fault = "the worker token has characters that a header cannot carry";
                Error::Options(fault.to_owned())
            })?;
            value.set_sensitive(true);
            Ok::<_, Error>(value)
        };
        let credentials =
            Credentials { token: secret(format!("Bearer {token}"))?, key: secret(key.to_owned())? };
        let client = WorkerLinkClient::with_interceptor(channel, credentials)
            .max_decoding_message_size(MAX_MESSAGE);
        Ok(Self { client })
    }

    pub(crate) async fn register(
        &self,
        request: RegisterRequest,
    ) -> Result<RegisterResponse, CallError> {
        let call = within(request, CALL_TIMEOUT);
        Ok(self.client.clone().register(call).await?.into_inner())
    }

    pub(crate) async fn heartbeat(
        &self,
        request: HeartbeatRequest,
    ) -> Result<HeartbeatResponse, CallError> {
        let call = within(request, CALL_TIMEOUT);
        Ok(self.client.clone().heartbeat(call).await?.into_inner())
    }

    /// Waits for a job of a kind; none if there was none in time.
    pub(crate) async fn lease_job(
        &self,
        kind: Kind,
        worker: String,
        wait: Duration,
    ) -> Result<Option<Lease>, CallError> {
        let request = LeaseJobRequest { worker, wait_s: wait.as_secs_f64(), kind: kind.into() };
        let call = within(request, wait + CALL_TIMEOUT);
        Ok(self.client.clone().lease_job(call).await?.into_inner().lease)
    }

    pub(crate) async fn report_job(
        &self,
        request: ReportJobRequest,
    ) -> Result<ReportJobResponse, CallError> {
        let call = within(request, CALL_TIMEOUT);
        Ok(self.client.clone().report_job(call).await?.into_inner())
    }

    pub(crate) async fn fail_job(&self, request: FailJobRequest) -> Result<(), CallError> {
        let call = within(request, CALL_TIMEOUT);
        self.client.clone().fail_job(call).await?;
        Ok(())
    }

    /// Stores the result of an ingest, given as messages, and ends its job.
    pub(crate) async fn end_ingest(
        &self,
        messages: impl Stream<Item = EndIngestRequest> + Send + 'static,
    ) -> Result<(), CallError> {
        // Gigabytes, perhaps: what matters is that it moves, and the server sees to that.
        self.client.clone().end_ingest(Request::new(messages)).await?;
        Ok(())
    }

    /// Stores a checkpoint; returns once it is durable.
    pub(crate) async fn save_checkpoint(
        &self,
        job: JobWrite,
        content: Bytes,
    ) -> Result<(), CallError> {
        use bendtwin_proto::worker::v1::save_checkpoint_request::Part;
        let parts = upload::parts(
            SaveCheckpointRequest { part: Some(Part::Metadata(job)) },
            content,
            |chunk| SaveCheckpointRequest { part: Some(Part::Chunk(chunk)) },
        );
        self.client.clone().save_checkpoint(within(parts, UPLOAD_TIMEOUT)).await?;
        Ok(())
    }

    /// Stores a twin and ends its job; returns the twin's name.
    pub(crate) async fn complete_fit(
        &self,
        twin: TwinWrite,
        content: Bytes,
    ) -> Result<String, CallError> {
        use bendtwin_proto::worker::v1::complete_fit_request::Part;
        let parts = upload::parts(
            CompleteFitRequest { part: Some(Part::Metadata(twin)) },
            content,
            |chunk| CompleteFitRequest { part: Some(Part::Chunk(chunk)) },
        );
        let call = within(parts, UPLOAD_TIMEOUT);
        Ok(self.client.clone().complete_fit(call).await?.into_inner().twin)
    }

    /// The content of a capture, an observation, a twin or a job's checkpoint, in chunks.
    pub(crate) async fn download(&self, name: String) -> Result<Download, CallError> {
        let call = Request::new(DownloadRequest { name });
        Ok(Download(self.client.clone().download(call).await?.into_inner()))
    }
}

/// A download under way.
pub(crate) struct Download(Streaming<bendtwin_proto::worker::v1::DownloadResponse>);

impl Download {
    /// The next chunk; none at the end. A server that sends nothing for a while counts as gone.
    pub(crate) async fn next(&mut self) -> Result<Option<Bytes>, CallError> {
        match tokio::time::timeout(CALL_TIMEOUT, self.0.message()).await {
            Ok(message) => Ok(message?.map(|m| m.chunk)),
            Err(_) => Err(Status::deadline_exceeded("the download stalled").into()),
        }
    }
}

fn within<T>(message: T, timeout: Duration) -> Request<T> {
    let mut request = Request::new(message);
    request.set_timeout(timeout);
    request
}
