//! `bendtwin.worker.v1.WorkerLink`: calls of workers to the server. Their token has been checked
//! before ([`TokenCheck`](super::token::TokenCheck)); here every worker that a call names is
//! compared with the key that the call shows.

use std::time::Duration;

use bendtwin_core::{Category, Fault};
use bendtwin_proto::worker::v1::{
    CompleteFitRequest, CompleteFitResponse, DownloadRequest, DownloadResponse, EndIngestRequest,
    EndIngestResponse, FailJobRequest, FailJobResponse, HeartbeatRequest, HeartbeatResponse,
    JobWrite, Lease as LeaseMessage, LeaseJobRequest, LeaseJobResponse, LeasedSupplement,
    LeaveRequest, LeaveResponse, RegisterRequest, RegisterResponse, ReportJobRequest,
    ReportJobResponse, SaveCheckpointRequest, SaveCheckpointResponse, complete_fit_request,
    end_ingest_request, fail_job_request::End, lease_job_request, save_checkpoint_request,
    worker_link_server::WorkerLink,
};
use bendtwin_store::{AttemptEnd, Kind, Lease, NewWorker, Supplement, TwinFacts};
use futures::StreamExt;
use tonic::{Request, Response, Status, Streaming};

use super::{
    Api, Reply, chunks, convert,
    token::{self, Credentials},
    upload,
};
use crate::{
    app::{self, Error, IngestPart, IngestUpload, LeasedJob, News, Offer},
    http::root_service::PeerCertificate,
};

/// The lease under which a worker writes.
fn lease(shown: &Credentials, worker: &str, job: &str, epoch: u64) -> app::Result<Lease> {
    Ok(Lease { job: app::name_of_worker(job)?, epoch, worker: shown.worker(worker)? })
}

fn lease_of(shown: &Credentials, write: &JobWrite) -> app::Result<Lease> {
    lease(shown, &write.worker, &write.job, write.epoch)
}

fn lease_message(leased: LeasedJob, brief: bool) -> LeaseMessage {
    let LeasedJob { job, capture, observation, supplements, masks } = leased;
    let supplement = |supplement: Supplement| LeasedSupplement {
        kind: supplement.kind.to_string(),
        digest: supplement.digest.to_hex().to_string(),
    };
    LeaseMessage {
        job: job.id.to_string(),
        epoch: job.lease_epoch,
        capture: capture.id.to_string(),
        capture_display_name: capture.labels.display_name,
        capture_digest: capture.digest.to_hex().to_string(),
        settings_json: job.settings,
        has_checkpoint: job.checkpoint.is_some(),
        checkpoint_digest: job.checkpoint.map(|d| d.to_hex().to_string()).unwrap_or_default(),
        request_id: job.request_id.unwrap_or_default(),
        trace_parent: job.trace_parent.unwrap_or_default(),
        observation_digest: observation.map(|o| o.digest.to_hex().to_string()).unwrap_or_default(),
        supplements: supplements.into_iter().map(supplement).collect(),
        masks_digest: masks.map(|d| d.to_hex().to_string()).unwrap_or_default(),
        brief,
    }
}

#[tonic::async_trait]
impl WorkerLink for Api {
    async fn register(
        &self,
        request: Request<RegisterRequest>,
    ) -> Result<Response<RegisterResponse>, Status> {
        let shown = token::shown(&request)?;
        let certificate = request.extensions().get::<PeerCertificate>().cloned();
        let r = request.into_inner();
        if let Some(PeerCertificate(certificate)) = certificate {
            // Its rollouts would go over the network in the clear.
            if !r.endpoint.starts_with("https://") {
                let fault = "must be https, as that of every worker with a certificate";
                return Err(Error::invalid("endpoint", fault).into());
            }
            tracing::info!(
                worker = r.worker,
                certificate = certificate.name(),
                "worker identified"
            );
        }
        let short = |text: String| text.chars().filter(|c| !c.is_control()).take(200).collect();
        let new = NewWorker {
            id: shown.worker(&r.worker)?,
            endpoint: r.endpoint,
            backend: short(r.backend),
            device: short(r.device),
            build: short(r.build),
            lanes: r.lanes,
            labels: r.labels,
            // The use case knows whose processes are its own.
            server: None,
        };
        self.app.register_worker(new, shown.bearer, &shown.token).await?;
        Ok(Response::new(RegisterResponse {
            heartbeat_interval_s: self.app.options().heartbeat_interval_s,
            lease_s: self.app.options().lease_s,
            rollout_limits: Some((&self.app.options().limits.rollout).into()),
        }))
    }

    async fn heartbeat(
        &self,
        request: Request<HeartbeatRequest>,
    ) -> Result<Response<HeartbeatResponse>, Status> {
        let shown = token::shown(&request)?;
        let sent = request.into_inner();
        let worker = shown.worker(&sent.worker)?;
        let drain = self.app.heartbeat(worker, shown.bearer, sent.try_into()?).await?;
        Ok(Response::new(HeartbeatResponse { drain }))
    }

    async fn lease_job(
        &self,
        request: Request<LeaseJobRequest>,
    ) -> Result<Response<LeaseJobResponse>, Status> {
        let shown = token::shown(&request)?;
        let r = request.into_inner();
        let worker = shown.worker(&r.worker)?;
        let wait = Duration::try_from_secs_f64(r.wait_s)
            .map_err(|_| Error::invalid("wait_s", "is negative, too large or not a number"))?;
        let kind = match r.kind() {
            lease_job_request::Kind::Ingest => Kind::Ingest,
            lease_job_request::Kind::Fit => Kind::Fit,
            lease_job_request::Kind::Unspecified => {
                return Err(Error::invalid("kind", "is unknown to this server").into());
            }
        };
        let offer = self.app.lease_job(kind, worker, wait, r.brief).await?;
        Ok(Response::new(match offer {
            Offer::Job(leased) => {
                let lease = lease_message(*leased, r.brief);
                LeaseJobResponse { lease: Some(lease), drain: false }
            }
            Offer::Nothing => LeaseJobResponse::default(),
            Offer::Drain => LeaseJobResponse { lease: None, drain: true },
        }))
    }

    async fn report_job(
        &self,
        request: Request<ReportJobRequest>,
    ) -> Result<Response<ReportJobResponse>, Status> {
        let shown = token::shown(&request)?;
        let r = request.into_inner();
        let lease = lease(&shown, &r.worker, &r.job, r.epoch)?;
        let progress = r.progress.map(convert::read_progress).transpose()?;
        let losses = convert::read_losses(r.losses)?;
        let news = News { progress, losses, preview: r.preview };
        let reported = self.app.report_job(lease, &news).await?;
        Ok(Response::new(ReportJobResponse {
            cancel_requested: reported.cancel_requested,
            make_way_within_s: reported.make_way_within.map(|within| within.as_secs_f64()),
        }))
    }

    async fn save_checkpoint(
        &self,
        request: Request<Streaming<SaveCheckpointRequest>>,
    ) -> Result<Response<SaveCheckpointResponse>, Status> {
        let shown = token::shown(&request)?;
        let (job, body) = upload::open(request.into_inner(), |m| match m.part {
            Some(save_checkpoint_request::Part::Metadata(m)) => upload::Part::Metadata(m),
            Some(save_checkpoint_request::Part::Chunk(c)) => upload::Part::Chunk(c),
            None => upload::Part::Neither,
        })
        .await?;
        self.app.save_checkpoint(lease_of(&shown, &job)?, &job.digest, body).await?;
        Ok(Response::new(SaveCheckpointResponse {}))
    }

    async fn complete_fit(
        &self,
        request: Request<Streaming<CompleteFitRequest>>,
    ) -> Result<Response<CompleteFitResponse>, Status> {
        let shown = token::shown(&request)?;
        let (twin, body) = upload::open(request.into_inner(), |m| match m.part {
            Some(complete_fit_request::Part::Metadata(m)) => upload::Part::Metadata(m),
            Some(complete_fit_request::Part::Chunk(c)) => upload::Part::Chunk(c),
            None => upload::Part::Neither,
        })
        .await?;
        let job = twin.job.unwrap_or_default();
        let facts = TwinFacts {
            node_count: twin.node_count,
            spring_count: twin.spring_count,
            triplet_count: twin.triplet_count,
            control_count: twin.control_count,
            fps: twin.fps,
            substeps: twin.substeps,
            quality: twin.quality_json,
            mass_kg: None,
            skin_point_count: None,
        };
        let lease = lease_of(&shown, &job)?;
        let twin = self.app.complete_fit(lease, facts, &job.digest, body).await?;
        Ok(Response::new(CompleteFitResponse { twin: twin.to_string() }))
    }

    async fn end_ingest(
        &self,
        request: Request<Streaming<EndIngestRequest>>,
    ) -> Result<Response<EndIngestResponse>, Status> {
        use end_ingest_request::Part;
        let shown = token::shown(&request)?;
        let mut messages = request.into_inner();
        let broken = |status: Status| Error::UploadBroken(status.message().to_owned());
        let first = messages.message().await.map_err(broken)?;
        let Some(Part::Metadata(made)) = first.and_then(|m| m.part) else {
            let fault = "must come in the first message of an upload";
            return Err(Error::invalid("metadata", fault).into());
        };
        let body = messages.map(move |message| match message.map(|m| m.part) {
            Ok(Some(Part::Observation(chunk))) => Ok(IngestPart::Observation(chunk)),
            Ok(Some(Part::Playback(chunk))) => Ok(IngestPart::Playback(chunk)),
            Ok(Some(Part::Masks(chunk))) => Ok(IngestPart::Masks(chunk)),
            Ok(Some(Part::Report(chunk))) => Ok(IngestPart::Report(chunk)),
            Ok(Some(Part::Page(chunk))) => Ok(IngestPart::Page(chunk)),
            Ok(_) => Err(Error::invalid("part", "must be in every message after the first")),
            Err(status) => Err(broken(status)),
        });
        let lease = lease_of(&shown, &made.job.unwrap_or_default())?;
        let upload = IngestUpload {
            verdict: made.verdict,
            observation_digest: made.observation_digest,
            playback_digest: made.playback_digest,
            masks_digest: made.masks_digest,
            report_digest: made.report_digest,
            page_digest: made.page_digest,
            fault: made.fault.as_ref().map(Fault::from),
            masks_only: made.masks_only,
            body: body.boxed(),
        };
        self.app.end_ingest(lease, upload).await?;
        Ok(Response::new(EndIngestResponse {}))
    }

    async fn fail_job(
        &self,
        request: Request<FailJobRequest>,
    ) -> Result<Response<FailJobResponse>, Status> {
        let shown = token::shown(&request)?;
        let r = request.into_inner();
        let lease = lease(&shown, &r.worker, &r.job, r.epoch)?;
        let fault = r.fault.as_ref().map_or_else(
            || Fault {
                category: Category::Internal,
                reason: "UNSAID".to_owned(),
                message: "the worker did not say why it failed".to_owned(),
            },
            Fault::from,
        );
        let end = match r.end() {
            End::Released => AttemptEnd::Released,
            End::Cancelled => AttemptEnd::Cancelled,
            End::FailedForGood => AttemptEnd::FailedForGood(fault),
            End::Failed => AttemptEnd::Failed(fault),
            End::Interrupted => AttemptEnd::Interrupted(fault),
            End::Outgrown => AttemptEnd::Outgrown,
            End::Unspecified => {
                return Err(Error::invalid("end", "is unknown to this server").into());
            }
        };
        self.app.end_attempt(lease, end).await?;
        Ok(Response::new(FailJobResponse {}))
    }

    async fn leave(
        &self,
        request: Request<LeaveRequest>,
    ) -> Result<Response<LeaveResponse>, Status> {
        let shown = token::shown(&request)?;
        let worker = shown.worker(&request.get_ref().worker)?;
        self.app.worker_left(worker).await?;
        Ok(Response::new(LeaveResponse {}))
    }

    type DownloadStream = Reply<DownloadResponse>;

    async fn download(
        &self,
        request: Request<DownloadRequest>,
    ) -> Result<Response<Self::DownloadStream>, Status> {
        let shown = token::shown(&request)?;
        let what = request.get_ref().name.parse()?;
        let worker = self.app.find_worker(|worker| shown.is(worker)).await?;
        let content = self.app.download(worker, what).await?;
        Ok(Response::new(chunks(content, |chunk| DownloadResponse { chunk })))
    }
}
