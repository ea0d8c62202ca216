//! Parameters of Gaussians as they are trained: scales as logarithms, opacities as logits, in one
//! row for each Gaussian.

use bendtwin_core::{Point, Splats};
use bendtwin_splat::{Gaussians, GaussiansBar};
use serde::{Deserialize, Serialize};

/// Numbers of a Gaussian: mean, logarithms of scales, quaternion, logit of opacity, colour.
pub(super) const WIDTH: usize = 14;
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
        self.rows.iter().map(|row| part(row, MEAN)).collect()
    }

    pub(super) fn gaussians(&self) -> Gaussians {
        let rows = || self.rows.iter();
        Gaussians {
            means_m: self.means_m(),
            scales_m: rows().map(|row| part(row, SCALE).map(f32::exp)).collect(),
            rotations: rows().map(|row| unit(part(row, ROTATION))).collect(),
            opacities: rows().map(|row| opacity(row[OPACITY])).collect(),
            colors: rows().map(|row| part(row, COLOR)).collect(),
        }
    }

    /// d loss / d rows from d loss / d Gaussians at rest, with that of the term that draws opacities
    /// to 0 or 1. Round Gaussians have one scale.
    pub(super) fn gradient(&self, bar: &GaussiansBar, isotropic: bool) -> Vec<[f32; WIDTH]> {
        let decisive = DECISIVE / self.len().max(1) as f32;
        let of = |(g, row): (usize, &[f32; WIDTH])| {
            let mut gradient = [0.0; WIDTH];
            gradient[MEAN..SCALE].copy_from_slice(&bar.means_m[g]);
            let scales = part::<3>(row, SCALE).map(f32::exp);
            let mut by_scale: [f32; 3] = std::array::from_fn(|i| scales[i] * bar.scales_m[g][i]);
            if isotropic {
                by_scale = [by_scale.iter().sum::<f32>() / 3.0; 3];
            }
            gradient[SCALE..ROTATION].copy_from_slice(&by_scale);
            if !isotropic {
                gradient[ROTATION..OPACITY].copy_from_slice(&bar.rotations[g]);
            }
            let o = opacity(row[OPACITY]);
            let by_opacity = bar.opacities[g] + decisive * (1.0 - 2.0 * o);
            gradient[OPACITY] = by_opacity * o * (1.0 - o);
            gradient[COLOR..].copy_from_slice(&bar.colors[g]);
            gradient
        };
        self.rows.iter().enumerate().map(of).collect()
    }

    /// Brings what left its range back: scales, opacities, the length of quaternions.
    pub(super) fn keep_in_range(&mut self, extent_m: f32, isotropic: bool) {
        let [least, most] = [LEAST_M, LARGEST * extent_m.max(10.0 * LEAST_M)].map(f32::ln);
        for row in &mut self.rows {
            if isotropic {
                let round = row[SCALE];
                row[SCALE..ROTATION].fill(round);
            }
            row[SCALE..ROTATION].iter_mut().for_each(|s| *s = s.clamp(least, most));
            let turned = unit(part(row, ROTATION));
            row[ROTATION..OPACITY].copy_from_slice(&turned);
            row[OPACITY] = row[OPACITY].clamp(-MOST_LOGIT, MOST_LOGIT);
            row[COLOR..].iter_mut().for_each(|c| *c = c.clamp(0.0, 1.0));
        }
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
