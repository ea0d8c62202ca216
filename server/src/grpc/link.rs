//! `bendtwin.worker.v1.WorkerLink`: what workers ask of the server. Every
//! method checks the worker token first.

use std::time::Duration;

use bendtwin_core::{Category, Fault, ids::WorkerId};
use bendtwin_proto::worker::v1::{
    BeatRequest, BeatResponse, CompleteFitRequest, CompleteFitResponse, DownloadRequest,
    DownloadResponse, FailFitRequest, FailFitResponse, JobWrite, Lease as LeaseMessage,
    LeaseFitRequest, LeaseFitResponse, RegisterRequest, RegisterResponse, ReportFitRequest,
    ReportFitResponse, SaveCheckpointRequest, SaveCheckpointResponse, complete_fit_request,
    save_checkpoint_request, worker_link_server::WorkerLink,
};
use bendtwin_store::{AttemptEnd, Lease, NewWorker, TwinFacts};
use tonic::{Request, Response, Status, Streaming, metadata::MetadataMap};

use super::{Api, Reply, chunks, convert, upload};
use crate::{
    app::{self, Attempt, Error},
    dispatch::{Beat, Memory},
    tokens::Bearer,
};

impl Api {
    /// The token that a call shows, and whose it is.
    fn bearer<'m>(&self, metadata: &'m MetadataMap) -> app::Result<(Bearer, &'m str)> {
        let token = metadata
            .get("authorization")
            .and_then(|v| v.to_str().ok())
            .and_then(|v| v.strip_prefix("Bearer "))
            .ok_or(Error::BadToken)?;
        Ok((self.app.tokens.bearer(token).ok_or(Error::BadToken)?, token))
    }
}

fn attempt(worker: &str, fit: &str, epoch: u64) -> app::Result<Attempt> {
    let lease = Lease { fit: app::name(fit)?, epoch };
    Ok(Attempt { worker: app::name(worker)?, lease })
}

fn attempt_of(job: &JobWrite) -> app::Result<Attempt> {
    attempt(&job.worker, &job.fit, job.epoch)
}

#[tonic::async_trait]
impl WorkerLink for Api {
    async fn register(
        &self,
        request: Request<RegisterRequest>,
    ) -> Result<Response<RegisterResponse>, Status> {
        let (bearer, token) = self.bearer(request.metadata())?;
        let token = token.to_owned();
        let r = request.into_inner();
        let short = |text: String| text.chars().filter(|c| !c.is_control()).take(200).collect();
        let new = NewWorker {
            id: app::name(&r.worker)?,
            endpoint: r.endpoint,
            backend: short(r.backend),
            device: short(r.device),
            build: short(r.build),
            lanes: r.lanes,
            supervised: matches!(bearer, Bearer::Child(_)),
        };
        self.app.register_worker(new, bearer, &token).await?;
        Ok(Response::new(RegisterResponse {
            beat_interval_s: self.app.options.beat_interval_s,
            lease_s: self.app.options.lease_s,
        }))
    }

    async fn beat(&self, request: Request<BeatRequest>) -> Result<Response<BeatResponse>, Status> {
        let (bearer, _) = self.bearer(request.metadata())?;
        // Workers that others started outlive a restart of the server.
        let drain = self.app.stopping.is_cancelled() && matches!(bearer, Bearer::Child(_));
        let r = request.into_inner();
        let worker: WorkerId = app::name(&r.worker)?;
        let warm = r.warm_twins.iter().map(|t| app::name(t)).collect::<app::Result<_>>()?;
        let memory = (r.memory_total_bytes > 0)
            .then_some(Memory { used: r.memory_used_bytes, total: r.memory_total_bytes });
        let beat = Beat { warm, in_flight: r.rollouts_in_flight, memory };
        if !self.app.dispatch.beat(worker, beat) {
            return Err(Error::WorkerUnknown(worker.to_string()).into());
        }
        Ok(Response::new(BeatResponse { drain }))
    }

    async fn lease_fit(
        &self,
        request: Request<LeaseFitRequest>,
    ) -> Result<Response<LeaseFitResponse>, Status> {
        self.bearer(request.metadata())?;
        let r = request.into_inner();
        let wait = Duration::try_from_secs_f64(r.wait_s)
            .map_err(|_| Error::invalid("wait_s", "is negative, too large or not a number"))?;
        let leased = self.app.lease_fit(app::name(&r.worker)?, wait).await?;
        let lease = leased.map(|(fit, capture)| LeaseMessage {
            fit: fit.id.to_string(),
            epoch: fit.lease_epoch,
            capture: capture.id.to_string(),
            capture_display_name: capture.display_name,
            capture_digest: capture.digest.to_hex().to_string(),
            settings_json: fit.settings,
            has_checkpoint: fit.checkpoint.is_some(),
            request_id: fit.request_id.unwrap_or_default(),
            trace_parent: fit.trace_parent.unwrap_or_default(),
        });
        Ok(Response::new(LeaseFitResponse { lease }))
    }

    async fn report_fit(
        &self,
        request: Request<ReportFitRequest>,
    ) -> Result<Response<ReportFitResponse>, Status> {
        self.bearer(request.metadata())?;
        let r = request.into_inner();
        let attempt = attempt(&r.worker, &r.fit, r.epoch)?;
        let progress = r.progress.map(convert::read_progress).transpose()?;
        let cancel_requested = self.app.report_fit(attempt, progress.as_ref()).await?;
        Ok(Response::new(ReportFitResponse { cancel_requested }))
    }

    async fn save_checkpoint(
        &self,
        request: Request<Streaming<SaveCheckpointRequest>>,
    ) -> Result<Response<SaveCheckpointResponse>, Status> {
        self.bearer(request.metadata())?;
        let (job, body) = upload::open(request.into_inner(), |m| match m.part {
            Some(save_checkpoint_request::Part::Metadata(m)) => upload::Part::Metadata(m),
            Some(save_checkpoint_request::Part::Chunk(c)) => upload::Part::Chunk(c),
            None => upload::Part::Neither,
        })
        .await?;
        self.app.save_checkpoint(attempt_of(&job)?, &job.digest, body).await?;
        Ok(Response::new(SaveCheckpointResponse {}))
    }

    async fn complete_fit(
        &self,
        request: Request<Streaming<CompleteFitRequest>>,
    ) -> Result<Response<CompleteFitResponse>, Status> {
        self.bearer(request.metadata())?;
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
        };
        let twin = self.app.complete_fit(attempt_of(&job)?, facts, &job.digest, body).await?;
        Ok(Response::new(CompleteFitResponse { twin: twin.to_string() }))
    }

    async fn fail_fit(
        &self,
        request: Request<FailFitRequest>,
    ) -> Result<Response<FailFitResponse>, Status> {
        self.bearer(request.metadata())?;
        let r = request.into_inner();
        let attempt = attempt(&r.worker, &r.fit, r.epoch)?;
        let fault = r.fault.as_ref().map_or_else(
            || Fault {
                category: Category::Internal,
                reason: "UNSAID".to_owned(),
                message: "the worker did not say why it failed".to_owned(),
            },
            Fault::from,
        );
        let end = match r {
            FailFitRequest { released: true, .. } => AttemptEnd::Released,
            FailFitRequest { cancelled: true, .. } => AttemptEnd::Cancelled,
            FailFitRequest { permanent: true, .. } => AttemptEnd::FailedForGood(fault),
            _ => AttemptEnd::Failed(fault),
        };
        self.app.end_attempt(attempt, end).await?;
        Ok(Response::new(FailFitResponse {}))
    }

    type DownloadStream = Reply<DownloadResponse>;

    async fn download(
        &self,
        request: Request<DownloadRequest>,
    ) -> Result<Response<Self::DownloadStream>, Status> {
        self.bearer(request.metadata())?;
        let content = self.app.download(request.get_ref().name.parse()?).await?;
        Ok(Response::new(chunks(content, |chunk| DownloadResponse { chunk })))
    }
}
