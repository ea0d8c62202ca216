//! What fits on this machine are made of: any capture as a worker reads it, so that a fit through a server and one here are
//! of the same points.

use std::path::Path;

use bendtwin_capture::Limits;
use bendtwin_client::JobProgress;
use bendtwin_core::{Capture, Fault, Stage, settings::ingest::IngestSettings};
use bendtwin_engine::backend::CancelToken;
use bendtwin_worker::Watcher;

use crate::progress::FitBar;

/// Reads the capture at a path; a raw recording is lifted, with a progress bar unless `quiet`.
///
/// # Errors
/// If there is none, nothing can be fitted to it, or `cancel` asked to stop.
pub(crate) fn read(path: &Path, cancel: &CancelToken, quiet: bool) -> Result<Capture, Fault> {
    let (name, settings) = (path.display().to_string(), IngestSettings::default());
    let mut bar = Bar { quiet, shown: None };
    let limits = Limits::default();
    let observed =
        bendtwin_worker::observe(path, &name, &settings, &limits, None, &mut bar, cancel);
    if let Some(bar) = bar.shown {
        bar.finish();
    }
    observed.and_then(|o| o.capture)
}

/// Comes up once there is more to do than to read.
struct Bar {
    quiet: bool,
    shown: Option<FitBar>,
}

impl Watcher for Bar {
    fn progress(&mut self, step: &str, fraction: f64) {
        if step == "read" {
            return;
        }
        let stage = format!("{} {step}", Stage::Ingest.as_str());
        let bar = self.shown.get_or_insert_with(|| FitBar::new(self.quiet));
        bar.show(&JobProgress { stage, fraction, ..JobProgress::default() });
    }
}
