//! Client of the servers: typed calls, and errors that say whether another attempt makes sense. Of
//! several servers one is called until it is gone, then the next.

mod channel;
mod links;
mod retry;
mod upload;

use std::time::Duration;

use bendtwin_core::{Category, Fault, Problem as _};
use bendtwin_proto::{
    fault,
    worker::v1::{
        CompleteFitRequest, DownloadRequest, EndIngestRequest, FailJobRequest, HeartbeatRequest,
        HeartbeatResponse, JobWrite, LeaseJobRequest, LeaseJobResponse, LeaveRequest,
        RegisterRequest, RegisterResponse, ReportJobRequest, ReportJobResponse,
        SaveCheckpointRequest, TwinWrite, lease_job_request::Kind,
    },
};
use bendtwin_tls::{Mutual, Reloaded, TlsError};
use bytes::Bytes;
use futures::Stream;
use tonic::{Request, Status, Streaming};

use self::links::Links;
pub(crate) use self::retry::Backoff;
use crate::Error;

/// Longest time of an ordinary call.
const CALL_TIMEOUT: Duration = Duration::from_secs(20);
/// Longest time of an upload of a checkpoint or a twin.
const UPLOAD_TIMEOUT: Duration = Duration::from_secs(300);

/// Failure of a call about a job.
#[derive(Debug)]
pub(crate) enum CallError {
    /// Another worker has the job by now: stop immediately, write nothing more.
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

/// The servers as a worker sees them. Clones share the connections.
#[derive(Clone)]
pub(crate) struct ServerClient {
    links: Links,
}

impl ServerClient {
    /// Prepares the connections; they are made with the first calls and again whenever they break.
    /// `key` is the one that the worker's id follows from.
    pub(crate) fn new(
        servers: &[String],
        token: &str,
        key: &str,
        tls: Option<&Reloaded<Mutual>>,
    ) -> Result<Self, Error> {
        Ok(Self { links: Links::new(servers, token, key, tls)? })
    }

    pub(crate) async fn register(
        &self,
        request: RegisterRequest,
    ) -> Result<RegisterResponse, CallError> {
        let call = || within(request.clone(), CALL_TIMEOUT);
        self.links
            .call(|mut link| {
                let call = call();
                async move { link.register(call).await }
            })
            .await
    }

    pub(crate) async fn heartbeat(
        &self,
        request: HeartbeatRequest,
    ) -> Result<HeartbeatResponse, CallError> {
        let call = || within(request.clone(), CALL_TIMEOUT);
        self.links
            .call(|mut link| {
                let call = call();
                async move { link.heartbeat(call).await }
            })
            .await
    }

    /// Waits for a job of a kind, or for a brief one; `None` without a job in time, or if the worker is to
    /// end.
    pub(crate) async fn lease_job(
        &self,
        kind: Kind,
        worker: String,
        wait: Duration,
        brief: bool,
    ) -> Result<LeaseJobResponse, CallError> {
        let wait_s = wait.as_secs_f64();
        let request = LeaseJobRequest { worker, wait_s, kind: kind.into(), brief };
        let call = || within(request.clone(), wait + CALL_TIMEOUT);
        self.links
            .call(|mut link| {
                let call = call();
                async move { link.lease_job(call).await }
            })
            .await
    }

    pub(crate) async fn report_job(
        &self,
        request: ReportJobRequest,
    ) -> Result<ReportJobResponse, CallError> {
        let call = || within(request.clone(), CALL_TIMEOUT);
        self.links
            .call(|mut link| {
                let call = call();
                async move { link.report_job(call).await }
            })
            .await
    }

    pub(crate) async fn fail_job(&self, request: FailJobRequest) -> Result<(), CallError> {
        let call = || within(request.clone(), CALL_TIMEOUT);
        self.links
            .call(|mut link| {
                let call = call();
                async move { link.fail_job(call).await }
            })
            .await?;
        Ok(())
    }

    /// Says that the worker ends.
    pub(crate) async fn leave(&self, worker: String) -> Result<(), CallError> {
        let request = LeaveRequest { worker };
        let call = || within(request.clone(), CALL_TIMEOUT);
        self.links
            .call(|mut link| {
                let call = call();
                async move { link.leave(call).await }
            })
            .await?;
        Ok(())
    }

    /// Stores the result of an ingest, given as messages, and ends its job.
    pub(crate) async fn end_ingest(
        &self,
        messages: impl Stream<Item = EndIngestRequest> + Send + 'static,
    ) -> Result<(), CallError> {
        // Gigabytes, perhaps: what matters is that it moves, and the server sees to that.
        self.links
            .call_once(|mut link| async move { link.end_ingest(Request::new(messages)).await })
            .await?;
        Ok(())
    }

    /// Stores a checkpoint; returns once it is durable.
    pub(crate) async fn save_checkpoint(
        &self,
        job: JobWrite,
        content: Bytes,
    ) -> Result<(), CallError> {
        use bendtwin_proto::worker::v1::save_checkpoint_request::Part;
        let parts = || {
            let metadata = SaveCheckpointRequest { part: Some(Part::Metadata(job.clone())) };
            upload::parts(metadata, content.clone(), |chunk| SaveCheckpointRequest {
                part: Some(Part::Chunk(chunk)),
            })
        };
        let call = || within(parts(), UPLOAD_TIMEOUT);
        self.links
            .call(|mut link| {
                let call = call();
                async move { link.save_checkpoint(call).await }
            })
            .await?;
        Ok(())
    }

    /// Stores a twin and ends its job; returns the twin's name.
    pub(crate) async fn complete_fit(
        &self,
        twin: TwinWrite,
        content: Bytes,
    ) -> Result<String, CallError> {
        use bendtwin_proto::worker::v1::complete_fit_request::Part;
        let parts = || {
            let metadata = CompleteFitRequest { part: Some(Part::Metadata(twin.clone())) };
            upload::parts(metadata, content.clone(), |chunk| CompleteFitRequest {
                part: Some(Part::Chunk(chunk)),
            })
        };
        let call = || within(parts(), UPLOAD_TIMEOUT);
        let completed = self.links.call(|mut link| {
            let call = call();
            async move { link.complete_fit(call).await }
        });
        Ok(completed.await?.twin)
    }

    /// The content of a capture, an observation, a twin or a job's checkpoint, in chunks.
    pub(crate) async fn download(&self, name: String) -> Result<Download, CallError> {
        let call = || Request::new(DownloadRequest { name: name.clone() });
        let download = self.links.call(|mut link| {
            let call = call();
            async move { link.download(call).await }
        });
        Ok(Download(download.await?))
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
