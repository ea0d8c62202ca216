//! Reprojection of a camera's surfels into another camera.

use super::hypothesis::PosedCamera;
use crate::{
    scan::crop::{Crop, Label, Surfel},
    statistics::{median, share},
    thresholds::ConsistencyThresholds,
    vector::{Vector, add, dot, pixel_of, scaled, sub, to_camera, to_world, turn, unit},
};

/// Counts and differences of one camera's surfels, reprojected into another.
#[derive(Clone, Debug, Default)]
pub(crate) struct Reprojection {
    /// Surfels that should appear in the other image.
    pub(crate) inside_image: usize,
    /// Surfels that should not: behind the other camera, or beside its image.
    pub(crate) outside_image: usize,
    /// Surfels inside the image that appear outside the masks.
    pub(crate) outside_masks: usize,
    /// Surfels in front of what the other camera measured.
    pub(crate) in_front: usize,
    /// Depth of the surfel less depth of the other's surface, where both face it [m].
    pub(crate) differences: Vec<f64>,
    /// Sum of misfits of surfels inside the image.
    sum: f64,
    /// Counts of surfels by label: `labels[i][j]` surfels of label i fell onto label j at about
    /// their depth; 0 is the object, 1 the manipulator.
    pub(crate) labels: [[usize; 2]; 2],
}

/// Adds surfels of the camera `posed`, compared with a crop of the camera `other`, to
/// `reprojection`.
pub(crate) fn compare<'a>(
    surfels: impl Iterator<Item = &'a Surfel>,
    posed: &PosedCamera<'_>,
    crop: &Crop,
    other: &PosedCamera<'_>,
    thresholds: &ConsistencyThresholds,
    reprojection: &mut Reprojection,
) {
    let (columns, rows) = (other.camera.width as f64, other.camera.height as f64);
    let eye = posed.pose.translation;
    for surfel in surfels {
        let place = to_world(&posed.pose, scaled(surfel.at, posed.depth_scale));
        let there = to_camera(&other.pose, place);
        let pixel = pixel_of(other.camera, there)
            .filter(|[u, v]| (0.0..columns - 0.5).contains(u) && (0.0..rows - 0.5).contains(v));
        let Some(pixel) = pixel else {
            // What leaves the image may be outside.
            reprojection.outside_image += usize::from(!crop.at_border);
            continue;
        };
        reprojection.inside_image += 1;
        if !crop.is_near_mask(pixel, thresholds.mask_margin_px) {
            reprojection.outside_masks += 1;
            reprojection.sum += 1.0;
            continue;
        }
        let Some((label, depth)) = crop.cell(pixel).and_then(|c| crop.surface(c)) else {
            continue;
        };
        let difference = there[2] - depth * other.depth_scale;
        let apart = (difference.abs() / thresholds.max_apart_m).min(1.0);
        let normal = turn(&posed.pose.rotation, surfel.normal);
        let faces_camera = |eye| faces(normal, place, eye, thresholds.min_facing_cosine);
        let faces = faces_camera(eye) && faces_camera(other.pose.translation);
        if difference < -(thresholds.occlusion_m + thresholds.occlusion_depth_share * there[2]) {
            reprojection.in_front += 1;
            reprojection.sum += apart;
        } else if faces {
            reprojection.sum += apart;
        }
        if faces && difference.abs() < thresholds.max_apart_m {
            reprojection.differences.push(difference);
        }
        if faces && difference.abs() < thresholds.max_apart_m {
            let row = usize::from(surfel.label == Label::Manipulator);
            reprojection.labels[row][usize::from(label == Label::Manipulator)] += 1;
        }
    }
}

fn faces(normal: Vector, place: Vector, eye: Vector, min_cosine: f64) -> bool {
    unit(sub(eye, place)).is_some_and(|to| dot(normal, to) > min_cosine)
}

impl Reprojection {
    /// Misfit: degree to which the cameras contradict each other, 0..=1; `None` if no surfel should
    /// be visible to both. A camera that should see almost nothing of what another sees contradicts
    /// it.
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

    /// Share of the surfels that contradict the other camera's masks or depths, 0..=1.
    pub(crate) fn conflict(&self) -> f64 {
        share(self.outside_masks + self.in_front, self.inside_image)
    }

    /// Both directions of a pair together; the differences of the other direction have the other
    /// sign.
    pub(crate) fn both(mut self, back: &Self) -> Self {
        self.inside_image += back.inside_image;
        self.outside_image += back.outside_image;
        self.outside_masks += back.outside_masks;
        self.in_front += back.in_front;
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

/// A surfel's place in the world [m].
pub(crate) fn place(surfel: &Surfel, posed: &PosedCamera<'_>) -> Vector {
    add(turn(&posed.pose.rotation, scaled(surfel.at, posed.depth_scale)), posed.pose.translation)
}
