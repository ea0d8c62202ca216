//! Alignment of a patch with an image: Lucas and Kanade's Gauss-Newton steps, inverse compositional
//! in that gradients are those of the patch, with a robust weight for every pixel, and indifferent
//! to a gain and to an offset of each channel.

use super::{
    layer::Level,
    patch::{Patch, smallest_eigenvalue},
};

/// The warp from a patch to the image that it is sought in, apart from its place.
#[derive(Clone, Debug)]
pub(crate) struct Warp {
    /// Place of each sample relative to the patch's centre [pixels of the full image].
    pub(crate) offsets: Vec<[f32; 2]>,
    /// Inverse of the transposed Jacobian of the warp, which turns the patch's gradients into the
    /// image's.
    pub(crate) gradients: [[f32; 2]; 2],
}

/// The place at which a patch was found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Alignment {
    /// Column and row in the full image.
    pub(crate) at: [f64; 2],
    /// Correlation between patch and image, means of each channel removed: 1 is perfect.
    pub(crate) correlation: f32,
}

/// Most steps on one level.
const MAX_STEPS: usize = 25;
/// Length of a step below which the place is found [pixels of the level].
const CONVERGED_STEP: f32 = 0.003;
/// Difference of colour at which a pixel counts half (Cauchy's weight), 0 to 1.
const ROBUST_SCALE: f32 = 0.12;
/// Least share of the patch that must be visible in the image.
const MIN_VISIBLE_SHARE: f32 = 0.4;
/// Gains of brightness that are allowed for.
const GAIN_RANGE: std::ops::RangeInclusive<f32> = 0.4..=2.5;

impl Warp {
    /// No warp but a translation.
    pub(crate) fn translation(patch: &Patch) -> Self {
        Self {
            offsets: patch.samples.iter().map(|s| s.offset).collect(),
            gradients: [[1.0, 0.0], [0.0, 1.0]],
        }
    }
}

/// Moves `patch`, warped, from `start` until it fits the level, at most `reach` pixels of the level
/// far. `None` if it leaves the region, has no texture there or does not settle.
pub(crate) fn align(
    patch: &Patch,
    warp: &Warp,
    level: &Level,
    start: [f64; 2],
    reach: f32,
) -> Option<Alignment> {
    let mut at = start;
    for _ in 0..MAX_STEPS {
        let fit = Fit::new(patch, warp, level, at)?;
        let [dx, dy] = fit.step(level.step)?;
        // A step of more than two pixels is beyond the validity of gradients.
        let length = dx.hypot(dy) / level.step;
        let shorter = (2.0 / length).min(1.0);
        at = [at[0] + f64::from(dx * shorter), at[1] + f64::from(dy * shorter)];
        let far = (at[0] - start[0]).hypot(at[1] - start[1]);
        if far > f64::from(reach * level.step) {
            return None;
        }
        if length < CONVERGED_STEP {
            break;
        }
    }
    let fit = Fit::new(patch, warp, level, at)?;
    Some(Alignment { at, correlation: fit.correlation })
}

/// Patch and image compared at one place, and the normal equations of the step that would make them
/// equal.
struct Fit {
    correlation: f32,
    xx: f32,
    xy: f32,
    yy: f32,
    right: [f32; 2],
    weights: f32,
}

impl Fit {
    fn new(patch: &Patch, warp: &Warp, level: &Level, at: [f64; 2]) -> Option<Self> {
        let at = at.map(|v| v as f32);
        let mut seen = Vec::with_capacity(patch.samples.len());
        let mut means = [[0.0_f32; 3]; 4];
        let (mut weights, mut possible) = (0.0, 0.0);
        for (sample, offset) in patch.samples.iter().zip(&warp.offsets) {
            possible += sample.weight;
            let there = level.sample([at[0] + offset[0], at[1] + offset[1]]);
            let Some((color, coverage)) = there else { continue };
            let weight = sample.weight * coverage;
            let gradient = turned(&warp.gradients, &sample.gradient);
            for c in 0..3 {
                means[0][c] += weight * sample.color[c];
                means[1][c] += weight * color[c];
                means[2][c] += weight * gradient[0][c];
                means[3][c] += weight * gradient[1][c];
            }
            weights += weight;
            seen.push((weight, sample.color, color, gradient));
        }
        if !(weights > MIN_VISIBLE_SHARE * possible && weights > 0.0) {
            return None;
        }
        for mean in means.iter_mut().flatten() {
            *mean /= weights;
        }
        let (mut tt, mut ti, mut ii) = (0.0, 0.0, 0.0);
        for (weight, a, b, _) in &mut seen {
            for c in 0..3 {
                a[c] -= means[0][c];
                b[c] -= means[1][c];
                tt += *weight * a[c] * a[c];
                ti += *weight * a[c] * b[c];
                ii += *weight * b[c] * b[c];
            }
        }
        if !(tt > 0.0 && ii > 0.0) {
            return None;
        }
        let correlation = ti / (tt * ii).sqrt();
        let gain = (ii / tt).sqrt().clamp(*GAIN_RANGE.start(), *GAIN_RANGE.end());
        let mut fit = Self { correlation, xx: 0.0, xy: 0.0, yy: 0.0, right: [0.0; 2], weights };
        for (weight, a, b, gradient) in &seen {
            let miss: [f32; 3] = std::array::from_fn(|c| b[c] - gain * a[c]);
            let square = miss.iter().map(|m| m * m).sum::<f32>();
            let weight = weight / (1.0 + square / (ROBUST_SCALE * ROBUST_SCALE));
            for c in 0..3 {
                let x = gain * (gradient[0][c] - means[2][c]);
                let y = gain * (gradient[1][c] - means[3][c]);
                fit.xx += weight * x * x;
                fit.xy += weight * x * y;
                fit.yy += weight * y * y;
                fit.right[0] -= weight * x * miss[c];
                fit.right[1] -= weight * y * miss[c];
            }
        }
        Some(fit)
    }

    /// The step by which the patch has to move [px of the full image].
    fn step(&self, pixel: f32) -> Option<[f32; 2]> {
        // Where gradients are below a thousandth of the grey scale per pixel, noise decides.
        const MIN_GRADIENT: f32 = 1e-3;
        let flat = MIN_GRADIENT * MIN_GRADIENT / (pixel * pixel) * self.weights;
        if smallest_eigenvalue(self.xx, self.xy, self.yy) <= flat {
            return None;
        }
        let determinant = self.xx * self.yy - self.xy * self.xy;
        let [p, q] = self.right;
        let step =
            [(self.yy * p - self.xy * q) / determinant, (self.xx * q - self.xy * p) / determinant];
        step.iter().all(|s| s.is_finite()).then_some(step)
    }
}

fn turned(by: &[[f32; 2]; 2], gradient: &[[f32; 3]; 2]) -> [[f32; 3]; 2] {
    std::array::from_fn(|i| {
        std::array::from_fn(|c| by[i][0] * gradient[0][c] + by[i][1] * gradient[1][c])
    })
}
