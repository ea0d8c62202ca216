//! The numbers that judgements are made by: one struct for each judge, one field for each number.
//!
//! They are passed as a value, so that a test can vary one and see what it decides. Each field says
//! its unit and where its number comes from. *Chosen by hand* means that no measurement stands
//! behind it but this: with all of these numbers, each of the 236 recordings of `tests/broken` gets
//! the diagnosis that belongs to it, and the healthy ones get none. *Healthy recordings* are the
//! made recordings without a fault of `tests/broken` and of this crate's own tests, as measured by
//! [`crate::inspect()`].

mod agreement;
mod alignment;
mod calibration;
mod consistency;
mod depth;
mod labels;
mod masks;
mod motion;
mod outline;
mod recording;
mod scale;
mod scan;
mod skew;
mod start;
mod timing;
mod tracks;

pub(crate) use self::{
    agreement::AgreementThresholds, alignment::AlignmentThresholds,
    calibration::CalibrationThresholds, consistency::ConsistencyThresholds, depth::DepthThresholds,
    labels::LabelThresholds, masks::MaskThresholds, motion::MotionThresholds,
    outline::OutlineThresholds, recording::RecordingThresholds, scale::ScaleThresholds,
    scan::ScanThresholds, skew::SkewThresholds, start::StartThresholds, timing::TimingThresholds,
    tracks::TrackThresholds,
};

/// The thresholds of all judges.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Thresholds {
    /// Length, frame rate, damaged files.
    pub(crate) recording: RecordingThresholds,
    /// Intrinsics and poses, each for itself.
    pub(crate) calibration: CalibrationThresholds,
    /// Dropped, repeated, frozen and late frames.
    pub(crate) timing: TimingThresholds,
    /// Masks of each camera.
    pub(crate) masks: MaskThresholds,
    /// Depth over the object.
    pub(crate) depth: DepthThresholds,
    /// Sizes and heights.
    pub(crate) scale: ScaleThresholds,
    /// Motion and contact.
    pub(crate) motion: MotionThresholds,
    /// Depth and colour at the outlines of masks.
    pub(crate) outline: OutlineThresholds,
    /// Depth, colour and masks on one grid.
    pub(crate) alignment: AlignmentThresholds,
    /// Requirements of lifting.
    pub(crate) start: StartThresholds,
    /// Skew by motion.
    pub(crate) skew: SkewThresholds,
    /// Cameras that disagree.
    pub(crate) agreement: AgreementThresholds,
    /// Masks that are exchanged.
    pub(crate) labels: LabelThresholds,
    /// 2D tracks.
    pub(crate) tracks: TrackThresholds,
    /// Misfit between views.
    pub(crate) consistency: ConsistencyThresholds,
    /// Measurements of a single image.
    pub(crate) scan: ScanThresholds,
}
