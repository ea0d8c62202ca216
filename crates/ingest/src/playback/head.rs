//! The head of a playback: what there is, and where in the data it lies. `docs/formats/playback.md` specifies
//! it for other programs.

use bendtwin_capture::raw::{Camera, Distortion};
use serde::Serialize;

/// Name of the format.
pub(super) const FORMAT: &str = "bendtwin-playback";
/// Version of the format.
pub(super) const VERSION: u32 = 1;
/// Longest name [characters]: names come from captures.
const MAX_NAME: usize = 200;

/// Bytes of the data: the first, and how many. The data begins after the head.
pub(super) type Range = [u64; 2];

#[derive(Serialize)]
pub(super) struct Head {
    pub(super) format: &'static str,
    pub(super) version: u32,
    pub(super) name: String,
    pub(super) sequences: Vec<SequenceEntry>,
    /// Sequences that did not fit, the last ones.
    pub(super) left_out: usize,
}

#[derive(Serialize)]
pub(super) struct SequenceEntry {
    /// Index of the recording that it belongs to.
    pub(super) recording: usize,
    pub(super) recording_name: String,
    pub(super) name: String,
    pub(super) fps: f64,
    pub(super) frame_count: usize,
    pub(super) train_frame_count: usize,
    pub(super) start_frame: usize,
    pub(super) ground: Option<GroundEntry>,
    /// Tracked points of the observation, of which `motion.point_count` are here.
    pub(super) observed_points: usize,
    pub(super) motion: MotionEntry,
    pub(super) cameras: Vec<CameraEntry>,
}

#[derive(Serialize)]
pub(super) struct GroundEntry {
    pub(super) normal: [f32; 3],
    pub(super) offset_m: f32,
}

/// Points and control points of a sequence, in the world: `origin + scale_m * number`.
#[derive(Serialize)]
pub(super) struct MotionEntry {
    pub(super) point_count: usize,
    pub(super) control_count: usize,
    pub(super) origin: [f64; 3],
    pub(super) scale_m: f64,
    /// int16 [T, P, 3].
    pub(super) points: Range,
    /// Bits [T, ceil(P / 8)], the lowest first.
    pub(super) visible: Range,
    /// int16 [T, C, 3].
    pub(super) controls: Range,
    /// The hand of each control point [C]; empty if unknown.
    pub(super) control_hands: Vec<u32>,
    /// Bytes [P, 3]; none if unknown.
    pub(super) colors: Option<Range>,
}

#[derive(Serialize)]
pub(super) struct CameraEntry {
    name: String,
    /// Columns and rows of the recorded images, which the intrinsics are for.
    size: [usize; 2],
    intrinsics: IntrinsicsEntry,
    distortion: DistortionEntry,
    /// float32 [1 or K, 3, 4]: camera to world, of a camera that moves by image.
    pub(super) poses: Range,
    pub(super) images: ImagesEntry,
    /// Masks of the images, if there are any.
    pub(super) masks: Option<MasksEntry>,
    /// Doubt of the masks that were made from strokes [T], 0..=1; absent for others.
    pub(super) doubt: Option<Vec<Option<f32>>>,
}

#[derive(Serialize)]
struct IntrinsicsEntry {
    fx: f64,
    fy: f64,
    cx: f64,
    cy: f64,
}

#[derive(Serialize)]
struct DistortionEntry {
    model: &'static str,
    coefficients: Vec<f64>,
}

/// JPEG files of a camera, one behind the other.
#[derive(Serialize)]
pub(super) struct ImagesEntry {
    /// Columns and rows.
    pub(super) size: [usize; 2],
    /// Image k is of frame `k * every`.
    pub(super) every: usize,
    /// Length of each image [bytes]; 0 for missing ones.
    pub(super) lengths: Vec<usize>,
    /// All of them.
    pub(super) bytes: Range,
}

/// Masks of a camera as run lengths, one behind the other.
#[derive(Serialize)]
pub(super) struct MasksEntry {
    /// Length of the runs of each image [bytes]; 0 where there is no mask.
    pub(super) lengths: Vec<usize>,
    /// All of them.
    pub(super) bytes: Range,
}

impl CameraEntry {
    pub(super) fn new(
        camera: &Camera,
        poses: Range,
        images: ImagesEntry,
        masks: Option<MasksEntry>,
        doubt: Option<Vec<Option<f32>>>,
    ) -> Self {
        let i = camera.intrinsics;
        let (model, coefficients) = match camera.distortion {
            Distortion::None => ("none", Vec::new()),
            Distortion::BrownConrady(k) => ("brown_conrady", k.to_vec()),
            Distortion::KannalaBrandt(k) => ("kannala_brandt", k.to_vec()),
        };
        Self {
            name: short(&camera.name),
            size: [camera.width, camera.height],
            intrinsics: IntrinsicsEntry { fx: i.fx, fy: i.fy, cx: i.cx, cy: i.cy },
            distortion: DistortionEntry { model, coefficients },
            poses,
            images,
            masks,
            doubt,
        }
    }
}

/// A name that is no longer than it may be.
pub(super) fn short(name: &str) -> String {
    name.chars().take(MAX_NAME).collect()
}
