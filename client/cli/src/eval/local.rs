//! A fit on this machine, with a progress bar.

use std::{sync::Arc, time::Duration};

use bendtwin_client::JobProgress;
use bendtwin_core::{CancelToken, Capture, FitSettings, Observer, Progress, Twin};
use bendtwin_engine::Backend;
use bendtwin_fit::{FitJob, Look};

use crate::{failure, progress::FitBar};

/// The twins that a fit made.
pub(super) struct Fitted {
    pub(super) twin: Twin,
    pub(super) axial: Option<Twin>,
}

/// Fits a capture, or refines a twin in it; also returns the time it took.
pub(super) fn fit(
    capture: &Capture,
    settings: FitSettings,
    start: Option<&Twin>,
    look: Option<Look<'_>>,
    backend: &Arc<dyn Backend>,
    cancel: &CancelToken,
    quiet: bool,
) -> anyhow::Result<(Fitted, Duration)> {
    let mut bar = BarObserver::new(quiet);
    let job = FitJob {
        capture,
        capture_digest: bendtwin_capture::digest(capture),
        settings,
        backend: Arc::clone(backend),
        look,
    };
    let outcome = match start {
        Some(twin) => job.refine(twin, None, &mut bar, cancel),
        None => job.run(None, &mut bar, cancel),
    };
    let took = bar.finish();
    let outcome = outcome.map_err(failure::failed)?;
    Ok((Fitted { twin: outcome.twin, axial: outcome.axial }, took))
}

/// The progress of a fit as a bar.
pub(super) struct BarObserver(FitBar);

impl BarObserver {
    /// `quiet` shows nothing.
    pub(super) fn new(quiet: bool) -> Self {
        Self(FitBar::new(quiet))
    }

    /// Prints a line above the bar.
    pub(super) fn print(&self, text: &str) {
        self.0.print(text);
    }

    /// Removes the bar; returns the time since its start.
    pub(super) fn finish(self) -> Duration {
        self.0.finish()
    }
}

impl Observer<Progress> for BarObserver {
    fn progress(&mut self, progress: Progress) {
        self.0.show(&JobProgress {
            stage: progress.stage.as_str().to_owned(),
            variant: progress.variant,
            iteration: progress.iteration,
            iterations: progress.iterations,
            fraction: progress.fraction,
            loss: progress.loss,
            best_loss: progress.best_loss,
            eta_s: progress.eta_s,
            note: progress.note.unwrap_or_default(),
            models: Vec::new(),
            error_m: None,
        });
    }
}
