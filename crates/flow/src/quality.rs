//! Quality of tracks, from the tracker's own evidence.

use serde::{Deserialize, Serialize};

/// Quality of the tracks in one camera.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TrackerQuality {
    /// Points seeded on the object.
    pub object_points: usize,
    /// Points seeded on the manipulator.
    pub manipulator_points: usize,
    /// Points of the object that are tracked in each frame, shape [T].
    pub object_survivors: Vec<usize>,
    /// Points of the manipulator that are tracked in each frame, shape [T].
    pub manipulator_survivors: Vec<usize>,
    /// The cue by which the manipulator's points are followed; `None` without such points.
    pub manipulator_guide: Option<Guide>,
    /// Median over all tracked points and frames of the distance to its start of a point that is
    /// tracked to the next frame and back [px].
    pub forward_backward_px: Option<f64>,
    /// Median over all tracked points and frames of a point's distance from where the rigid motion
    /// of its neighbours puts it [m].
    pub deviation_m: Option<f64>,
    /// Median over all places of the object where seeds could lie: root mean square of the gradient
    /// in the direction in which it is weakest [grey levels of 255 per px].
    pub object_texture: Option<f64>,
    /// Texture of the manipulator.
    pub manipulator_texture: Option<f64>,
    /// Cameras in which background, or something farther away, is seen where more than three of ten
    /// of this camera's points are in the first frame. Its points were not checked against them any
    /// more.
    pub contradicted_by: Vec<usize>,
    /// Judgement of the object's texture.
    pub verdict: Texture,
    /// The verdict and what to do, in words.
    pub summary: String,
}

/// The cue by which points are followed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Guide {
    /// Each by its own texture.
    Texture,
    /// All of a rigid part by the part's shape: a hand in a plain glove, a smooth gripper. Rotation
    /// about an axis of symmetry remains unknown.
    Shape,
}

/// Judgement of a texture.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Texture {
    /// Points are located well within a pixel.
    Good,
    /// Enough to follow, not to rely on.
    Fair,
    /// Most of the surface cannot be followed.
    Poor,
    /// No points could be seeded.
    None,
}

/// Texture from which most points are located to a tenth of a pixel in images with the usual noise
/// of two grey levels.
const GOOD_TEXTURE: f64 = 6.0;

impl Texture {
    /// Judges a surface by its median texture and the share of its seeds that is tracked, averaged
    /// over the frames.
    pub(crate) fn judge(texture: Option<f64>, seeded: usize, kept: f64, min_texture: f64) -> Self {
        match texture {
            _ if seeded == 0 => Self::None,
            None => Self::None,
            Some(texture) if texture < min_texture => Self::Poor,
            Some(_) if kept < 0.1 => Self::Poor,
            Some(texture) if texture < GOOD_TEXTURE || kept < 0.25 => Self::Fair,
            Some(_) => Self::Good,
        }
    }

    /// The verdict in words.
    pub(crate) fn summary(self, camera: &str, contradicted_by: &[usize]) -> String {
        let advice = match self {
            Self::Good => "good texture: tracks can be relied on",
            Self::Fair => {
                "fair texture: tracks are usable, a learned tracker may keep more of them"
            }
            Self::Poor => {
                "poor texture: few points can be followed; use a learned tracker, more light, or put a pattern on the object"
            }
            Self::None => {
                "no texture to follow: give 2D tracks of another tracker, or put a pattern on the object"
            }
        };
        let mut words = format!("camera `{camera}`: {advice}");
        if !contradicted_by.is_empty() {
            let others: Vec<_> = contradicted_by.iter().map(usize::to_string).collect();
            words += &format!(
                "; it disagrees with camera {} about where the object is: check calibration and time stamps",
                others.join(", ")
            );
        }
        words
    }
}

/// Mean over frames of the share of points that survived.
pub(crate) fn mean_share(survivors: &[usize], points: usize) -> f64 {
    survivors.iter().sum::<usize>() as f64 / (survivors.len() * points).max(1) as f64
}
