//! What an ingest does with a capture of any kind: read it, say what is wrong with it, lift it if it is raw.

use std::path::Path;

use bendtwin_capture::{self as capture, Limits, Opened, raw::Recording};
use bendtwin_core::{CancelToken, Capture, Fault, Problem, settings::ingest::IngestSettings};
use bendtwin_ingest::{Error, Observer, ObserverError, Progress, Step};
use bendtwin_inspect::{Inspection, Lifted, Report, inspect, inspect_observed};

/// Share of the work on a raw recording that is over when it has been inspected.
const INSPECTED: f64 = 0.3;

/// A capture as it is fitted, and what is to be said of it.
#[derive(Clone, Debug)]
pub struct Observed {
    /// What is fitted, or why nothing can be.
    pub capture: Result<Capture, Fault>,
    /// What is to be said of it in either case.
    pub report: Report,
}

/// Who is told how [`observe()`] goes on.
pub trait Watcher {
    /// What is being done, in a word, and the share of the whole that is over, 0..=1.
    fn progress(&mut self, step: &str, fraction: f64);

    /// Called now and then with all that is needed to go on from there in another process; without one nothing is kept.
    ///
    /// # Errors
    /// If the work should end, because the checkpoint cannot be kept.
    fn checkpoint(&mut self, _checkpoint: Vec<u8>) -> Result<(), ObserverError> {
        Ok(())
    }
}

/// Reads the capture at a path, from a checkpoint of the same work if there is one. People call it `name`.
///
/// # Errors
/// What says nothing about the capture: that the watcher or `cancel` asked to stop.
pub fn observe(
    path: &Path,
    name: &str,
    settings: &IngestSettings,
    limits: &Limits,
    checkpoint: Option<&[u8]>,
    watcher: &mut dyn Watcher,
    cancel: &CancelToken,
) -> Result<Observed, Fault> {
    watcher.progress("read", 0.0);
    match capture::open(path, limits) {
        Err(error) => Ok(unread(name, &called(error, name).fault())),
        Ok(Opened::Observed(capture, notes)) => {
            let mut seen = inspect_observed(&capture);
            name.clone_into(&mut seen.name);
            seen.add(notes.into_iter().map(Into::into));
            let usable = seen.check_report().require();
            let capture = usable.map(|()| capture).map_err(|e| e.fault());
            Ok(Observed { capture, report: Report::new(seen, None) })
        }
        Ok(Opened::Raw(recording)) => {
            let mut told = |share| watcher.progress("inspect", INSPECTED * share);
            let mut seen = inspect(&recording, cancel, &mut told).map_err(|e| e.fault())?;
            name.clone_into(&mut seen.name);
            // What is that wrong is not worth lifting.
            match seen.check_report().require() {
                Err(error) => {
                    Ok(Observed { capture: Err(error.fault()), report: Report::new(seen, None) })
                }
                Ok(()) => lift(&recording, seen, settings, checkpoint, watcher, cancel),
            }
        }
    }
}

/// A recording that is sound enough, lifted.
fn lift(
    recording: &Recording,
    mut seen: Inspection,
    settings: &IngestSettings,
    checkpoint: Option<&[u8]>,
    watcher: &mut dyn Watcher,
    cancel: &CancelToken,
) -> Result<Observed, Fault> {
    let mut observer = Lifting(watcher);
    let mut lifted =
        bendtwin_ingest::ingest(recording, settings, checkpoint, &mut observer, cancel);
    if let Err(error @ (Error::Checkpoint(_) | Error::OtherCheckpoint)) = &lifted {
        // From a build before an update, say: the work is lost, the job is not.
        tracing::warn!("starting the ingest anew: {error}");
        lifted = bendtwin_ingest::ingest(recording, settings, None, &mut observer, cancel);
    }
    match lifted {
        Ok(observation) => {
            let capture = observation.capture;
            let evidence = serde_json::to_value(observation.evidence).ok();
            let report = Report::new(seen, Some(Lifted { capture: capture.clone(), evidence }));
            let usable = report.inspection().check_report().require();
            Ok(Observed { capture: usable.map(|()| capture).map_err(|e| e.fault()), report })
        }
        Err(error @ (Error::Observer(_) | Error::Cancelled)) => Err(error.fault()),
        Err(error) => {
            let fault = error.fault();
            seen.add([error_of(&fault)]);
            Ok(Observed { capture: Err(fault), report: Report::new(seen, None) })
        }
    }
}

/// What is to be said of a capture of which nothing else is known.
pub(super) fn unread(name: &str, fault: &Fault) -> Observed {
    let mut seen = Inspection::unread(name);
    seen.add([error_of(fault)]);
    Observed { capture: Err(fault.clone()), report: Report::new(seen, None) }
}

fn error_of(fault: &Fault) -> bendtwin_inspect::Finding {
    let finding = capture::Finding {
        severity: capture::Severity::Error,
        code: fault.reason.clone(),
        message: fault.message.clone(),
    };
    finding.into()
}

/// Errors call the capture by its name: its path here is a temporary file's, which tells nobody anything.
fn called(error: capture::Error, name: &str) -> capture::Error {
    use capture::Error::{RawOnly, UnknownKind};
    match error {
        UnknownKind(_) => UnknownKind(name.to_owned()),
        RawOnly(_) => RawOnly(name.to_owned()),
        other => other,
    }
}

/// A watcher as the lifting stage has it.
struct Lifting<'a>(&'a mut dyn Watcher);

impl Observer for Lifting<'_> {
    fn progress(&mut self, progress: Progress) {
        let step = match progress.step {
            Step::Track => "track",
            Step::Lift => "lift",
            Step::Assemble => "assemble",
            Step::Complete => "complete",
        };
        self.0.progress(step, INSPECTED + (1.0 - INSPECTED) * progress.fraction);
    }

    fn checkpoint(&mut self, checkpoint: Vec<u8>) -> Result<(), ObserverError> {
        self.0.checkpoint(checkpoint)
    }
}
