//! The judges: findings from measured numbers. Each part judges one kind of fault; what merely
//! follows from a fault that was found is left out, so that a recording with one fault has one
//! finding.

mod agreement;
mod calibration;
mod depth;
mod masks;
mod motion;
mod paths;
mod recording;
mod scale;
mod skew;
mod timing;
mod tracks;

use bendtwin_capture::raw::Recording;

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
}

/// Judges a scanned recording.
pub(crate) fn judge(
    recording: &Recording,
    scans: &[CameraScan],
    thresholds: &Thresholds,
) -> Assessment {
    let upright = Upright::of(&recording.environment);
    let context =
        Context { recording, scans, thresholds, upright, paths: Paths::of(recording, scans) };
    let cameras = recording.cameras.iter().map(|camera| CameraReport {
        name: camera.name.clone(),
        width: camera.width,
        height: camera.height,
        ..CameraReport::default()
    });
    let mut assessment = Assessment { cameras: cameras.collect(), ..Assessment::default() };
    recording::judge(&context, &mut assessment);
    calibration::judge(&context, &mut assessment);
    timing::judge(&context, &mut assessment);
    masks::judge(&context, &mut assessment);
    depth::judge(&context, &mut assessment);
    scale::judge(&context, &mut assessment);
    motion::judge(&context, &mut assessment);
    skew::judge(&context, &mut assessment);
    agreement::judge(&context, &mut assessment);
    tracks::judge(&context, &mut assessment);
    leave_out_consequences(&mut assessment.findings);
    crate::finding::advise(&mut assessment.findings);
    crate::finding::sort(&mut assessment.findings);
    assessment
}

/// Judges a recording whose frames were not read: length, frame rate, calibration.
pub(crate) fn judge_unread(recording: &Recording, thresholds: &Thresholds) -> Vec<Finding> {
    let context = Context {
        recording,
        scans: &[],
        thresholds,
        upright: Upright::of(&recording.environment),
        paths: Paths::default(),
    };
    let mut assessment = Assessment::default();
    recording::judge(&context, &mut assessment);
    calibration::judge(&context, &mut assessment);
    crate::finding::advise(&mut assessment.findings);
    assessment.findings
}

/// Faults, and the findings that merely follow from them.
const CONSEQUENCES: &[(&[&str], &[&str])] = &[
    (
        &[
            "INTRINSICS_INVALID",
            "EXTRINSICS_INVALID",
            "EXTRINSICS_MIRRORED",
            "EXTRINSICS_INVERTED",
            "EXTRINSICS_AXES",
            "EXTRINSICS_UNITS",
            "CAMERAS_SWAPPED",
            "DEPTH_UNITS",
        ],
        &[
            "SCALE_TOO_LARGE",
            "SCALE_TOO_SMALL",
            "UP_AXIS_WRONG",
            "BELOW_GROUND",
            "OBJECT_ABOVE_GROUND",
            "CAMERA_OFF",
            "CAMERAS_DISAGREE",
            "CAMERAS_SKEWED",
            "CLOCKS_DRIFT",
            "DEPTH_SCALE",
            "DEPTH_MISALIGNED",
            "FRAMES_SKIPPED",
            "MASKS_SWAPPED",
            "MOTION_TOO_FAST",
            "NO_CONTACT",
            "NOTHING_MOVES",
            "OBJECT_STILL",
            "MANIPULATOR_NOT_SEEN",
            "INTRINSICS_IMPLAUSIBLE",
        ],
    ),
    (
        &["DEPTH_SCALE"],
        &[
            "CLOCKS_DRIFT",
            "CAMERAS_SKEWED",
            "FRAMES_SKIPPED",
            "MOTION_TOO_FAST",
            "MASKS_SWAPPED",
            "DEPTH_MISALIGNED",
            "UP_AXIS_WRONG",
            "CAMERA_OFF",
            "CAMERAS_DISAGREE",
            "BELOW_GROUND",
            "SCALE_TOO_LARGE",
            "SCALE_TOO_SMALL",
            "NO_CONTACT",
        ],
    ),
    (&["CAMERAS_COINCIDE"], &["CAMERA_OFF", "CAMERAS_DISAGREE", "DEPTH_SCALE", "CAMERAS_SWAPPED"]),
    (&["UP_AXIS_WRONG"], &["BELOW_GROUND", "OBJECT_ABOVE_GROUND"]),
    (
        &["SCALE_TOO_LARGE", "SCALE_TOO_SMALL"],
        &[
            "OBJECT_ABOVE_GROUND",
            "BELOW_GROUND",
            "NO_CONTACT",
            "MOTION_TOO_FAST",
            "NOTHING_MOVES",
            "OBJECT_STILL",
        ],
    ),
    (
        &["MASKS_MISSING", "OBJECT_NOT_SEEN", "DEPTH_EMPTY", "CAMERA_EMPTY", "NO_FRAMES"],
        &[
            "NOTHING_MOVES",
            "OBJECT_STILL",
            "NO_CONTACT",
            "TRACKS_OFF_OBJECT",
            "MANIPULATOR_NOT_SEEN",
            "OBJECT_MASK_EMPTY",
            "DEPTH_UNITS",
            "DEPTH_SCALE",
            "CAMERA_OFF",
            "CAMERAS_DISAGREE",
            "TRACKS_LOST",
            "MASKS_SWAPPED",
        ],
    ),
    (
        &["MASK_COVERS_IMAGE"],
        &[
            "MASKS_OVERLAP",
            "DEPTH_MISALIGNED",
            "DEPTH_SPARSE",
            "CAMERAS_DISAGREE",
            "CAMERA_OFF",
            "OBJECT_STILL",
            "NOTHING_MOVES",
            "SCALE_TOO_LARGE",
            "DEPTH_SCALE",
            "DEPTH_UNITS",
            "CAMERAS_SKEWED",
            "BELOW_GROUND",
        ],
    ),
    (&["MASK_JUMPS"], &["FRAMES_SKIPPED", "MOTION_TOO_FAST"]),
    (
        &["INTRINSICS_IMPLAUSIBLE", "DEPTH_MISALIGNED"],
        &["CAMERAS_DISAGREE", "CAMERA_OFF", "CAMERAS_SKEWED", "CLOCKS_DRIFT"],
    ),
    (&["TRACKS_STILL"], &["TRACKS_OFF_OBJECT"]),
    (
        &["MASKS_SWAPPED"],
        &["OBJECT_ABOVE_GROUND", "CAMERAS_DISAGREE", "CAMERAS_SKEWED", "MASK_JUMPS"],
    ),
    (&["FRAMES_DROPPED", "FRAMES_DUPLICATED"], &["FRAMES_SKIPPED", "CLOCKS_DRIFT"]),
    (&["DEPTH_SPARSE"], &["FRAMES_SKIPPED"]),
    (
        &["DEPTH_FROZEN"],
        &[
            "DEPTH_SPARSE",
            "DEPTH_MISALIGNED",
            "CAMERAS_SKEWED",
            "CLOCKS_DRIFT",
            "CAMERA_OFF",
            "CAMERAS_DISAGREE",
        ],
    ),
    (&["NOTHING_MOVES"], &["OBJECT_STILL", "TRACKS_STILL"]),
    (&["CLOCKS_DRIFT"], &["CAMERAS_SKEWED", "FRAMES_SKIPPED"]),
    (&["TRACKS_TRANSPOSED", "TRACKS_NOT_FINITE"], &["TRACKS_OFF_OBJECT", "TRACKS_LOST"]),
    (
        &["ONE_FRAME", "NO_FRAMES"],
        &["NOTHING_MOVES", "OBJECT_STILL", "FEW_FRAMES", "SPLIT_EMPTY", "NO_CONTACT"],
    ),
];

fn leave_out_consequences(findings: &mut Vec<Finding>) {
    for (causes, consequences) in CONSEQUENCES {
        if findings.iter().any(|f| causes.contains(&f.code.as_str())) {
            findings.retain(|f| !consequences.contains(&f.code.as_str()));
        }
    }
}

/// `camera 2 (front)`, or `camera 2` if its name is its number.
pub(crate) fn named(recording: &Recording, index: usize) -> String {
    match recording.cameras.get(index).map(|c| c.name.as_str()) {
        Some(name) if !name.is_empty() && name != index.to_string() => {
            format!("camera {index} ({name})")
        }
        _ => format!("camera {index}"),
    }
}

#[cfg(test)]
mod tests;
