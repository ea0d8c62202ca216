//! From a pixel to a depth, at sub-pixel accuracy: a plane through the depths of one surface around
//! the pixel.
//!
//! In a pinhole camera a plane in space is a plane in inverse depth: `1/z = a + b·dx + c·dy`.
//! Fitted robustly to the pixels of the window that lie on the same surface, its `a` is free of the
//! rounding of depth to millimetres and of most of its noise, and does not mix what lies to both
//! sides of an edge.

use bendtwin_capture::raw::{DepthImage, Image, Intrinsics};
use bendtwin_core::settings::ingest::{LiftSettings, MaskSettings};
use nalgebra::{Matrix3, Vector3};

use super::clean::{Label, edge_m};

/// Why a track was not lifted in a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Miss {
    /// Outside the image.
    Outside,
    /// On neither cleaned mask.
    OffMask,
    /// Too few pixels of one surface around it.
    Unsupported,
}

/// A depth image with its cleaned masks.
pub(crate) struct LabelledDepth<'a> {
    pub(crate) depth: &'a DepthImage,
    pub(crate) labels: &'a Image<Label>,
    pub(crate) intrinsics: &'a Intrinsics,
    pub(crate) masks: &'a MaskSettings,
    pub(crate) lift: &'a LiftSettings,
}

/// A pixel of the window: offset from the track, inverse depth, weight.
struct Sample {
    dx: f64,
    dy: f64,
    inverse: f64,
    weight: f64,
}

/// Spread of the window's weights: pixels farther away count less [pixels].
const SIGMA_PX: f64 = 1.5;
/// Differences in depth below this are noise in any camera [m].
const MIN_SCALE_M: f64 = 5e-4;

impl LabelledDepth<'_> {
    /// The label at a pixel (column, row), and its depth along the optical axis [m].
    pub(crate) fn at(&self, pixel: [f32; 2]) -> Result<(Label, f64), Miss> {
        let [x, y] = pixel.map(f64::from);
        let (width, height) = (self.depth.width, self.depth.height);
        let inside = |v: f64, n: usize| v >= -0.5 && v < n as f64 - 0.5;
        if !(inside(x, width) && inside(y, height)) {
            return Err(Miss::Outside);
        }
        let (label, near_m) = self.surface(x, y).ok_or(Miss::OffMask)?;
        let samples = self.window(x, y, label, near_m);
        if samples.len() < self.lift.min_support as usize {
            return Err(Miss::Unsupported);
        }
        let depth = fit(samples, near_m).ok_or(Miss::Unsupported)?;
        Ok((label, depth))
    }

    /// The label with at least half the bilinear weight, and the depth of its nearest pixel.
    fn surface(&self, x: f64, y: f64) -> Option<(Label, f64)> {
        let (left, top) = (x.floor(), y.floor());
        let mut share = [0.0; 2];
        let mut nearest = [(f64::INFINITY, 0.0); 2];
        for (dx, dy) in [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0)] {
            let (column, row) = (left + dx, top + dy);
            if column < 0.0 || row < 0.0 {
                continue;
            }
            let (column, row) = (column as usize, row as usize);
            let which = match self.labels.get(column, row) {
                Some(Label::Object) => 0,
                Some(Label::Manipulator) => 1,
                _ => continue,
            };
            let (ax, ay) = ((x - column as f64).abs(), (y - row as f64).abs());
            share[which] += (1.0 - ax) * (1.0 - ay);
            let depth = self.depth.get(column, row).map(f64::from)?;
            if ax.hypot(ay) < nearest[which].0 {
                nearest[which] = (ax.hypot(ay), depth);
            }
        }
        let which = usize::from(share[1] > share[0]);
        let label = [Label::Object, Label::Manipulator][which];
        (share[which] >= 0.5).then_some((label, nearest[which].1))
    }

    fn window(&self, x: f64, y: f64, label: Label, near_m: f64) -> Vec<Sample> {
        let reach = self.lift.window as usize;
        let edge = f64::from(edge_m(near_m as f32, self.intrinsics, self.masks));
        let (column, row) = (x.round().max(0.0) as usize, y.round().max(0.0) as usize);
        let mut samples = Vec::with_capacity((2 * reach + 1) * (2 * reach + 1));
        for v in row.saturating_sub(reach)..(row + reach + 1).min(self.depth.height) {
            for u in column.saturating_sub(reach)..(column + reach + 1).min(self.depth.width) {
                let at = v * self.depth.width + u;
                let z = f64::from(self.depth.pixels[at]);
                if self.labels.pixels[at] != label || (z - near_m).abs() > edge {
                    continue;
                }
                let (dx, dy) = (u as f64 - x, v as f64 - y);
                let weight = (-(dx * dx + dy * dy) / (2.0 * SIGMA_PX * SIGMA_PX)).exp();
                samples.push(Sample { dx, dy, inverse: 1.0 / z, weight });
            }
        }
        samples
    }
}

/// Depth in the middle of a window [m], by least squares with weights after Tukey.
fn fit(samples: Vec<Sample>, near_m: f64) -> Option<f64> {
    let mut robust = vec![1.0; samples.len()];
    let mut inverse = None;
    for _ in 0..3 {
        let plane = plane(&samples, &robust)?;
        inverse = Some(plane[0]);
        let residual = |s: &Sample| {
            (s.inverse - plane[0] - plane[1] * s.dx - plane[2] * s.dy).abs() * near_m * near_m
        };
        let mut sorted: Vec<f64> = samples.iter().map(residual).collect();
        sorted.sort_by(f64::total_cmp);
        let scale = (1.4826 * sorted[sorted.len() / 2]).max(MIN_SCALE_M);
        for (weight, sample) in robust.iter_mut().zip(&samples) {
            let u = residual(sample) / (4.685 * scale);
            *weight = if u < 1.0 { (1.0 - u * u) * (1.0 - u * u) } else { 0.0 };
        }
    }
    // The window's own range bounds what a plane may say of its middle.
    let depths = samples.iter().map(|s| 1.0 / s.inverse);
    let (low, high) =
        depths.fold((f64::INFINITY, 0.0f64), |(low, high), z| (low.min(z), high.max(z)));
    let depth = 1.0 / inverse?;
    depth.is_finite().then(|| depth.clamp(low, high))
}

/// Coefficients of `1/z = a + b·dx + c·dy`; where the pixels lie in a line, b and c are 0.
fn plane(samples: &[Sample], robust: &[f64]) -> Option<[f64; 3]> {
    let mut normal = Matrix3::zeros();
    let mut right = Vector3::zeros();
    for (s, r) in samples.iter().zip(robust) {
        let basis = Vector3::new(1.0, s.dx, s.dy);
        normal += basis * basis.transpose() * (s.weight * r);
        right += basis * (s.weight * r * s.inverse);
    }
    let total = normal[(0, 0)];
    if total <= 1e-9 {
        return None;
    }
    // The determinant over the total's cube is the area that the pixels spread over, squared
    // [pixels^4].
    if normal.determinant() > 1e-3 * total.powi(3) {
        let solution = normal.try_inverse()? * right;
        return Some([solution[0], solution[1], solution[2]]);
    }
    Some([right[0] / total, 0.0, 0.0])
}

#[cfg(test)]
mod tests;
