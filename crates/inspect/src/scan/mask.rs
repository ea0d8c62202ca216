//! Measurements of a mask in one image: its area, the share of it with depth, the place of that in
//! space.

use bendtwin_capture::raw::{Camera, DepthImage, Mask};

use crate::{
    statistics::{median, quantile},
    thresholds::ScanThresholds,
    vector::{Upright, Vector, distance, seen_at, to_world},
};

/// Pixels with depth whose place in space is measured.
const MAX_POINTS: usize = 3000;

/// A mask and the surface that it shows.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct MaskStats {
    pub(crate) area_px: usize,
    /// Pixels of it with depth.
    pub(crate) depth_px: usize,
    /// True if it reaches the image's border, so that part of the thing is not in view.
    pub(crate) at_border: bool,
    /// Mean of its pixels.
    pub(crate) middle_px: [f64; 2],
    pub(crate) surface: Option<Surface>,
}

/// Place of a mask's pixels in space.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Surface {
    /// Median in the camera's axes [m].
    pub(crate) middle: Vector,
    /// Larger of the extents across and down, without the outermost [m].
    pub(crate) extent_m: f64,
    /// Share of the points that lie far from the middle in depth, 0..=1.
    pub(crate) apart: f64,
    /// Height of the lowest points over the ground [m].
    pub(crate) low_m: f64,
    /// Height of the highest points over the ground [m].
    pub(crate) high_m: f64,
    /// Share of the points below the ground, 0..=1.
    pub(crate) below: f64,
}

/// The measurements of a mask, and some of its points in the camera's axes [m].
pub(crate) fn measure(
    camera: &Camera,
    frame: usize,
    upright: &Upright,
    mask: &Mask,
    depth: Option<&DepthImage>,
    thresholds: &ScanThresholds,
) -> (MaskStats, Vec<Vector>) {
    let mut stats = MaskStats::default();
    let mut sum = [0.0; 2];
    let mut known: Vec<(u32, u32, f32)> = Vec::new();
    for row in 0..mask.height {
        for (column, _) in mask.row(row).iter().enumerate().filter(|(_, m)| **m) {
            stats.area_px += 1;
            let is_side = column == 0 || column + 1 == mask.width;
            stats.at_border |= is_side || row == 0 || row + 1 == mask.height;
            sum = [sum[0] + column as f64, sum[1] + row as f64];
            let metres = depth.and_then(|d| d.get(column, row)).unwrap_or(0.0);
            if metres > 0.0 && metres.is_finite() {
                known.push((column as u32, row as u32, metres));
            }
        }
    }
    stats.depth_px = known.len();
    if stats.area_px > 0 {
        stats.middle_px = sum.map(|s| s / stats.area_px as f64);
    }
    let step = known.len().div_ceil(MAX_POINTS).max(1);
    let point =
        |&(c, r, d): &(u32, u32, f32)| seen_at(camera, [f64::from(c), f64::from(r)], f64::from(d));
    let points: Vec<Vector> = known.iter().step_by(step).map(point).collect();
    stats.surface = surface(&points, camera, frame, upright, thresholds);
    (stats, points)
}

fn surface(
    points: &[Vector],
    camera: &Camera,
    frame: usize,
    upright: &Upright,
    thresholds: &ScanThresholds,
) -> Option<Surface> {
    let (low, high) = (thresholds.outlier_share, 1.0 - thresholds.outlier_share);
    let mut axes: [Vec<f64>; 3] = std::array::from_fn(|a| points.iter().map(|p| p[a]).collect());
    let mut middle = [0.0; 3];
    let mut extent_m = 0.0_f64;
    for (a, values) in axes.iter_mut().enumerate() {
        middle[a] = quantile(values, 0.5)?;
        if a < 2 {
            extent_m = extent_m.max(quantile(values, high)? - quantile(values, low)?);
        }
    }
    let limit = extent_m.max(thresholds.apart_m);
    let apart = points.iter().filter(|p| (p[2] - middle[2]).abs() > limit).count();
    let pose = camera.pose(frame);
    let mut heights: Vec<f64> = points.iter().map(|p| upright.height(to_world(pose, *p))).collect();
    let below = heights.iter().filter(|h| **h < -thresholds.below_ground_m).count();
    let count = points.len() as f64;
    Some(Surface {
        middle,
        extent_m,
        apart: apart as f64 / count,
        low_m: quantile(&mut heights, low)?,
        high_m: quantile(&mut heights, high)?,
        below: below as f64 / count,
    })
}

/// The smallest distance between two clouds [m]; both are thinned out.
pub(crate) fn gap(
    object: &[Vector],
    manipulator: &[Vector],
    thresholds: &ScanThresholds,
) -> Option<f64> {
    const MAX_OBJECT_POINTS: usize = 600;
    const MAX_MANIPULATOR_POINTS: usize = 250;
    let thin = |points: &[Vector], most: usize| {
        let step = points.len().div_ceil(most).max(1);
        points.iter().step_by(step).copied().collect::<Vec<_>>()
    };
    let (object, manipulator) =
        (thin(object, MAX_OBJECT_POINTS), thin(manipulator, MAX_MANIPULATOR_POINTS));
    let nearest = |m: &Vector| object.iter().map(|o| distance(*o, *m)).min_by(f64::total_cmp);
    let mut gaps: Vec<f64> = manipulator.iter().filter_map(nearest).collect();
    // One flying pixel between the two is no contact.
    gaps.sort_by(f64::total_cmp);
    median(gaps.into_iter().take(thresholds.gap_points))
}
