//! Findings that merely follow from another finding: they are left out, so that a capture with one
//! fault has one finding, whichever judge found it. The cause names their codes.

use bendtwin_core::Finding;

use Strength::{Certain, Likely};

/// Certainty with which one finding explains another.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Strength {
    /// Explains a worse finding too, and takes over its severity.
    Certain,
    /// Explains no finding worse than itself.
    Likely,
}

/// Codes of a fault, and the codes that follow from it.
type Rule = (Strength, &'static [&'static str], &'static [&'static str]);

/// The rules, applied in this order: a fault that is left out itself leaves out nothing.
const RULES: &[Rule] = &[
    (
        Certain,
        &["CAMERA_EMPTY", "NO_FRAMES", "MASKS_MISSING", "OBJECT_NOT_SEEN", "DEPTH_EMPTY"],
        &[
            "NOTHING_MOVES",
            "OBJECT_STILL",
            "NO_CONTACT",
            "TRACKS_OFF_OBJECT",
            "MANIPULATOR_NOT_SEEN",
            "OBJECT_MASK_EMPTY",
            "OBJECT_NOT_TRACKED",
            "DEPTH_UNITS",
            "DEPTH_SCALE",
            "DEPTH_FROZEN",
            "DEPTH_MISALIGNED",
            "MASKS_MISALIGNED",
            "COLOR_MISALIGNED",
            "CAMERA_OFF",
            "CAMERAS_DISAGREE",
            "TRACKS_LOST",
            "MASKS_SWAPPED",
        ],
    ),
    (Certain, &["CAMERA_EMPTY"], &["DEPTH_EMPTY"]),
    (
        Certain,
        &["MASK_COVERS_IMAGE"],
        &[
            "MASKS_OVERLAP",
            "MASKS_SWAPPED",
            "MASK_SHOWS_BACKGROUND",
            "DEPTH_INVERTED",
            "DEPTH_MISALIGNED",
            "MASKS_MISALIGNED",
            "COLOR_MISALIGNED",
            "DEPTH_SPARSE",
            "DEPTH_SCALE",
            "DEPTH_UNITS",
            "CAMERAS_DISAGREE",
            "CAMERA_OFF",
            "CAMERAS_SKEWED",
            "CLOCKS_DRIFT",
            "FRAMES_SKIPPED",
            "OBJECT_STILL",
            "NOTHING_MOVES",
            "OBJECT_NOT_TRACKED",
            "TRACKS_LOST",
            "SCALE_TOO_LARGE",
            "BELOW_GROUND",
        ],
    ),
    (
        Certain,
        &["MASKS_OVERLAP"],
        &[
            "OBJECT_NOT_TRACKED",
            "TRACKS_OFF_OBJECT",
            "CLOCKS_DRIFT",
            "FRAMES_SKIPPED",
            "DEPTH_MISALIGNED",
            "MASKS_MISALIGNED",
        ],
    ),
    (
        Certain,
        &["DEPTH_FROZEN", "MASKS_SWAPPED", "MASK_JUMPS"],
        &["DEPTH_MISALIGNED", "MASKS_MISALIGNED", "COLOR_MISALIGNED"],
    ),
    (
        Certain,
        &["INTRINSICS_IMPLAUSIBLE"],
        &[
            "SCALE_TOO_LARGE",
            "SCALE_TOO_SMALL",
            "BELOW_GROUND",
            "OBJECT_ABOVE_GROUND",
            "CAMERAS_DISAGREE",
            "CAMERA_OFF",
            "CAMERAS_SKEWED",
            "CLOCKS_DRIFT",
            "NO_CONTACT",
            "MOTION_TOO_FAST",
        ],
    ),
    (
        Certain,
        &["DEPTH_INVERTED", "DEPTH_MISALIGNED", "MASKS_MISALIGNED"],
        &[
            "MASK_SHOWS_BACKGROUND",
            "DEPTH_SPARSE",
            "DEPTH_UNITS",
            "DEPTH_SCALE",
            "CAMERA_OFF",
            "CAMERAS_DISAGREE",
            "CAMERAS_SKEWED",
            "CLOCKS_DRIFT",
            "FRAMES_SKIPPED",
            "MASKS_SWAPPED",
            "MOTION_TOO_FAST",
            "SCALE_TOO_LARGE",
            "BELOW_GROUND",
            "NO_CONTACT",
            "HAND_LOST",
            "HAND_NOT_TRACKED",
            "TRACKS_LOST",
            "TRACKS_OFF_OBJECT",
            "OBJECT_NOT_TRACKED",
        ],
    ),
    (
        Certain,
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
            "MASK_SHOWS_BACKGROUND",
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
        Certain,
        &["DEPTH_SCALE"],
        &[
            "CLOCKS_DRIFT",
            "CAMERAS_SKEWED",
            "FRAMES_SKIPPED",
            "MOTION_TOO_FAST",
            "MASKS_SWAPPED",
            "MASK_SHOWS_BACKGROUND",
            "UP_AXIS_WRONG",
            "CAMERA_OFF",
            "CAMERAS_DISAGREE",
            "BELOW_GROUND",
            "SCALE_TOO_LARGE",
            "SCALE_TOO_SMALL",
            "NO_CONTACT",
        ],
    ),
    (
        Certain,
        &["CAMERAS_COINCIDE"],
        &[
            "CAMERA_OFF",
            "CAMERAS_DISAGREE",
            "DEPTH_SCALE",
            "CAMERAS_SWAPPED",
            "CAMERAS_SKEWED",
            "CLOCKS_DRIFT",
        ],
    ),
    (
        Certain,
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
    (Certain, &["GRAVITY_DIRECTION"], &["UP_AXIS_WRONG"]),
    (Certain, &["UP_AXIS_WRONG"], &["BELOW_GROUND", "OBJECT_ABOVE_GROUND"]),
    (
        Certain,
        &["ONE_FRAME", "NO_FRAMES"],
        &["NOTHING_MOVES", "OBJECT_STILL", "FEW_FRAMES", "SPLIT_EMPTY", "NO_CONTACT"],
    ),
    (Certain, &["FEW_FRAMES"], &["NOTHING_MOVES", "OBJECT_STILL"]),
    (Certain, &["SPLIT_EMPTY"], &["TRACKS_LOST"]),
    (Certain, &["NOTHING_MOVES"], &["OBJECT_STILL", "TRACKS_STILL"]),
    (
        Certain,
        &[
            "MASKS_SWAPPED",
            "TRACKS_TRANSPOSED",
            "TRACKS_NOT_FINITE",
            "TRACKS_OFF_OBJECT",
            "COLOR_MISALIGNED",
        ],
        &["TRACKS_LOST", "OBJECT_NOT_TRACKED"],
    ),
    (Likely, &["TRACKS_TRANSPOSED", "TRACKS_NOT_FINITE", "TRACKS_STILL"], &["TRACKS_OFF_OBJECT"]),
    (Likely, &["COLOR_MISALIGNED"], &["TRACKS_OFF_OBJECT"]),
    (Likely, &["OBJECT_MASK_EMPTY"], &["TRACKS_OFF_OBJECT", "TRACKS_LOST"]),
    (Likely, &["FRAMES_DROPPED"], &["TRACKS_LOST", "OBJECT_NOT_TRACKED"]),
    (Likely, &["OBJECT_NOT_TRACKED"], &["TRACKS_LOST", "OBJECT_MASK_EMPTY", "HAND_NOT_TRACKED"]),
    (Likely, &["DEPTH_FILLED"], &["DEPTH_SPARSE", "MASK_SHOWS_BACKGROUND"]),
    (Likely, &["MASK_JUMPS"], &["FRAMES_SKIPPED", "MOTION_TOO_FAST"]),
    (
        Likely,
        &["MASK_SHOWS_BACKGROUND"],
        &["CAMERAS_DISAGREE", "CAMERA_OFF", "CAMERAS_SKEWED", "CLOCKS_DRIFT"],
    ),
    (
        Likely,
        &["MASKS_SWAPPED"],
        &[
            "OBJECT_ABOVE_GROUND",
            "CAMERAS_DISAGREE",
            "CAMERAS_SKEWED",
            "CLOCKS_DRIFT",
            "MASK_JUMPS",
            "TRACKS_OFF_OBJECT",
        ],
    ),
    (
        Likely,
        &["DEPTH_FROZEN", "COLOR_FROZEN"],
        &[
            "DEPTH_SPARSE",
            "MASK_SHOWS_BACKGROUND",
            "CAMERAS_SKEWED",
            "CLOCKS_DRIFT",
            "CAMERA_OFF",
            "CAMERAS_DISAGREE",
        ],
    ),
    (Likely, &["FRAMES_DROPPED", "FRAMES_DUPLICATED"], &["FRAMES_SKIPPED", "CLOCKS_DRIFT"]),
    (Likely, &["CAMERAS_SKEWED"], &["CAMERA_OFF", "CAMERAS_DISAGREE"]),
    (Likely, &["CLOCKS_DRIFT"], &["CAMERAS_SKEWED", "FRAMES_SKIPPED"]),
    (Likely, &["DEPTH_SPARSE"], &["FRAMES_SKIPPED", "CLOCKS_DRIFT"]),
    (Likely, &["MOTION_TOO_FAST"], &["FRAMES_SKIPPED"]),
];

/// Leaves out what follows from another finding, which names it.
pub(crate) fn leave_out(findings: &mut Vec<Finding>) {
    for (strength, causes, consequences) in RULES {
        let is_cause = |f: &Finding| causes.contains(&f.code.as_str());
        let known = findings.iter().filter(|f| is_cause(f));
        let Some(worst) = known.map(|f| f.severity).min() else { continue };
        let follows = |f: &Finding| {
            consequences.contains(&f.code.as_str()) && (*strength == Certain || f.severity >= worst)
        };
        let left_out: Vec<Finding> = findings.extract_if(.., |f| follows(f)).collect();
        // The first of the worst stands for all.
        let cause = findings.iter_mut().filter(|f| is_cause(f)).min_by_key(|f| f.severity);
        let (Some(cause), false) = (cause, left_out.is_empty()) else { continue };
        for finding in left_out {
            cause.severity = cause.severity.min(finding.severity);
            for code in std::iter::once(finding.code).chain(finding.consequences) {
                if !cause.consequences.contains(&code) {
                    cause.consequences.push(code);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests;
