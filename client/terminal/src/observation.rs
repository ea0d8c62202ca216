//! The input of fits on this machine: any capture, read as a worker reads it, so that a fit through
//! a server and one here use the same points.

use std::path::Path;

use bendtwin_capture::Limits;
use bendtwin_client::JobProgress;
use bendtwin_core::{
    CancelToken, Capture, Fault, Observer, Stage, Views, settings::ingest::IngestSettings,
};
use bendtwin_ingest::{Input, Progress, Step, ingest, views};

use crate::progress::FitBar;

/// A capture, and the views of the cameras of its first recording if it is a raw recording.
pub type Observed = (Capture, Option<Views>);

/// Reads the capture at a path. A raw recording is lifted, with a progress bar unless `quiet`.
///
/// # Errors
/// If there is no capture, nothing can be fitted to it, or `cancel` was set.
pub fn read(path: &Path, cancel: &CancelToken, quiet: bool) -> Result<Observed, Fault> {
    let (name, settings) = (path.display().to_string(), IngestSettings::default());
    let mut bar = Bar { quiet, shown: None };
    let limits = Limits::default();
    let read = ingest(Input::new(path, &name), &settings, &limits, &mut bar, cancel);
    if let Some(bar) = bar.shown {
        bar.finish();
    }
    let read = read?;
    let recording = read.recorded.first().and_then(Option::as_ref);
    let views = recording.and_then(|recording| views(recording, &mut |_| {}));
    Ok((read.points()?, views))
}

/// Progress bar, shown only if there is more to do than to read.
struct Bar {
    quiet: bool,
    shown: Option<FitBar>,
}

impl Observer<Progress> for Bar {
    fn progress(&mut self, Progress { step, fraction }: Progress) {
        if step == Step::Read {
            return;
        }
        let stage = format!("{} {}", Stage::Ingest.as_str(), step.as_str());
        let bar = self.shown.get_or_insert_with(|| FitBar::new(self.quiet));
        bar.show(&JobProgress { stage, fraction, ..JobProgress::default() });
    }
}
