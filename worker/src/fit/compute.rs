//! The computing part of a fit, in a separate thread.

use std::sync::Arc;

use bendtwin_core::{
    Fault, FitSettings, Observer, ObserverError, Problem as _, Progress, Stage, Twin,
};
use bendtwin_fit::{FitJob, Look, OpenRasteriser};
use bytes::Bytes;
use tempfile::NamedTempFile;

use crate::{
    Limits,
    device::{Device, Priority},
    job::{checkpoints::Checkpoints, report::LatestProgress, stop::Stop},
    observation,
};

/// The computation of a fit and the channels on which it reports.
pub(super) struct Compute {
    pub(super) progress: LatestProgress,
    pub(super) checkpoints: Checkpoints,
    pub(super) stop: Stop,
}

/// Inputs of a fit.
pub(super) struct Inputs {
    /// Name that people gave the capture; empty if they gave none.
    pub(super) capture_name: String,
    pub(super) settings: FitSettings,
    /// The twin that is refined, if the settings name one.
    pub(super) start: Option<Twin>,
    /// The bundle that the ingest of the capture made.
    pub(super) observation: NamedTempFile,
    pub(super) checkpoint: Option<Bytes>,
}

/// A twin, ready to be sent.
pub(super) struct Finished {
    pub(super) file: Bytes,
    pub(super) node_count: u32,
    pub(super) spring_count: u32,
    pub(super) triplet_count: u32,
    pub(super) control_count: u32,
    pub(super) fps: f64,
    pub(super) substeps: u32,
    pub(super) quality_json: String,
}

impl Compute {
    /// Reads the observation and fits it, from the checkpoint if there is one.
    pub(super) fn run(
        self,
        inputs: Inputs,
        device: &Device,
        rasteriser: OpenRasteriser,
        limits: &Limits,
    ) -> Result<Finished, Fault> {
        let Inputs { capture_name, mut settings, start, observation, checkpoint } = inputs;
        if let Some(twin) = &start {
            // Its graph is what takes memory.
            settings.graph.max_nodes = Some(twin.graph.node_count().max(1));
        }
        self.progress.set(reading_progress());
        // The fit's memory includes its capture.
        let capture_bytes = limits.capture_bytes.min(limits.fit_bytes);
        let reading = Limits { capture_bytes, ..*limits };
        let read = observation::read(observation.path(), &reading);
        let mut capture = read.map_err(|e| e.fault())?;
        let views = observation::read_views(observation.path(), &reading).map_err(|e| e.fault())?;
        // It may be gigabytes, and everything is in memory now.
        drop(observation);
        // People may have given the capture a name since it was recorded.
        if !capture_name.is_empty() {
            capture.name = capture_name;
        }
        let backend = Arc::new(device.backend(Priority::Background));
        let most = limits.fit_bytes;
        let needed =
            bendtwin_fit::memory::check(&capture, views.as_ref(), &settings, &*backend, most)
                .map_err(|e| e.fault())?;
        tracing::info!(mib = needed >> 20, "memory of the fit, estimated");
        let job = FitJob {
            capture: &capture,
            // Of the fitted observation, not of the upload: an ingest may run again with other
            // settings.
            capture_digest: bendtwin_capture::digest(&capture),
            settings,
            backend,
            look: views.as_ref().map(|views| Look { views, rasteriser }),
        };
        let token = self.stop.token().clone();
        let mut observer = JobObserver { compute: self, stage_ended: false };
        let run = |checkpoint: Option<&[u8]>, observer: &mut JobObserver| match &start {
            Some(twin) => job.refine(twin, checkpoint, observer, &token),
            None => job.run(checkpoint, observer, &token),
        };
        let mut result = run(checkpoint.as_deref(), &mut observer);
        if let Err(
            e @ (bendtwin_fit::Error::Checkpoint(_) | bendtwin_fit::Error::OtherCheckpoint),
        ) = &result
        {
            // From a build before an update, for example: the work is lost, the job is not.
            tracing::warn!("restarting the fit from the beginning: {e}");
            result = run(None, &mut observer);
        }
        finished(&result.map_err(|e| e.fault())?.twin)
    }
}

/// Passes on progress, previews and checkpoints of a fit.
struct JobObserver {
    compute: Compute,
    /// True if the last iteration reported was a stage's last.
    stage_ended: bool,
}

impl Observer<Progress> for JobObserver {
    fn progress(&mut self, progress: Progress) {
        self.stage_ended = progress.iteration >= progress.iterations;
        self.compute.progress.set(progress);
    }

    fn checkpoint(&mut self, checkpoint: Vec<u8>) -> Result<(), ObserverError> {
        self.compute.checkpoints.submit(checkpoint, self.stage_ended);
        self.compute.stop.at_checkpoint();
        Ok(())
    }

    fn wants_previews(&self) -> bool {
        true
    }
}

fn reading_progress() -> Progress {
    Progress {
        stage: Stage::Ingest,
        variant: String::new(),
        iteration: 0,
        iterations: 1,
        fraction: 0.0,
        loss: None,
        best_loss: None,
        eta_s: None,
        note: None,
        models: Vec::new(),
        error_m: None,
        preview: None,
    }
}

fn finished(twin: &Twin) -> Result<Finished, Fault> {
    let file = twin.encode().map_err(|e| e.fault())?;
    let quality_json = serde_json::to_string(&twin.quality).unwrap_or_default();
    let count = |n: usize| u32::try_from(n).unwrap_or(u32::MAX);
    Ok(Finished {
        file: file.into(),
        node_count: count(twin.graph.node_count()),
        spring_count: count(twin.graph.springs.len()),
        triplet_count: count(twin.graph.triplets.len()),
        control_count: count(twin.graph.control_count()),
        fps: twin.timing.fps,
        substeps: twin.timing.substeps,
        quality_json,
    })
}
