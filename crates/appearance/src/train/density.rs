//! The number of Gaussians: those are split whose projections the gradients pull hardest, because one
//! Gaussian stands where the image has more detail; those are removed that hardly show.

use bendtwin_splat::GaussiansBar;
use serde::{Deserialize, Serialize};

use super::{
    adam::Adam,
    parameters::{MEAN, OPACITY, Parameters, ROTATION, SCALE, WIDTH, logit, opacity, part},
};

/// Opacity below which a Gaussian is removed.
const LEAST_OPACITY: f32 = 0.03;
/// Largest share of the Gaussians that are split in one step.
const SPLIT_SHARE: f64 = 0.2;
/// Pull of a Gaussian that is split over the mean of those that were seen.
const PULLED: f32 = 1.0;
/// Distance of each half from the middle, and its scale, along the longest axis over the scale there:
/// together they have about the extent of the whole.
const HALF_AWAY: f32 = 0.6;
const HALF_SCALE: f32 = 0.7;

/// Mean length of the gradient by a Gaussian's place in the image, over the views that showed it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Pull {
    sums: Vec<f32>,
    seen: Vec<u32>,
}

impl Pull {
    pub(super) fn new(count: usize) -> Self {
        Self { sums: vec![0.0; count], seen: vec![0; count] }
    }

    /// Number of Gaussians; 0 if its parts have different numbers.
    pub(super) fn len(&self) -> usize {
        if self.sums.len() == self.seen.len() { self.sums.len() } else { 0 }
    }

    pub(super) fn add(&mut self, bar: &GaussiansBar) {
        for (g, length) in bar.screen.iter().enumerate().filter(|(_, length)| **length > 0.0) {
            self.sums[g] += length;
            self.seen[g] += 1;
        }
    }

    fn of(&self, g: usize) -> f32 {
        self.sums[g] / self.seen[g].max(1) as f32
    }
}

/// Removes and splits Gaussians, `most` of them at most.
pub(super) fn change(parameters: &mut Parameters, adam: &mut Adam, pull: &Pull, most: usize) {
    let count = parameters.len();
    let kept: Vec<usize> =
        (0..count).filter(|g| opacity(parameters.rows[*g][OPACITY]) >= LEAST_OPACITY).collect();
    let seen = kept.iter().filter(|g| pull.seen[**g] > 0).count();
    let mean = kept.iter().map(|g| pull.of(*g)).sum::<f32>() / seen.max(1) as f32;
    let mut pulled: Vec<usize> =
        kept.iter().copied().filter(|g| pull.of(*g) > PULLED * mean).collect();
    pulled.sort_by(|a, b| pull.of(*b).total_cmp(&pull.of(*a)).then(a.cmp(b)));
    let room = most.saturating_sub(kept.len());
    pulled.truncate(room.min((SPLIT_SHARE * kept.len() as f64) as usize));
    let mut is_split = vec![false; count];
    pulled.iter().for_each(|g| is_split[*g] = true);
    let (mut rows, mut from) = (Vec::new(), Vec::new());
    for g in kept {
        let row = parameters.rows[g];
        if is_split[g] {
            rows.extend(halves(&row));
            from.extend([None, None]);
        } else {
            rows.push(row);
            from.push(Some(g));
        }
    }
    *parameters = Parameters { rows };
    *adam = adam.select(&from);
}

/// Two Gaussians in place of one, side by side along its longest axis; together they cover as much as
/// it did.
fn halves(row: &[f32; WIDTH]) -> [[f32; WIDTH]; 2] {
    let scales: [f32; 3] = part(row, SCALE);
    let longest =
        (0..3).fold(0, |best, axis| if scales[axis] > scales[best] { axis } else { best });
    let away = HALF_AWAY * scales[longest].exp();
    let along = axis(part(row, ROTATION), longest);
    [1.0, -1.0].map(|side| {
        let mut half = *row;
        (0..3).for_each(|i| half[MEAN + i] += side * away * along[i]);
        half[SCALE + longest] += HALF_SCALE.ln();
        half[OPACITY] = logit(1.0 - (1.0 - opacity(row[OPACITY])).sqrt());
        half
    })
}

/// An axis of a rotation, by its unit quaternion.
fn axis([x, y, z, w]: [f32; 4], axis: usize) -> [f32; 3] {
    match axis {
        0 => [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y + z * w), 2.0 * (x * z - y * w)],
        1 => [2.0 * (x * y - z * w), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z + x * w)],
        _ => [2.0 * (x * z + y * w), 2.0 * (y * z - x * w), 1.0 - 2.0 * (x * x + y * y)],
    }
}
