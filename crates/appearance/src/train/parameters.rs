//! Trained parameters of Gaussians: scales as logarithms, opacities as logits, in one row for each
//! Gaussian.

use bendtwin_core::{Point, Splats};
use bendtwin_splat::{Gaussians, GaussiansBar};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// Numbers of a Gaussian: mean, logarithms of scales, quaternion, logit of opacity, colour.
pub(super) const WIDTH: usize = 14;
/// Gaussians that a thread takes at a time.
pub(super) const PIECE: usize = 256;
pub(super) const MEAN: usize = 0;
pub(super) const SCALE: usize = 3;
pub(super) const ROTATION: usize = 6;
pub(super) const OPACITY: usize = 10;
pub(super) const COLOR: usize = 11;

/// Weight of the term that draws opacities to 0 or 1: the mean of o (1 - o).
const DECISIVE: f32 = 0.01;
/// Least scale [m].
const LEAST_M: f32 = 1e-4;
/// Largest scale over the size of the object.
const LARGEST: f32 = 0.1;
/// Largest absolute logit of an opacity.
const MOST_LOGIT: f32 = 9.0;

/// Rows of numbers, shape [G].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Parameters {
    pub(super) rows: Vec<[f32; WIDTH]>,
}

impl Parameters {
    pub(super) fn new(means: &[Point], splats: &Splats) -> Self {
        let row = |g: usize| {
            let mut row = [0.0; WIDTH];
            row[MEAN..SCALE].copy_from_slice(&means[g]);
            row[SCALE..ROTATION].copy_from_slice(&splats.scales_m[g].map(f32::ln));
            row[ROTATION..OPACITY].copy_from_slice(&splats.rotations[g]);
            row[OPACITY] = logit(splats.opacities[g]);
            row[COLOR..].copy_from_slice(&splats.colors[g]);
            row
        };
        Self { rows: (0..means.len()).map(row).collect() }
    }

    pub(super) fn len(&self) -> usize {
        self.rows.len()
    }

    /// True if every number is finite.
    pub(super) fn is_whole(&self) -> bool {
        self.rows.iter().flatten().all(|x| x.is_finite())
    }

    pub(super) fn means_m(&self) -> Vec<Point> {
        self.each(|row| part(row, MEAN))
    }

    pub(super) fn gaussians(&self) -> Gaussians {
        Gaussians {
            means_m: self.means_m(),
            scales_m: self.each(|row| part(row, SCALE).map(f32::exp)),
            rotations: self.each(|row| unit(part(row, ROTATION))),
            opacities: self.each(|row| opacity(row[OPACITY])),
            colors: self.each(|row| part(row, COLOR)),
        }
    }

    /// A value for each Gaussian.
    fn each<T: Send>(&self, of: impl Fn(&[f32; WIDTH]) -> T + Send + Sync) -> Vec<T> {
        self.rows.par_iter().with_min_len(PIECE).map(of).collect()
    }
}

/// d loss / d rows from d loss / d Gaussians at rest, with that of the term that draws opacities to
/// 0 or 1. Round Gaussians have one scale.
pub(super) struct Gradient<'a> {
    bar: &'a GaussiansBar,
    isotropic: bool,
    /// Weight of the term for opacities, for one Gaussian.
    decisive: f32,
}

impl<'a> Gradient<'a> {
    pub(super) fn new(bar: &'a GaussiansBar, isotropic: bool) -> Self {
        Self { bar, isotropic, decisive: DECISIVE / bar.len().max(1) as f32 }
    }

    /// The derivatives by the row of a Gaussian.
    pub(super) fn of(&self, g: usize, row: &[f32; WIDTH]) -> [f32; WIDTH] {
        let bar = self.bar;
        let mut gradient = [0.0; WIDTH];
        gradient[MEAN..SCALE].copy_from_slice(&bar.means_m[g]);
        let scales = part::<3>(row, SCALE).map(f32::exp);
        let mut by_scale: [f32; 3] = std::array::from_fn(|i| scales[i] * bar.scales_m[g][i]);
        if self.isotropic {
            by_scale = [by_scale.iter().sum::<f32>() / 3.0; 3];
        }
        gradient[SCALE..ROTATION].copy_from_slice(&by_scale);
        if !self.isotropic {
            gradient[ROTATION..OPACITY].copy_from_slice(&bar.rotations[g]);
        }
        let o = opacity(row[OPACITY]);
        let by_opacity = bar.opacities[g] + self.decisive * (1.0 - 2.0 * o);
        gradient[OPACITY] = by_opacity * o * (1.0 - o);
        gradient[COLOR..].copy_from_slice(&bar.colors[g]);
        gradient
    }
}

/// Ranges of a row's numbers.
pub(super) struct Limits {
    /// Logarithms of the least and the largest scale.
    scales: [f32; 2],
    isotropic: bool,
}

impl Limits {
    pub(super) fn new(extent_m: f32, isotropic: bool) -> Self {
        let scales = [LEAST_M, LARGEST * extent_m.max(10.0 * LEAST_M)].map(f32::ln);
        Self { scales, isotropic }
    }

    /// Brings what left its range back: scales, opacities, the length of quaternions.
    pub(super) fn keep(&self, row: &mut [f32; WIDTH]) {
        if self.isotropic {
            let round = row[SCALE];
            row[SCALE..ROTATION].fill(round);
        }
        let [least, most] = self.scales;
        row[SCALE..ROTATION].iter_mut().for_each(|s| *s = s.clamp(least, most));
        let turned = unit(part(row, ROTATION));
        row[ROTATION..OPACITY].copy_from_slice(&turned);
        row[OPACITY] = row[OPACITY].clamp(-MOST_LOGIT, MOST_LOGIT);
        row[COLOR..].iter_mut().for_each(|c| *c = c.clamp(0.0, 1.0));
    }
}

/// Some numbers of a row.
pub(super) fn part<const N: usize>(row: &[f32; WIDTH], first: usize) -> [f32; N] {
    std::array::from_fn(|i| row[first + i])
}

pub(super) fn opacity(logit: f32) -> f32 {
    1.0 / (1.0 + (-logit).exp())
}

pub(super) fn logit(opacity: f32) -> f32 {
    (opacity / (1.0 - opacity)).ln().clamp(-MOST_LOGIT, MOST_LOGIT)
}

/// The quaternion of length 1; that of no rotation where there is no direction.
fn unit(q: [f32; 4]) -> [f32; 4] {
    let length = q.iter().map(|x| x * x).sum::<f32>().sqrt();
    if length > 1e-6 { q.map(|x| x / length) } else { [0.0, 0.0, 0.0, 1.0] }
}
