//! Ingest: a capture of any kind becomes an observation, a report and a playback. It is opened,
//! inspected, and lifted where it is raw. No transport: a worker and the command line call the same
//! function.

mod playback;
mod progress;
mod several;
mod views;

use std::path::Path;

use bendtwin_capture::{self as capture, Limits, Opened, raw::Recording};
use bendtwin_core::{
    CancelToken, Capture, Fault, Finding, Observer, ObserverError, Problem, Severity,
    settings::ingest::IngestSettings,
};
use bendtwin_inspect::{Inspection, Lifted, Report, inspect, inspect_observed};
use bendtwin_lift::lift;

pub use bendtwin_lift::Error;
pub use playback::write_playback;
pub use progress::{Progress, Step};
pub use views::{views, views_of_frame};

/// Share of the work on a raw recording that is over when it has been inspected.
const INSPECTED: f64 = 0.3;

/// A capture ready to be fitted, and its report.
#[derive(Clone, Debug)]
pub struct Observed {
    /// The capture that is fitted, or the fault for which none can be.
    pub capture: Result<Capture, Fault>,
    /// The report, in either case.
    pub report: Report,
    /// The recordings of cameras that the capture's recordings were lifted from or lie beside, in their
    /// order.
    pub recorded: Vec<Option<Recording>>,
}

impl Observed {
    /// An observation without lifted images.
    fn new(capture: Result<Capture, Fault>, report: Report) -> Self {
        Self { capture, report, recorded: Vec::new() }
    }
}

/// Ingests the capture at `path`, from a checkpoint of the same work if there is one. `name` is
/// what people call it; messages name it so.
///
/// # Errors
/// Only errors that are no findings about the capture: `observer` or `cancel` asked to stop.
pub fn ingest(
    path: &Path,
    name: &str,
    settings: &IngestSettings,
    limits: &Limits,
    checkpoint: Option<&[u8]>,
    observer: &mut dyn Observer<Progress>,
    cancel: &CancelToken,
) -> Result<Observed, Fault> {
    observer.progress(Progress { step: Step::Read, fraction: 0.0 });
    match capture::open(path, limits) {
        Err(error) => Ok(unread(name, &called(error, path, name).fault())),
        Ok(Opened::Several(parts)) => {
            several::ingest(parts, name, settings, checkpoint, observer, cancel)
        }
        Ok(opened) => {
            let one = ingest_one(opened, name, settings, checkpoint, observer, cancel)?;
            let recorded = match (&one.capture, one.recorded.is_empty()) {
                (Ok(capture), true) => vec![images_beside(path, capture, limits)],
                _ => one.recorded,
            };
            Ok(Observed { recorded, ..one })
        }
    }
}

/// The recording of cameras that lies beside points that were tracked already, if there is one of the
/// same frames.
fn images_beside(path: &Path, capture: &Capture, limits: &Limits) -> Option<Recording> {
    let [sequence] = capture.sequences.as_slice() else { return None };
    let recording = capture::raw::open(path, limits).ok()?;
    (recording.frame_count == sequence.frame_count).then_some(recording)
}

/// Ingests one recording.
fn ingest_one(
    opened: Opened,
    name: &str,
    settings: &IngestSettings,
    checkpoint: Option<&[u8]>,
    observer: &mut dyn Observer<Progress>,
    cancel: &CancelToken,
) -> Result<Observed, Fault> {
    match opened {
        Opened::Several(parts) => {
            several::ingest(parts, name, settings, checkpoint, observer, cancel)
        }
        Opened::Observed(capture, notes) => {
            let mut seen = inspect_observed(&capture);
            name.clone_into(&mut seen.name);
            seen.sources = notes.sources.clone();
            seen.add(notes);
            let usable = seen.check_report().require();
            let capture = usable.map(|()| capture).map_err(|e| e.fault());
            Ok(Observed::new(capture, Report::new(seen, None)))
        }
        Opened::Raw(recording) => {
            let mut tell = |share| {
                observer.progress(Progress { step: Step::Inspect, fraction: INSPECTED * share });
            };
            let mut seen =
                inspect(&recording, settings, cancel, &mut tell).map_err(|e| e.fault())?;
            name.clone_into(&mut seen.name);
            // Lifting takes long, and nothing could be fitted to the result.
            match seen.check_report().require() {
                Err(error) => Ok(Observed::new(Err(error.fault()), Report::new(seen, None))),
                Ok(()) => lift_sound(recording, seen, settings, checkpoint, observer, cancel),
            }
        }
    }
}

/// A recording that is sound enough, lifted.
fn lift_sound(
    recording: Recording,
    mut seen: Inspection,
    settings: &IngestSettings,
    checkpoint: Option<&[u8]>,
    observer: &mut dyn Observer<Progress>,
    cancel: &CancelToken,
) -> Result<Observed, Fault> {
    let mut observer = Lifting(observer);
    let mut lifted = lift(&recording, settings, checkpoint, &mut observer, cancel);
    if let Err(error @ (Error::Checkpoint(_) | Error::OtherCheckpoint)) = &lifted {
        // Written by a build before an update, say: the work is lost, the job is not.
        tracing::warn!("starting the ingest anew: {error}");
        lifted = lift(&recording, settings, None, &mut observer, cancel);
    }
    match lifted {
        Ok(observation) => {
            let capture = observation.capture;
            let evidence = serde_json::to_value(observation.evidence).ok();
            let report = Report::new(seen, Some(Lifted { capture: capture.clone(), evidence }));
            let usable = report.inspection().check_report().require();
            let capture = usable.map(|()| capture).map_err(|e| e.fault());
            Ok(Observed { capture, report, recorded: vec![Some(recording)] })
        }
        Err(error @ (Error::Observer(_) | Error::Cancelled)) => Err(error.fault()),
        Err(error) => {
            let fault = error.fault();
            seen.add([error_of(&fault)]);
            Ok(Observed::new(Err(fault), Report::new(seen, None)))
        }
    }
}

/// A capture known only by the fault that kept it from being read.
pub fn unread(name: &str, fault: &Fault) -> Observed {
    let mut seen = Inspection::unread(name);
    seen.add([error_of(fault)]);
    Observed::new(Err(fault.clone()), Report::new(seen, None))
}

fn error_of(fault: &Fault) -> Finding {
    Finding::from_sentence(Severity::Error, &fault.reason, fault.message.clone())
}

/// Errors call the capture by its name: its path here is that of a temporary file, which means
/// nothing to the user.
fn called(error: capture::Error, path: &Path, name: &str) -> capture::Error {
    use capture::Error::{OtherFormat, RawOnly, UnknownKind};
    let uploaded = path.file_name().and_then(|name| name.to_str()).unwrap_or_default();
    match error {
        UnknownKind { there, .. } => UnknownKind { name: name.to_owned(), there },
        OtherFormat { at, what, advice } if at == uploaded => {
            OtherFormat { at: name.to_owned(), what, advice: advice.replace(uploaded, name) }
        }
        RawOnly(_) => RawOnly(name.to_owned()),
        other => other,
    }
}

/// Observer of the lifting, whose progress is a part of the whole.
struct Lifting<'a>(&'a mut dyn Observer<Progress>);

impl Observer<bendtwin_lift::Progress> for Lifting<'_> {
    fn progress(&mut self, progress: bendtwin_lift::Progress) {
        let fraction = INSPECTED + (1.0 - INSPECTED) * progress.fraction;
        self.0.progress(Progress { step: progress.step.into(), fraction });
    }

    fn checkpoint(&mut self, checkpoint: Vec<u8>) -> Result<(), ObserverError> {
        self.0.checkpoint(checkpoint)
    }
}
