//! Findings that merely follow from another finding: they are left out, so that a capture with one
//! fault has one finding, whichever judge found it. The cause names their codes. What one fault does to
//! several cameras is one finding, too: see `alike`.

use bendtwin_core::{Finding, Severity};

use crate::codes::Code::{self, *};
use Strength::{Certain, Likely, Severe};

/// Certainty with which one finding explains another.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Strength {
    /// Explains a worse finding too, and takes over its severity.
    Certain,
    /// Explains no finding worse than itself.
    Likely,
    /// Explains anything about the same cameras, or about all, if it is an error itself.
    Severe,
}

/// Codes of a fault, and the codes that follow from it.
type Rule = (Strength, &'static [Code], &'static [Code]);

/// The rules, applied in this order: a fault that is left out itself leaves out nothing.
const RULES: &[Rule] = &[
    (
        Certain,
        &[CameraEmpty, NoFrames, MasksMissing, ObjectNotSeen, DepthEmpty],
        &[
            NothingMoves,
            ObjectStill,
            NoContact,
            TracksOffObject,
            ManipulatorNotSeen,
            ObjectMaskEmpty,
            ObjectNotTracked,
            DepthUnits,
            DepthScale,
            DepthFrozen,
            DepthMisaligned,
            MasksMisaligned,
            ColorMisaligned,
            CameraOff,
            CamerasDisagree,
            TracksLost,
            MasksSwapped,
            HandLost,
            HandNotTracked,
        ],
    ),
    (Certain, &[CameraEmpty], &[DepthEmpty]),
    // Nothing can be followed without masks.
    (
        Certain,
        &[MasksNotFollowed],
        &[
            NothingMoves,
            ObjectStill,
            NoContact,
            TracksOffObject,
            TracksLost,
            ManipulatorNotSeen,
            ObjectMaskEmpty,
            ObjectNotSeen,
            ObjectNotTracked,
            HandLost,
            HandNotTracked,
            TracksStill,
            DepthEmpty,
            DepthMisaligned,
            MasksMisaligned,
            ColorMisaligned,
            CamerasDisagree,
            CamerasSkewed,
            ClocksDrift,
            FramesSkipped,
            MotionTooFast,
        ],
    ),
    // A camera whose files are damaged throughout has no frames, no masks or no depth.
    (
        Severe,
        &[FramesDamaged],
        &[
            CameraEmpty,
            FramesDropped,
            FramesDuplicated,
            CameraSlower,
            MasksMissing,
            MasksNotFollowed,
            ObjectNotSeen,
            ManipulatorNotSeen,
            ObjectMaskEmpty,
            MaskJumps,
            DepthEmpty,
            DepthSparse,
            HandLost,
            HandNotTracked,
            ObjectNotTracked,
            TracksLost,
            TracksMissing,
            NothingMoves,
            ObjectStill,
            NoContact,
        ],
    ),
    (Likely, &[FramesDamaged], &[ObjectMaskEmpty, TracksMissing]),
    (
        Certain,
        &[MaskCoversImage],
        &[
            MasksOverlap,
            MasksSwapped,
            MaskShowsBackground,
            DepthInverted,
            DepthMisaligned,
            MasksMisaligned,
            ColorMisaligned,
            DepthSparse,
            DepthScale,
            DepthUnits,
            CamerasDisagree,
            CameraOff,
            CamerasSkewed,
            ClocksDrift,
            FramesSkipped,
            ObjectStill,
            NothingMoves,
            ObjectNotTracked,
            TracksLost,
            ScaleTooLarge,
            BelowGround,
        ],
    ),
    (
        Certain,
        &[MasksOverlap],
        &[
            ObjectNotTracked,
            TracksOffObject,
            ClocksDrift,
            FramesSkipped,
            DepthMisaligned,
            MasksMisaligned,
        ],
    ),
    (
        Certain,
        &[DepthFrozen, MasksSwapped, MaskJumps],
        &[DepthMisaligned, MasksMisaligned, ColorMisaligned],
    ),
    (
        Certain,
        &[IntrinsicsImplausible],
        &[
            ScaleTooLarge,
            ScaleTooSmall,
            BelowGround,
            ObjectAboveGround,
            CamerasDisagree,
            CameraOff,
            CamerasSkewed,
            ClocksDrift,
            NoContact,
            MotionTooFast,
        ],
    ),
    (
        Certain,
        &[DepthInverted, DepthMisaligned, MasksMisaligned],
        &[
            MaskShowsBackground,
            DepthSparse,
            DepthUnits,
            DepthScale,
            CameraOff,
            CamerasDisagree,
            CamerasSkewed,
            ClocksDrift,
            FramesSkipped,
            MasksSwapped,
            MotionTooFast,
            ScaleTooLarge,
            BelowGround,
            NoContact,
            HandLost,
            HandNotTracked,
            TracksLost,
            TracksOffObject,
            ObjectNotTracked,
        ],
    ),
    (
        Certain,
        &[
            IntrinsicsInvalid,
            ExtrinsicsInvalid,
            ExtrinsicsMirrored,
            ExtrinsicsInverted,
            ExtrinsicsAxes,
            ExtrinsicsUnits,
            CamerasSwapped,
            DepthUnits,
        ],
        &[
            ScaleTooLarge,
            ScaleTooSmall,
            UpAxisWrong,
            BelowGround,
            ObjectAboveGround,
            CameraOff,
            CamerasDisagree,
            CamerasSkewed,
            ClocksDrift,
            DepthScale,
            MaskShowsBackground,
            FramesSkipped,
            MasksSwapped,
            MotionTooFast,
            NoContact,
            NothingMoves,
            ObjectStill,
            ManipulatorNotSeen,
            IntrinsicsImplausible,
        ],
    ),
    (
        Certain,
        &[DepthScale],
        &[
            ClocksDrift,
            CamerasSkewed,
            FramesSkipped,
            MotionTooFast,
            MasksSwapped,
            MaskShowsBackground,
            UpAxisWrong,
            CameraOff,
            CamerasDisagree,
            BelowGround,
            ScaleTooLarge,
            ScaleTooSmall,
            NoContact,
        ],
    ),
    (
        Certain,
        &[CamerasCoincide],
        &[CameraOff, CamerasDisagree, DepthScale, CamerasSwapped, CamerasSkewed, ClocksDrift],
    ),
    (
        Certain,
        &[ScaleTooLarge, ScaleTooSmall],
        &[ObjectAboveGround, BelowGround, NoContact, MotionTooFast, NothingMoves, ObjectStill],
    ),
    (Certain, &[GravityDirection], &[UpAxisWrong]),
    (Certain, &[UpAxisWrong], &[BelowGround, ObjectAboveGround]),
    (
        Certain,
        &[OneFrame, NoFrames],
        &[NothingMoves, ObjectStill, FewFrames, SplitEmpty, NoContact],
    ),
    (Certain, &[FewFrames], &[NothingMoves, ObjectStill]),
    (Certain, &[SplitEmpty], &[TracksLost]),
    (Certain, &[NothingMoves], &[ObjectStill, TracksStill]),
    (
        Certain,
        &[MasksSwapped, TracksTransposed, TracksNotFinite, TracksOffObject, ColorMisaligned],
        &[TracksLost, ObjectNotTracked],
    ),
    (Likely, &[TracksTransposed, TracksNotFinite, TracksStill], &[TracksOffObject]),
    (Likely, &[ColorMisaligned], &[TracksOffObject]),
    (Likely, &[ObjectMaskEmpty], &[TracksOffObject, TracksLost]),
    (Likely, &[FramesDropped], &[TracksLost, ObjectNotTracked]),
    (Likely, &[ObjectNotTracked], &[TracksLost, ObjectMaskEmpty, HandNotTracked]),
    (Likely, &[DepthFilled], &[DepthSparse, MaskShowsBackground]),
    (Likely, &[MaskJumps], &[FramesSkipped, MotionTooFast]),
    (Likely, &[MaskShowsBackground], &[CamerasDisagree, CameraOff, CamerasSkewed, ClocksDrift]),
    (
        Likely,
        &[MasksSwapped],
        &[
            ObjectAboveGround,
            CamerasDisagree,
            CamerasSkewed,
            ClocksDrift,
            MaskJumps,
            TracksOffObject,
        ],
    ),
    (
        Likely,
        &[DepthFrozen, ColorFrozen],
        &[DepthSparse, MaskShowsBackground, CamerasSkewed, ClocksDrift, CameraOff, CamerasDisagree],
    ),
    (
        Certain,
        &[CameraRateUnclear],
        &[
            CamerasSkewed,
            ClocksDrift,
            FramesSkipped,
            FramesDropped,
            CameraOff,
            CamerasDisagree,
            DepthScale,
            MotionTooFast,
            MaskShowsBackground,
            ObjectNotTracked,
            TracksLost,
            HandLost,
        ],
    ),
    (
        Likely,
        &[FramesDropped, FramesDuplicated],
        &[FramesSkipped, ClocksDrift, FramesLate, MotionTooFast],
    ),
    // Repeats show what was a frame before.
    (Likely, &[FramesDuplicated], &[CamerasSkewed, CameraOff, CamerasDisagree, DepthFrozen]),
    (Likely, &[ManipulatorNotSeen], &[ObjectStill]),
    (Likely, &[CamerasSkewed], &[CameraOff, CamerasDisagree]),
    (Likely, &[ClocksDrift], &[CamerasSkewed, FramesSkipped]),
    (Likely, &[DepthSparse], &[FramesSkipped, ClocksDrift]),
    (Likely, &[MotionTooFast], &[FramesSkipped]),
];

/// Leaves out what follows from another finding, which names it.
pub(crate) fn leave_out(findings: &mut Vec<Finding>) {
    for (strength, causes, consequences) in RULES {
        let is_one = |f: &Finding, of: &[Code]| of.iter().any(|code| code.name() == f.code);
        let is_cause = |f: &Finding| {
            is_one(f, causes) && (*strength != Severe || f.severity == Severity::Error)
        };
        let known: Vec<Finding> = findings.iter().filter(|f| is_cause(f)).cloned().collect();
        let Some(worst) = known.iter().map(|f| f.severity).min() else { continue };
        let follows = |f: &Finding| {
            is_one(f, consequences)
                && match strength {
                    Certain => true,
                    Likely => f.severity >= worst,
                    Severe => concerns(&known, f),
                }
        };
        let left_out: Vec<Finding> = findings.extract_if(.., |f| follows(f)).collect();
        // The first of the worst stands for all.
        let cause = findings.iter_mut().filter(|f| is_cause(f)).min_by_key(|f| f.severity);
        let (Some(cause), false) = (cause, left_out.is_empty()) else { continue };
        left_out.into_iter().for_each(|finding| absorb(cause, finding));
    }
    leave_out_named(findings);
}

/// True if one of the causes concerns every camera of a finding.
fn concerns(causes: &[Finding], finding: &Finding) -> bool {
    let explained = |camera: &usize| causes.iter().any(|cause| cause.cameras.contains(camera));
    finding.cameras.iter().all(explained)
}

/// Leaves out findings whose codes another one about the same cameras names as its consequences, if it
/// is as severe: a reader names what follows from its own findings.
fn leave_out_named(findings: &mut Vec<Finding>) {
    let causes: Vec<Finding> =
        findings.iter().filter(|f| !f.consequences.is_empty()).cloned().collect();
    findings.retain(|f| {
        !causes.iter().any(|cause| {
            cause.consequences.contains(&f.code)
                && cause.severity <= f.severity
                && concerns(std::slice::from_ref(cause), f)
        })
    });
}

/// Makes a finding a consequence of another, with what followed from it.
fn absorb(cause: &mut Finding, finding: Finding) {
    cause.severity = cause.severity.min(finding.severity);
    for code in std::iter::once(finding.code).chain(finding.consequences) {
        if !cause.consequences.contains(&code) {
            cause.consequences.push(code);
        }
    }
}

#[cfg(test)]
mod tests;
