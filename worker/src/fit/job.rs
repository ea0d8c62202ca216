//! A leased job: every write carries the lease's epoch.

use bendtwin_core::{Fault, Progress, Stage};
use bendtwin_proto::{
    v1,
    worker::v1::{FailFitRequest, JobWrite, Lease, ReportFitRequest, TwinWrite},
};
use bytes::Bytes;

use super::{compute::Finished, deliver::Failure};
use crate::link::{Link, LinkError};

/// A leased job.
#[derive(Clone)]
pub(super) struct Job {
    link: Link,
    worker: String,
    fit: String,
    epoch: u64,
}

impl Job {
    pub(super) fn new(link: Link, worker: String, lease: &Lease) -> Self {
        Self { link, worker, fit: lease.fit.clone(), epoch: lease.epoch }
    }

    /// Renews the lease and stores progress. Says whether cancellation is wanted.
    pub(super) async fn report(&self, progress: Option<&Progress>) -> Result<bool, LinkError> {
        let request = ReportFitRequest {
            worker: self.worker.clone(),
            fit: self.fit.clone(),
            epoch: self.epoch,
            progress: progress.map(wire_progress),
        };
        Ok(self.link.report_fit(request).await?.cancel_requested)
    }

    pub(super) async fn save_checkpoint(&self, content: Bytes) -> Result<(), LinkError> {
        self.link.save_checkpoint(self.write_of(&content), content).await
    }

    pub(super) async fn complete(&self, finished: &Finished) -> Result<String, LinkError> {
        let twin = TwinWrite {
            job: Some(self.write_of(&finished.file)),
            node_count: finished.node_count,
            spring_count: finished.spring_count,
            triplet_count: finished.triplet_count,
            control_count: finished.control_count,
            fps: finished.fps,
            substeps: finished.substeps,
            quality_json: finished.quality_json.clone(),
        };
        self.link.complete_fit(twin, finished.file.clone()).await
    }

    pub(super) async fn fail(&self, fault: &Fault, kind: Failure) -> Result<(), LinkError> {
        let request = FailFitRequest {
            worker: self.worker.clone(),
            fit: self.fit.clone(),
            epoch: self.epoch,
            fault: Some(fault.into()),
            permanent: kind == Failure::Permanent,
            cancelled: kind == Failure::Cancelled,
            released: kind == Failure::Released,
        };
        self.link.fail_fit(request).await
    }

    fn write_of(&self, content: &[u8]) -> JobWrite {
        JobWrite {
            worker: self.worker.clone(),
            fit: self.fit.clone(),
            epoch: self.epoch,
            digest: blake3::hash(content).to_hex().to_string(),
        }
    }
}

fn wire_progress(progress: &Progress) -> v1::Progress {
    let stage = match progress.stage {
        Stage::Ingest => "ingest",
        Stage::Search => "search",
        Stage::Refine => "refine",
        Stage::Evaluate => "evaluate",
    };
    v1::Progress {
        stage: stage.to_owned(),
        variant: progress.variant.clone(),
        iteration: progress.iteration,
        iterations: progress.iterations,
        fraction: progress.fraction,
        loss: progress.loss,
        best_loss: progress.best_loss,
        eta_s: progress.eta_s,
        note: progress.note.clone().unwrap_or_default(),
    }
}
