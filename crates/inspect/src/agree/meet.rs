//! One camera's spots, looked at by another camera.

use super::setup::Stand;
use crate::{
    statistics::{median, share},
    vector::{Vector, add, dot, pixel_of, scaled, sub, to_camera, to_world, turn, unit},
    watch::sketch::{Label, Sketch, Surfel},
};

/// How far outside a mask a spot may appear [px].
const RIM_PX: f64 = 3.0;
/// Depths that differ by more contradict each other entirely [m].
pub(crate) const APART_M: f64 = 0.05;
/// How far in front of a surface a spot may lie before it should have hidden it [m], plus a share of the depth.
const BEFORE_M: f64 = 0.012;
const BEFORE_SHARE: f64 = 0.01;
/// Least cosine between a normal and the direction to a camera that faces it.
const FACING: f64 = 0.45;

/// What was found when one camera's spots were looked at by another.
#[derive(Clone, Debug, Default)]
pub(crate) struct Meeting {
    /// Spots that should appear in the other image.
    pub(crate) inside_image: usize,
    /// Spots that should not: behind the other camera, or beside its image.
    pub(crate) outside_image: usize,
    /// Of the first, those that appear outside the masks.
    pub(crate) outside_masks: usize,
    /// Those that lie in front of what the other camera measured.
    pub(crate) before: usize,
    /// Depth of the spot less depth of the other's surface, where both face it [m].
    pub(crate) differences: Vec<f64>,
    /// Sum of misfits of spots inside the image.
    sum: f64,
    /// How many spots of the object, and of the manipulator, fell onto object, and manipulator, at about their depth.
    pub(crate) labels: [[usize; 2]; 2],
}

/// Adds to `meeting` what `other` shows of the spots.
pub(crate) fn meet<'a>(
    spots: impl Iterator<Item = &'a Surfel>,
    stand: &Stand<'_>,
    sketch: &Sketch,
    other: &Stand<'_>,
    meeting: &mut Meeting,
) {
    let (columns, rows) = (other.camera.width as f64, other.camera.height as f64);
    let eye = stand.pose.translation;
    for spot in spots {
        let place = to_world(&stand.pose, scaled(spot.at, stand.depth_scale));
        let there = to_camera(&other.pose, place);
        let pixel = pixel_of(other.camera, there)
            .filter(|[u, v]| (0.0..columns - 0.5).contains(u) && (0.0..rows - 0.5).contains(v));
        let Some(pixel) = pixel else {
            meeting.outside_image += 1;
            continue;
        };
        meeting.inside_image += 1;
        if !sketch.is_near_mask(pixel, RIM_PX) {
            meeting.outside_masks += 1;
            meeting.sum += 1.0;
            continue;
        }
        let Some((label, depth)) = sketch.cell(pixel).and_then(|c| sketch.surface(c)) else {
            continue;
        };
        let difference = there[2] - depth * other.depth_scale;
        let apart = (difference.abs() / APART_M).min(1.0);
        let normal = turn(&stand.pose.rotation, spot.normal);
        let faces = faces(normal, place, eye) && faces(normal, place, other.pose.translation);
        if difference < -(BEFORE_M + BEFORE_SHARE * there[2]) {
            meeting.before += 1;
            meeting.sum += apart;
        } else if faces {
            meeting.sum += apart;
        }
        if faces && difference.abs() < APART_M {
            meeting.differences.push(difference);
        }
        if faces && difference.abs() < APART_M {
            let row = usize::from(spot.label == Label::Manipulator);
            meeting.labels[row][usize::from(label == Label::Manipulator)] += 1;
        }
    }
}

fn faces(normal: Vector, place: Vector, eye: Vector) -> bool {
    unit(sub(eye, place)).is_some_and(|to| dot(normal, to) > FACING)
}

impl Meeting {
    /// How badly the cameras contradict each other, 0..=1; `None` if no spot should be visible to both and so nothing
    /// can be said. A camera that should see almost nothing of what another sees contradicts it.
    pub(crate) fn misfit(&self) -> Option<f64> {
        let all = self.inside_image + self.outside_image;
        if all == 0 {
            return None;
        }
        let beside = share(self.outside_image, all);
        Some(
            (self.sum + beside * self.outside_image as f64)
                / (self.inside_image as f64 + beside * self.outside_image as f64).max(1.0),
        )
    }

    /// Share of the spots that contradict the other camera's masks or depths, 0..=1.
    pub(crate) fn conflict(&self) -> f64 {
        share(self.outside_masks + self.before, self.inside_image)
    }

    /// Both directions of a pair together; the differences of the other direction have the other sign.
    pub(crate) fn both(mut self, back: &Self) -> Self {
        self.inside_image += back.inside_image;
        self.outside_image += back.outside_image;
        self.outside_masks += back.outside_masks;
        self.before += back.before;
        self.sum += back.sum;
        self.differences.extend(back.differences.iter().map(|d| -d));
        self
    }

    /// Median difference [m].
    pub(crate) fn offset_m(&self) -> Option<f64> {
        median(self.differences.iter().copied())
    }

    /// Median size of the difference [m].
    pub(crate) fn disagreement_m(&self) -> Option<f64> {
        median(self.differences.iter().map(|d| d.abs()))
    }
}

/// A spot's place in the world.
pub(crate) fn place(spot: &Surfel, stand: &Stand<'_>) -> Vector {
    add(turn(&stand.pose.rotation, scaled(spot.at, stand.depth_scale)), stand.pose.translation)
}
