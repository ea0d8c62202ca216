//! The evidence of an ingest: its measurements and decisions, as material for the capture's report.

use bendtwin_core::Finding;
use bendtwin_flow::TrackerQuality;
use serde::{Deserialize, Serialize};

/// The evidence of how an observation was made.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Evidence {
    /// Per camera, in the recording's order.
    pub cameras: Vec<CameraEvidence>,
    /// The object's tracks.
    pub tracks: TrackEvidence,
    /// Hands or grippers, as the controls are grouped.
    pub hands: Vec<HandEvidence>,
    /// The completed shape, if there is one.
    pub shape: Option<ShapeEvidence>,
    /// Findings for the capture's owner.
    pub findings: Vec<Finding>,
}

/// Evidence of a camera.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct CameraEvidence {
    /// Name of the camera.
    pub name: String,
    /// 2D tracks.
    pub tracks: usize,
    /// The built-in tracker's judgement of its tracks; `None` where the recording brought tracks.
    pub tracker: Option<TrackerQuality>,
    /// Frames without a depth image.
    pub missing_frames: usize,
    /// Object's mask, pixels of all frames.
    pub object: MaskCounts,
    /// Manipulator's mask, pixels of all frames.
    pub manipulator: MaskCounts,
    /// Tracks, times all frames.
    pub lifts: LiftCounts,
}

/// Counts of a mask's pixels, by the step that dropped them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct MaskCounts {
    /// Frames with a mask.
    pub frames: u64,
    /// Frames whose mask exists and is empty.
    pub empty_frames: u64,
    /// Pixels of the mask.
    pub pixels: u64,
    /// Without depth, or with one out of range.
    pub no_depth: u64,
    /// With too few neighbours on the same surface: flying pixels at edges, outliers.
    pub flying: u64,
    /// In small parts, far from the larger ones.
    pub specks: u64,
    /// Nearer to what the other mask shows.
    pub contact: u64,
    /// Left over.
    pub kept: u64,
}

/// Counts of 2D tracks, times frames, by what became of them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct LiftCounts {
    /// Lifted onto the object.
    pub object: u64,
    /// Lifted onto a manipulator.
    pub manipulator: u64,
    /// The frame was not recorded.
    pub no_frame: u64,
    /// The tracker did not see it.
    pub hidden: u64,
    /// Outside the image.
    pub outside: u64,
    /// On neither cleaned mask: background, an edge, or no depth.
    pub off_mask: u64,
    /// Too few pixels of one surface around it.
    pub unsupported: u64,
}

/// The object's tracks.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct TrackEvidence {
    /// Tracks of all cameras that lie on the object in the first frame.
    pub on_object: usize,
    /// Tracks dropped because a longer one was within the spacing.
    pub thinned: usize,
    /// Tracks dropped because they disagreed with their neighbours most of the time.
    pub unreliable: usize,
    /// The capture's points.
    pub kept: usize,
    /// Share of the kept points that is seen, shape [T].
    pub seen: Vec<f32>,
    /// Share of the kept points whose motion is valid, shape [T].
    pub motion_valid: Vec<f32>,
    /// Share of sightings given up because the point had drifted from its spot.
    pub drifted: f64,
    /// Share of motions between two sightings that the neighbours do not confirm.
    pub unconfirmed: f64,
    /// Median distance between where points were seen and where the motion of their neighbours puts
    /// them, frame to frame [m]: the noise.
    pub motion_residual_m: f64,
}

/// A hand or gripper.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct HandEvidence {
    /// Tracks on it in the first frame.
    pub tracks: usize,
    /// Tracks seen in every frame, with short gaps filled.
    pub surviving: usize,
    /// Control points on it.
    pub controls: usize,
    /// Control points close enough to the object in the first frame to hold it in a fit.
    pub holding: usize,
    /// Median distance of tracks from a rigid motion [m].
    pub residual_m: f64,
    /// 95th percentile of that [m].
    pub residual_p95_m: f64,
    /// True if its control points were made to move as a rigid body.
    pub rigid: bool,
    /// True if its motion was taken from its shape, since there are no tracks on it; residuals are
    /// then distances from that.
    pub by_shape: bool,
    /// Frames in which its pose was filled in from the frames around.
    pub filled_frames: usize,
}

/// The completed shape.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ShapeEvidence {
    /// Source of the shape: the mesh's file name, `carved` or `convex`.
    pub source: String,
    /// True if it was aligned here.
    pub aligned: bool,
    /// Metres per unit of the mesh.
    pub scale: f64,
    /// Median distance of the observed surface from it [m].
    pub error_m: f64,
    /// 90th percentile of that [m].
    pub error_p90_m: f64,
    /// Points on its surface that were sampled.
    pub sampled_surface: usize,
    /// Cells of a carved shape that hands hide.
    pub under_hands: usize,
    /// Points on its surface that became part of the capture: those that no camera saw.
    pub surface: usize,
    /// Points inside that became part of the capture.
    pub interior: usize,
}

impl MaskCounts {
    pub(crate) fn add(&mut self, other: &Self) {
        self.frames += other.frames;
        self.empty_frames += other.empty_frames;
        self.pixels += other.pixels;
        self.no_depth += other.no_depth;
        self.flying += other.flying;
        self.specks += other.specks;
        self.contact += other.contact;
        self.kept += other.kept;
    }
}

impl LiftCounts {
    pub(crate) fn add(&mut self, other: &Self) {
        self.object += other.object;
        self.manipulator += other.manipulator;
        self.no_frame += other.no_frame;
        self.hidden += other.hidden;
        self.outside += other.outside;
        self.off_mask += other.off_mask;
        self.unsupported += other.unsupported;
    }
}
