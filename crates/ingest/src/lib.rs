//! Ingest: a capture of any kind becomes an observation, a report and a playback. It is opened,
//! calibrated and masked if the settings say so, inspected, and lifted where it is raw. No transport: a
//! worker and the command line call the same function.

mod playback;
mod prepare;
mod progress;
mod several;
mod views;

use std::{ops::Range, path::Path};

use bendtwin_capture::{
    self as capture, Limits, Opened,
    raw::{Recording, Supplements},
};
use bendtwin_core::{
    CancelToken, Capture, Category, Fault, Finding, Observer, ObserverError, Problem, Severity,
    settings::ingest::{IngestSettings, Stage},
};
use bendtwin_inspect::{Inspection, Lifted, Report, inspect, inspect_observed};
use bendtwin_lift::lift;

use self::prepare::Prepared;

pub use bendtwin_lift::Error;
pub use playback::{Played, write_playback};
pub use prepare::StrokeMasks;
pub use progress::{Progress, Step};
pub use views::{views, views_of_frame};

/// Share of the work on a raw recording that is over when it has been inspected.
const INSPECTED: f64 = 0.3;

/// What an ingest reads.
#[derive(Clone, Copy, Debug)]
pub struct Input<'a> {
    /// Path of the capture.
    pub path: &'a Path,
    /// What people call it; messages name it so.
    pub name: &'a str,
    /// What was added to it.
    pub supplements: Supplements<'a>,
    /// The masks that an earlier ingest made of strokes, as their file.
    pub earlier_masks: Option<&'a Path>,
    /// A checkpoint of the same work.
    pub checkpoint: Option<&'a [u8]>,
}

impl<'a> Input<'a> {
    /// A capture alone.
    pub fn new(path: &'a Path, name: &'a str) -> Self {
        let supplements = Supplements::default();
        Self { path, name, supplements, earlier_masks: None, checkpoint: None }
    }
}

/// The result of an ingest, and its report.
#[derive(Clone, Debug)]
pub struct Observed {
    /// The capture that is fitted, or the fault for which none can be. `None` if the ingest ended with
    /// masks, as its settings say.
    pub capture: Result<Option<Capture>, Fault>,
    /// The report, in any case.
    pub report: Report,
    /// The recordings of cameras that the capture's recordings were lifted from or lie beside, in their
    /// order, with the masks and poses in use.
    pub recorded: Vec<Option<Recording>>,
    /// The masks that were made of strokes.
    pub masks: Option<StrokeMasks>,
}

impl Observed {
    /// The capture that is fitted.
    ///
    /// # Errors
    /// The fault for which it is missing.
    pub fn points(self) -> Result<Capture, Fault> {
        self.capture?.ok_or_else(|| Fault {
            category: Category::FailedPrecondition,
            reason: "CAPTURE_NOT_LIFTED".to_owned(),
            message: "its ingest ended with masks: run it again up to points".to_owned(),
        })
    }

    /// An observation without lifted images.
    fn new(capture: Result<Option<Capture>, Fault>, report: Report) -> Self {
        Self { capture, report, recorded: Vec::new(), masks: None }
    }
}

/// Ingests a capture.
///
/// # Errors
/// Only errors that are no findings about the capture: `observer` or `cancel` asked to stop.
pub fn ingest(
    input: Input<'_>,
    settings: &IngestSettings,
    limits: &Limits,
    observer: &mut dyn Observer<Progress>,
    cancel: &CancelToken,
) -> Result<Observed, Fault> {
    observer.progress(Progress { step: Step::Read, fraction: 0.0 });
    let opened = match capture::open(input.path, limits) {
        Err(error) => {
            return Ok(unread(input.name, &called(error, input.path, input.name).fault()));
        }
        Ok(opened) => opened,
    };
    let work = Work { input, settings, limits, cancel };
    let is_one = !matches!(opened, Opened::Several(_));
    let ingested = work.ingest_one(opened, input.name, observer)?;
    let recorded = match &ingested.capture {
        Ok(Some(capture)) if is_one && ingested.recorded.is_empty() => {
            vec![images_beside(input.path, capture, limits)]
        }
        _ => ingested.recorded,
    };
    Ok(Observed { recorded, ..ingested })
}

/// The recording of cameras that lies beside points that were tracked already, if there is one of the
/// same frames.
fn images_beside(path: &Path, capture: &Capture, limits: &Limits) -> Option<Recording> {
    let [sequence] = capture.sequences.as_slice() else { return None };
    let recording = capture::raw::open(path, limits).ok()?;
    (recording.frame_count == sequence.frame_count).then_some(recording)
}

/// The work of an ingest.
struct Work<'a> {
    input: Input<'a>,
    settings: &'a IngestSettings,
    limits: &'a Limits,
    cancel: &'a CancelToken,
}

impl Work<'_> {
    /// Ingests what was opened.
    fn ingest_one(
        &self,
        opened: Opened,
        name: &str,
        observer: &mut dyn Observer<Progress>,
    ) -> Result<Observed, Fault> {
        match opened {
            Opened::Several(parts) => several::ingest(self, parts, name, observer),
            Opened::Observed(capture, notes) => {
                let mut seen = inspect_observed(&capture);
                name.clone_into(&mut seen.name);
                seen.sources = notes.sources.clone();
                seen.add(notes);
                let supplements = self.input.supplements;
                if supplements != Supplements::default() || !self.settings.strokes.is_empty() {
                    let message = "strokes and added files are for images, and this capture has tracked points: \
                                   they were not read";
                    seen.add([Finding::warning("ADDED_NOT_READ", message)]);
                }
                let usable = seen.check_report().require();
                let capture = usable.map(|()| Some(capture)).map_err(|e| e.fault());
                Ok(Observed::new(capture, Report::new(seen, None)))
            }
            Opened::Raw(recording) => self.ingest_raw(recording, name, observer),
        }
    }

    /// Ingests a recording of cameras.
    fn ingest_raw(
        &self,
        recording: Recording,
        name: &str,
        observer: &mut dyn Observer<Progress>,
    ) -> Result<Observed, Fault> {
        let share = self.preparation();
        let mut before = Span { range: 0.0..share, observer: &mut *observer };
        let Prepared { recording, findings, calibration, ground, masks } =
            prepare::prepare(self, recording, &mut before)?;
        let observer = &mut Span { range: share..1.0, observer };
        let mut tell = |share| {
            observer.progress(Progress { step: Step::Inspect, fraction: INSPECTED * share });
        };
        let mut seen =
            inspect(&recording, self.settings, self.cancel, &mut tell).map_err(|e| e.fault())?;
        name.clone_into(&mut seen.name);
        seen.add(findings);
        seen.calibration = calibration.and_then(|c| serde_json::from_str(&c.to_json()).ok());
        seen.ground_detected = ground;
        let observed = match (seen.check_report().require(), self.settings.until) {
            // Lifting takes long, and nothing could be fitted to the result.
            (Err(error), _) => Observed::new(Err(error.fault()), Report::new(seen, None)),
            (Ok(()), Stage::Masks) => Observed::new(Ok(None), Report::new(seen, None)),
            (Ok(()), Stage::Points) => self.lift_sound(&recording, seen, observer)?,
        };
        Ok(Observed { recorded: vec![Some(recording)], masks, ..observed })
    }

    /// Share of the work on a raw recording that is over when it is prepared.
    fn preparation(&self) -> f64 {
        let settings = self.settings;
        let calibration = &settings.calibration;
        if settings.strokes.is_empty() && calibration.board.is_none() && !calibration.correct {
            0.0
        } else if settings.until == Stage::Masks {
            0.8
        } else {
            0.4
        }
    }

    /// A recording that is sound enough, lifted.
    fn lift_sound(
        &self,
        recording: &Recording,
        mut seen: Inspection,
        observer: &mut dyn Observer<Progress>,
    ) -> Result<Observed, Fault> {
        let (settings, cancel) = (self.settings, self.cancel);
        let mut observer = Lifting(observer);
        let mut lifted = lift(recording, settings, self.input.checkpoint, &mut observer, cancel);
        if let Err(error @ (Error::Checkpoint(_) | Error::OtherCheckpoint)) = &lifted {
            // Written by a build before an update, say: the work is lost, the job is not.
            tracing::warn!("starting the ingest anew: {error}");
            lifted = lift(recording, settings, None, &mut observer, cancel);
        }
        let (capture, report) = match lifted {
            Ok(observation) => {
                let capture = observation.capture;
                let evidence = serde_json::to_value(observation.evidence).ok();
                let report = Report::new(seen, Some(Lifted { capture: capture.clone(), evidence }));
                let usable = report.inspection().check_report().require();
                (usable.map(|()| Some(capture)).map_err(|e| e.fault()), report)
            }
            Err(error @ (Error::Observer(_) | Error::Cancelled)) => return Err(error.fault()),
            Err(error) => {
                let fault = error.fault();
                seen.add([error_of(&fault)]);
                (Err(fault), Report::new(seen, None))
            }
        };
        Ok(Observed::new(capture, report))
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

/// Observer of a part of the work, whose progress is a range of the whole.
struct Span<'a> {
    range: Range<f64>,
    observer: &'a mut dyn Observer<Progress>,
}

impl Observer<Progress> for Span<'_> {
    fn progress(&mut self, Progress { step, fraction }: Progress) {
        let Range { start, end } = self.range;
        self.observer.progress(Progress { step, fraction: start + (end - start) * fraction });
    }

    fn checkpoint(&mut self, checkpoint: Vec<u8>) -> Result<(), ObserverError> {
        self.observer.checkpoint(checkpoint)
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

#[cfg(test)]
mod tests;
