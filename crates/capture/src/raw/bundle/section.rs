//! The `raw` section of `capture.json`: cameras, and where their frames lie.

use serde::{Deserialize, Serialize};

use crate::raw::{Alignment, Distortion, Intrinsics, Pose};

#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Section {
    pub(super) frame_count: usize,
    pub(super) train_frame_count: usize,
    pub(super) cameras: Vec<CameraEntry>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) mesh: Option<MeshEntry>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) truth_tracks: Option<String>,
    /// What counts of colour images with an EXIF orientation: `stored` or `shown`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) image_orientation: Option<String>,
}

#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct CameraEntry {
    #[serde(default)]
    pub(super) name: String,
    /// Columns, rows.
    pub(super) size: [usize; 2],
    pub(super) intrinsics: IntrinsicsEntry,
    #[serde(default)]
    pub(super) distortion: DistortionEntry,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) pose: Option<PoseEntry>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) poses: Option<String>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) times: Option<String>,
    /// Frames per second of its images, if it has fewer than the recording.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) fps: Option<f64>,
    /// Frame of the recording in which its image 0 was taken.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) frame_offset: Option<i64>,
    pub(super) color: String,
    pub(super) depth: DepthEntry,
    #[serde(default)]
    pub(super) masks: MasksEntry,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) tracks: Option<TracksEntry>,
}

#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(in crate::raw) struct IntrinsicsEntry {
    fx: f64,
    fy: f64,
    cx: f64,
    cy: f64,
}

#[derive(Debug, Default, Serialize, Deserialize)]
#[serde(tag = "model", rename_all = "snake_case", deny_unknown_fields)]
pub(in crate::raw) enum DistortionEntry {
    #[default]
    None,
    BrownConrady {
        coefficients: Vec<f64>,
    },
    KannalaBrandt {
        coefficients: [f64; 4],
    },
}

#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(in crate::raw) struct PoseEntry {
    rotation: [[f64; 3]; 3],
    translation: [f64; 3],
}

#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct DepthEntry {
    pub(super) files: String,
    /// Metres per stored number.
    pub(super) unit_m: f64,
    /// Columns, rows; those of colour if left out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) size: Option<[usize; 2]>,
    /// The depth camera's, if depth is not aligned to colour.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) intrinsics: Option<IntrinsicsEntry>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) distortion: Option<DistortionEntry>,
    /// From the depth camera to the colour camera, in the bundle's units.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) pose: Option<PoseEntry>,
}

#[derive(Debug, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct MasksEntry {
    #[serde(default)]
    pub(super) object: Vec<String>,
    #[serde(default)]
    pub(super) manipulator: Vec<String>,
}

#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct TracksEntry {
    pub(super) points: String,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) visible: Option<String>,
}

#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct MeshEntry {
    pub(super) file: String,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) to_world: Option<AlignmentEntry>,
}

#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct AlignmentEntry {
    pub(super) rotation: [[f32; 3]; 3],
    pub(super) scale: f32,
    pub(super) translation: [f32; 3],
}

impl From<&IntrinsicsEntry> for Intrinsics {
    fn from(e: &IntrinsicsEntry) -> Self {
        Self { fx: e.fx, fy: e.fy, cx: e.cx, cy: e.cy }
    }
}

impl From<Intrinsics> for IntrinsicsEntry {
    fn from(i: Intrinsics) -> Self {
        Self { fx: i.fx, fy: i.fy, cx: i.cx, cy: i.cy }
    }
}

impl DistortionEntry {
    /// `None` where there are more coefficients than the model has.
    pub(in crate::raw) fn read(&self) -> Option<Distortion> {
        match self {
            Self::None => Some(Distortion::None),
            Self::BrownConrady { coefficients } => Distortion::brown_conrady(coefficients),
            Self::KannalaBrandt { coefficients } => Some(Distortion::KannalaBrandt(*coefficients)),
        }
    }
}

impl From<Distortion> for DistortionEntry {
    fn from(d: Distortion) -> Self {
        match d {
            Distortion::None => Self::None,
            Distortion::BrownConrady(k) => Self::BrownConrady { coefficients: k.to_vec() },
            Distortion::KannalaBrandt(k) => Self::KannalaBrandt { coefficients: k },
        }
    }
}

impl From<&PoseEntry> for Pose {
    fn from(e: &PoseEntry) -> Self {
        Self { rotation: e.rotation, translation: e.translation }
    }
}

impl From<&Pose> for PoseEntry {
    fn from(p: &Pose) -> Self {
        Self { rotation: p.rotation, translation: p.translation }
    }
}

impl From<Alignment> for AlignmentEntry {
    fn from(a: Alignment) -> Self {
        Self { rotation: a.rotation, scale: a.scale, translation: a.translation }
    }
}
