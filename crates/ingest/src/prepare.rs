//! Preparation of a recording of cameras: what was added to it, its calibration, and masks made of
//! strokes. What goes wrong is a finding; only a request to stop is an error.

mod strokes;

use bendtwin_calibrate::{board, ground};
use bendtwin_capture::raw::{Calibration, Recording};
use bendtwin_core::{
    Category, Fault, Finding, Observer, Problem, Severity,
    geometry::{dot, wide},
    settings::ingest::GroundSource,
};
use bendtwin_inspect::{DetectedGround, inspect};

pub use self::strokes::StrokeMasks;
use crate::{Progress, Step, Work, error_of};

/// Cosine of the angle between two grounds from which they are one.
const SAME_UP: f64 = 0.996;
/// Distance between two grounds up to which they are one [m].
const SAME_HEIGHT_M: f64 = 0.02;

/// Shares of the preparation that are over when a board was sought, and when masks are made.
const BOARD: f64 = 0.4;
const MASKS: f64 = 0.8;

/// A recording ready to be inspected.
pub(crate) struct Prepared {
    /// With the poses and masks in use.
    pub(crate) recording: Recording,
    /// What was found on the way.
    pub(crate) findings: Vec<Finding>,
    /// The calibration in use, if it is not the recording's own.
    pub(crate) calibration: Option<Calibration>,
    /// A ground that depth shows, where the recording states none or another one.
    pub(crate) ground: Option<DetectedGround>,
    /// Masks that were made of strokes.
    pub(crate) masks: Option<StrokeMasks>,
}

/// Prepares a recording; `observer` gets shares of this part of the work, 0..=1. The correction is
/// measured where masks show the object, so it comes after them; the ground is sought outside of them.
///
/// # Errors
/// If `observer` or the work's cancellation asked to stop.
pub(crate) fn prepare(
    work: &Work<'_>,
    recording: Recording,
    observer: &mut dyn Observer<Progress>,
) -> Result<Prepared, Fault> {
    let mut preparing = Preparing {
        work,
        made: Prepared {
            recording,
            findings: Vec::new(),
            calibration: None,
            ground: None,
            masks: None,
        },
    };
    preparing.supplements();
    preparing.board(observer)?;
    let mut tell = |share| {
        observer.progress(Progress { step: Step::Mask, fraction: BOARD + (MASKS - BOARD) * share });
    };
    preparing.made.masks =
        strokes::masks(work, &preparing.made.recording, &mut preparing.made.findings, &mut tell)?;
    if let Some(masks) = &preparing.made.masks {
        let recording = preparing.made.recording.clone();
        preparing.made.recording = recording.with_masks(masks.set.clone());
        preparing.made.recording.sources.take("masks", None, "strokes", "");
    }
    preparing.correction(observer)?;
    preparing.ground()?;
    Ok(preparing.made)
}

/// A recording that is being prepared.
struct Preparing<'a> {
    work: &'a Work<'a>,
    made: Prepared,
}

impl Preparing<'_> {
    /// Takes what was added to the capture.
    fn supplements(&mut self) {
        let limits = self.work.limits;
        let supplements = &self.work.input.supplements;
        if let Some(path) = supplements.calibration {
            let read = std::fs::read(path)
                .map_err(|source| bendtwin_capture::Error::Io {
                    at: "the calibration that was added".to_owned(),
                    source,
                })
                .and_then(|bytes| Calibration::read(&bytes, limits));
            match read {
                Ok(calibration) => self.calibrate(calibration, "the calibration that was added"),
                Err(error) => self.fault(&error),
            }
        }
        if let Some(path) = supplements.masks {
            match self.made.recording.clone().with_mask_files(path, limits) {
                Ok(recording) => self.made.recording = recording,
                Err(error) => {
                    let finding = error_of(&error.fault()).explains("MASKS_MISSING");
                    self.made.findings.push(finding);
                }
            }
        }
    }

    /// Measures the poses with a board, if there is one.
    fn board(&mut self, observer: &mut dyn Observer<Progress>) -> Result<(), Fault> {
        let Some(board) = &self.work.settings.calibration.board else { return Ok(()) };
        let mut tell = |share| {
            observer.progress(Progress { step: Step::Calibrate, fraction: BOARD * share });
        };
        let found = board::calibrate(&self.made.recording, board, &mut tell, self.work.cancel);
        match unless_stopped(found)? {
            Ok(found) => {
                self.made.findings.extend(found.findings);
                if let Some(calibration) = found.calibration {
                    self.calibrate(calibration, "the board");
                }
            }
            Err(fault) => self.made.findings.push(error_of(&fault)),
        }
        if !self.made.recording.is_calibrated() {
            let errors = self.made.findings.iter_mut().filter(|f| f.severity == Severity::Error);
            for finding in errors {
                *finding = finding.clone().explains("NOT_CALIBRATED");
            }
        }
        Ok(())
    }

    /// Moves the camera that contradicts the others.
    fn correction(&mut self, observer: &mut dyn Observer<Progress>) -> Result<(), Fault> {
        let settings = self.work.settings;
        if !settings.calibration.correct || !self.made.recording.is_calibrated() {
            return Ok(());
        }
        let mut tell = |share| {
            observer.progress(Progress {
                step: Step::Calibrate,
                fraction: MASKS + (1.0 - MASKS) * share,
            });
        };
        let seen = inspect(&self.made.recording, settings, self.work.cancel, &mut tell);
        let seen = seen.map_err(|error| error.fault())?;
        if let Some(calibration) = seen.correction(&self.made.recording) {
            self.calibrate(calibration, "the correction of CAMERA_OFF");
        }
        Ok(())
    }

    /// Finds the ground in depth: it is taken, or offered where the recording has none or another one.
    fn ground(&mut self) -> Result<(), Fault> {
        let recording = &self.made.recording;
        if !recording.is_calibrated() {
            return Ok(());
        }
        let is_wanted = self.work.settings.calibration.ground == GroundSource::Detected;
        let found = match unless_stopped(ground::detect(recording, self.work.cancel))? {
            Ok(found) => found,
            // Depth that cannot be read is for the inspection to say.
            Err(_) => return Ok(()),
        };
        match found {
            Some(found) if is_wanted => {
                let level = ground::level(recording, &found, false);
                let message = format!(
                    "the ground is a plane with {:.0} % of what the cameras see",
                    100.0 * found.share
                );
                self.calibrate(level, "the ground in depth");
                self.made.findings.push(Finding::info("GROUND_DETECTED", message));
            }
            None if is_wanted => {
                let message = "no plane outside the masks is large enough to be the ground";
                let advice = "record depth with the table in view (docs/use/cameras.md#ground)";
                let finding = Finding::new(Severity::Warning, "GROUND_NOT_DETECTED", message);
                self.made.findings.push(Finding { advice: advice.to_owned(), ..finding });
            }
            Some(found) => self.offer(&found),
            None => {}
        }
        Ok(())
    }

    /// Offers a ground that the recording does not state.
    fn offer(&mut self, found: &ground::Ground) {
        let said = match self.made.recording.environment.ground {
            Some(stated) => {
                let height = f64::from(found.offset_m - stated.offset_m).abs();
                let is_same = dot(wide(stated.normal), wide(found.normal)) > SAME_UP;
                if is_same && height < SAME_HEIGHT_M {
                    return;
                }
                "not where the recording states the ground"
            }
            None => "and the recording states no ground",
        };
        let message =
            format!("a plane has {:.0} % of what the cameras see, {said}", 100.0 * found.share);
        let advice =
            "take it as the ground if the object may lie on it (docs/use/cameras.md#ground)";
        let finding = Finding::info("GROUND_OFFERED", message);
        self.made.findings.push(Finding { advice: advice.to_owned(), ..finding });
        self.made.ground = Some(DetectedGround {
            normal: found.normal,
            offset_m: found.offset_m,
            share: found.share,
        });
    }

    fn calibrate(&mut self, calibration: Calibration, from: &str) {
        match calibration.apply(&mut self.made.recording) {
            Ok(()) => {
                calibration.tell(&mut self.made.recording.sources, from);
                let is_moved = ["correction", "ground"].contains(&calibration.source.as_str());
                // What moves a measured calibration leaves its lenses and errors.
                self.made.calibration = Some(match self.made.calibration.take() {
                    Some(measured) if is_moved && is_alike(&measured, &calibration) => {
                        ground::with_poses(measured, &calibration)
                    }
                    _ => calibration,
                });
            }
            Err(error) => self.fault(&error),
        }
    }

    fn fault(&mut self, error: &impl Problem) {
        self.made.findings.push(error_of(&error.fault()));
    }
}

/// True if two calibrations are of the same cameras in the same order.
fn is_alike(a: &Calibration, b: &Calibration) -> bool {
    let names = |of: &Calibration| of.cameras.iter().map(|c| c.name.clone()).collect::<Vec<_>>();
    names(a) == names(b)
}

/// The outcome of a step, unless it was asked to stop.
fn unless_stopped<T, E: Problem>(outcome: Result<T, E>) -> Result<Result<T, Fault>, Fault> {
    match outcome.map_err(|error| error.fault()) {
        Err(fault) if fault.category == Category::Cancelled => Err(fault),
        outcome => Ok(outcome),
    }
}
