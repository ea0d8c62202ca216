//! The judges: findings from measured numbers. Each part judges one kind of fault and says what it
//! finds; what merely follows from another fault is left out later, see `consequences`.

mod agreement;
mod alignment;
mod calibration;
mod depth;
mod masks;
mod motion;
mod paths;
mod recording;
mod scale;
mod skew;
mod start;
mod timing;
mod tracks;

use bendtwin_capture::raw::{Pose, Recording, called};
use bendtwin_core::settings::ingest::IngestSettings;

use self::paths::Paths;
use crate::{
    Finding,
    inspection::{CameraReport, PairReport, Scene},
    scan::CameraScan,
    thresholds::Thresholds,
    vector::Upright,
};

/// Input of the judges: a recording and its measurements.
pub(crate) struct Context<'a> {
    pub(crate) recording: &'a Recording,
    pub(crate) scans: &'a [CameraScan],
    /// Settings of the ingest for which it is judged.
    pub(crate) settings: &'a IngestSettings,
    pub(crate) thresholds: &'a Thresholds,
    upright: Upright,
    paths: Paths,
}

/// Output of the judges, to which each adds.
#[derive(Debug, Default)]
pub(crate) struct Assessment {
    pub(crate) findings: Vec<Finding>,
    pub(crate) scene: Scene,
    pub(crate) cameras: Vec<CameraReport>,
    pub(crate) pairs: Vec<PairReport>,
    /// Motions of the world that would bring cameras to where they stand, by index of the camera.
    pub(crate) corrections: Vec<(usize, Pose)>,
}

/// Judges a scanned recording.
pub(crate) fn judge(
    recording: &Recording,
    scans: &[CameraScan],
    settings: &IngestSettings,
    thresholds: &Thresholds,
) -> Assessment {
    let upright = Upright::of(&recording.environment);
    let paths = Paths::of(recording, scans);
    let context = Context { recording, scans, settings, thresholds, upright, paths };
    let cameras = recording.cameras.iter().map(CameraReport::of);
    let mut assessment = Assessment { cameras: cameras.collect(), ..Assessment::default() };
    recording::judge(&context, &mut assessment);
    calibration::judge(&context, &mut assessment);
    timing::judge(&context, &mut assessment);
    masks::judge(&context, &mut assessment);
    start::judge(&context, &mut assessment);
    depth::judge(&context, &mut assessment);
    scale::judge(&context, &mut assessment);
    motion::judge(&context, &mut assessment);
    skew::judge(&context, &mut assessment);
    alignment::judge(&context, &mut assessment);
    agreement::judge(&context, &mut assessment);
    tracks::judge(&context, &mut assessment);
    assessment
}

/// Judges a recording whose frames were not read: length, frame rate, calibration.
pub(crate) fn judge_unread(
    recording: &Recording,
    settings: &IngestSettings,
    thresholds: &Thresholds,
) -> Vec<Finding> {
    let context = Context {
        recording,
        scans: &[],
        settings,
        thresholds,
        upright: Upright::of(&recording.environment),
        paths: Paths::default(),
    };
    let mut assessment = Assessment::default();
    recording::judge(&context, &mut assessment);
    calibration::judge(&context, &mut assessment);
    assessment.findings
}

/// `camera 2 (front)`, or `camera 2` if its name is its number.
pub(crate) fn named(recording: &Recording, index: usize) -> String {
    called(index, recording.cameras.get(index).map_or("", |camera| &camera.name))
}

#[cfg(test)]
mod tests;
