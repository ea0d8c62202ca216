//! A leased job of either kind. Separate tasks renew its lease, report progress, save checkpoints
//! and deliver the result, so that no computation can delay these.

pub(crate) mod checkpoints;
pub(crate) mod deliver;
pub(crate) mod report;
pub(crate) mod resume;
mod stages;
pub(crate) mod stop;

use bendtwin_core::{Fault, ModelLoss, Progress};
use bendtwin_proto::{
    v1,
    worker::v1::{FailJobRequest, JobWrite, Lease, ReportJobRequest, fail_job_request::End},
};
use bytes::Bytes;

use self::{deliver::Failure, report::News};
use crate::server_client::{CallError, ServerClient};

/// A leased job: every write carries the lease's epoch.
#[derive(Clone)]
pub(crate) struct Job {
    server: ServerClient,
    worker: String,
    /// fits/{uuid} or ingests/{uuid}
    name: String,
    epoch: u64,
}

impl Job {
    pub(crate) fn new(server: ServerClient, worker: String, lease: &Lease) -> Self {
        Self { server, worker, name: lease.job.clone(), epoch: lease.epoch }
    }

    /// Renews the lease and stores progress and losses. Returns true if the job has been asked to
    /// stop.
    pub(crate) async fn report(&self, news: &News) -> Result<bool, CallError> {
        let request = ReportJobRequest {
            worker: self.worker.clone(),
            job: self.name.clone(),
            epoch: self.epoch,
            progress: news.progress.as_ref().map(wire_progress),
            losses: news.losses.iter().map(wire_loss).collect(),
        };
        Ok(self.server.report_job(request).await?.cancel_requested)
    }

    pub(crate) async fn save_checkpoint(&self, content: Bytes) -> Result<(), CallError> {
        self.server.save_checkpoint(self.write_of(&content), content).await
    }

    pub(crate) fn server(&self) -> &ServerClient {
        &self.server
    }

    pub(crate) async fn fail(&self, fault: &Fault, kind: Failure) -> Result<(), CallError> {
        let request = FailJobRequest {
            worker: self.worker.clone(),
            job: self.name.clone(),
            epoch: self.epoch,
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
            worker: self.worker.clone(),
            job: self.name.clone(),
            epoch: self.epoch,
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
    }
}

fn wire_loss(loss: &ModelLoss) -> v1::ModelLoss {
    v1::ModelLoss {
        stage: loss.stage.as_str().to_owned(),
        variant: loss.variant.clone(),
        iteration: loss.iteration,
        loss: loss.loss,
        best_loss: loss.best_loss,
    }
}
