//! A leased job of either kind, which owns its lease. Separate tasks renew it, report progress, save
//! checkpoints and deliver the result, so that no computation can delay these.

mod attempt;
pub(crate) mod checkpoints;
pub(crate) mod deliver;
pub(crate) mod report;
mod resume;
mod stages;
pub(crate) mod stop;

use std::{path::Path, sync::Arc};

use bendtwin_core::{Fault, ModelLoss, Preview, Progress};
use bendtwin_proto::{
    v1::{self, Tensor},
    worker::v1::{
        FailJobRequest, JobWrite, Lease, ReportJobRequest, ReportJobResponse,
        fail_job_request::End, lease_job_request::Kind,
    },
};
use bytes::Bytes;
use tempfile::NamedTempFile;
use tracing::Span;

pub(crate) use self::attempt::Attempt;
use self::{deliver::Failure, report::News};
use crate::{
    artifact::{self, FetchError},
    observation,
    server_client::{CallError, ServerClient},
};

/// A job that is leased to this worker, whose inputs are fetched under the lease. Every write carries
/// the worker and the epoch of the lease; clones share it.
#[derive(Clone)]
pub(crate) struct LeasedJob {
    server: ServerClient,
    /// workers/{uuid}
    worker: Arc<str>,
    lease: Arc<Lease>,
}

impl LeasedJob {
    pub(crate) fn new(server: ServerClient, worker: &str, lease: Lease) -> Self {
        Self { server, worker: worker.into(), lease: Arc::new(lease) }
    }

    /// fits/{uuid} or ingests/{uuid}
    pub(crate) fn name(&self) -> &str {
        &self.lease.job
    }

    /// captures/{uuid}
    pub(crate) fn capture(&self) -> &str {
        &self.lease.capture
    }

    /// Name that people gave the capture; empty if they gave none.
    pub(crate) fn capture_display_name(&self) -> &str {
        &self.lease.capture_display_name
    }

    /// True if it was leased as a brief job.
    pub(crate) fn is_brief(&self) -> bool {
        self.lease.brief
    }

    /// Settings of the job, as JSON.
    pub(crate) fn settings_json(&self) -> &str {
        &self.lease.settings_json
    }

    /// The span of the work on it, within the trace of the call that asked for the job.
    pub(crate) fn span(&self, kind: Kind) -> Span {
        let Lease { job, epoch, capture, request_id, trace_parent, .. } = &*self.lease;
        let span = match kind {
            Kind::Ingest => tracing::info_span!("ingest", job, epoch, capture, trace_parent),
            Kind::Fit | Kind::Unspecified => {
                tracing::info_span!("fit", job, epoch, capture, request_id, trace_parent)
            }
        };
        bendtwin_telemetry::continue_from(&span, trace_parent);
        span
    }

    /// The archive of the capture, in a temporary file in `dir`.
    pub(crate) async fn fetch_capture(&self, dir: &Path) -> Result<NamedTempFile, FetchError> {
        let digest = Some(self.lease.capture_digest.as_str());
        artifact::fetch_file(&self.server, self.capture(), digest, dir).await
    }

    /// The kinds of files that were added to the capture.
    pub(crate) fn supplements(&self) -> impl Iterator<Item = &str> {
        self.lease.supplements.iter().map(|supplement| supplement.kind.as_str())
    }

    /// A file that was added to the capture, in a temporary file in `dir`.
    pub(crate) async fn fetch_supplement(
        &self,
        kind: &str,
        dir: &Path,
    ) -> Result<NamedTempFile, FetchError> {
        let found = self.lease.supplements.iter().find(|supplement| supplement.kind == kind);
        let digest = found.map(|supplement| supplement.digest.as_str());
        let name = format!("{}/supplements/{kind}", self.capture());
        artifact::fetch_file(&self.server, &name, digest, dir).await
    }

    /// The masks that the ingest before made of strokes, if there are any, in a temporary file in
    /// `dir`.
    pub(crate) async fn fetch_masks(
        &self,
        dir: &Path,
    ) -> Result<Option<NamedTempFile>, FetchError> {
        if self.lease.masks_digest.is_empty() {
            return Ok(None);
        }
        let digest = Some(self.lease.masks_digest.as_str());
        let name = format!("{}/masks", self.capture());
        artifact::fetch_file(&self.server, &name, digest, dir).await.map(Some)
    }

    /// The observation that the ingest of the capture made, in a temporary file in `dir`.
    pub(crate) async fn fetch_observation(&self, dir: &Path) -> Result<NamedTempFile, FetchError> {
        let digest = Some(self.lease.observation_digest.as_str());
        artifact::fetch_file(&self.server, &observation::name(self.capture()), digest, dir).await
    }

    /// A twin that the settings name, of at most `limit` bytes.
    pub(crate) async fn fetch_twin(&self, name: &str, limit: u64) -> Result<Bytes, FetchError> {
        artifact::fetch(&self.server, name, limit).await
    }

    /// Renews the lease and stores progress, losses and preview. Returns what the server asks of the job.
    pub(crate) async fn report(&self, news: &News) -> Result<ReportJobResponse, CallError> {
        let request = ReportJobRequest {
            worker: self.worker.to_string(),
            job: self.lease.job.clone(),
            epoch: self.lease.epoch,
            progress: news.progress.as_ref().map(wire_progress),
            losses: news.losses.iter().map(wire_loss).collect(),
            preview: news.preview.as_deref().map(wire_preview),
        };
        self.server.report_job(request).await
    }

    pub(crate) async fn save_checkpoint(&self, content: Bytes) -> Result<(), CallError> {
        self.server.save_checkpoint(self.write_of(&content), content).await
    }

    pub(crate) fn server(&self) -> &ServerClient {
        &self.server
    }

    pub(crate) async fn fail(&self, fault: &Fault, kind: Failure) -> Result<(), CallError> {
        let request = FailJobRequest {
            worker: self.worker.to_string(),
            job: self.lease.job.clone(),
            epoch: self.lease.epoch,
            end: End::from(kind).into(),
            fault: Some(fault.into()),
        };
        self.server.fail_job(request).await
    }

    /// Header of a write of this content.
    pub(crate) fn write_of(&self, content: &[u8]) -> JobWrite {
        JobWrite { digest: blake3::hash(content).to_hex().to_string(), ..self.write() }
    }

    /// Header of a write of several contents.
    pub(crate) fn write(&self) -> JobWrite {
        JobWrite {
            worker: self.worker.to_string(),
            job: self.lease.job.clone(),
            epoch: self.lease.epoch,
            digest: String::new(),
        }
    }
}

impl From<Failure> for End {
    fn from(kind: Failure) -> Self {
        match kind {
            Failure::Permanent => Self::FailedForGood,
            Failure::Passing => Self::Failed,
            Failure::Cancelled => Self::Cancelled,
            Failure::Released => Self::Released,
            Failure::Outgrown => Self::Outgrown,
            Failure::Interrupted => Self::Interrupted,
        }
    }
}

fn wire_progress(progress: &Progress) -> v1::Progress {
    v1::Progress {
        stage: progress.stage.as_str().to_owned(),
        variant: progress.variant.clone(),
        iteration: progress.iteration,
        iterations: progress.iterations,
        fraction: progress.fraction,
        loss: progress.loss,
        best_loss: progress.best_loss,
        eta_s: progress.eta_s,
        note: progress.note.clone().unwrap_or_default(),
        models: progress.models.iter().map(wire_loss).collect(),
        error_m: progress.error_m,
    }
}

fn wire_loss(loss: &ModelLoss) -> v1::ModelLoss {
    v1::ModelLoss {
        stage: loss.stage.as_str().to_owned(),
        variant: loss.variant.clone(),
        iteration: loss.iteration,
        loss: loss.loss,
        best_loss: loss.best_loss,
        error_m: loss.error_m,
    }
}

fn wire_preview(preview: &Preview) -> v1::FitPreview {
    let shape = [preview.frames.len(), preview.point_count()];
    v1::FitPreview {
        stage: preview.stage.as_str().to_owned(),
        variant: preview.variant.clone(),
        iteration: preview.iteration,
        // The server's time counts.
        create_time: None,
        sequence: preview.sequence,
        frames: Some(Tensor::pack(&shape[..1], &preview.frames)),
        positions: Some(Tensor::pack_points_i16(&shape, &preview.positions)),
        measure: preview.errors.measure.as_str().to_owned(),
        error_m: preview.errors.error_m,
        held_back_m: preview.errors.held_back_m,
        baseline_m: preview.errors.baseline_m,
    }
}

#[cfg(test)]
mod tests;
