//! Adam over the rows of Gaussians, with a rate for each kind of number.

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::parameters::{
    COLOR, Gradient, Limits, MEAN, OPACITY, PIECE, Parameters, ROTATION, SCALE, WIDTH,
};

const BETA1: f32 = 0.9;
const BETA2: f32 = 0.999;
const EPSILON: f32 = 1e-12;
/// Learning rates: of means over the size of the object, of logarithms of scales, of quaternions, of
/// logits of opacities and of colours.
const MEANS: f32 = 1e-3;
const SCALES: f32 = 1e-2;
const ROTATIONS: f32 = 2e-3;
const OPACITIES: f32 = 3e-2;
const COLORS: f32 = 8e-3;
/// Rates at the end over those at the start: of means, and of all others.
const MEANS_FALL: f32 = 0.02;
const FALL: f32 = 0.1;

/// Moments of the gradient. G is the number of Gaussians.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Adam {
    /// Decayed sums, shape [G].
    first: Vec<[f32; WIDTH]>,
    second: Vec<[f32; WIDTH]>,
    /// Steps of each Gaussian, which may be younger than others, shape [G].
    steps: Vec<u32>,
}

impl Adam {
    pub(super) fn new(count: usize) -> Self {
        Self {
            first: vec![[0.0; WIDTH]; count],
            second: vec![[0.0; WIDTH]; count],
            steps: vec![0; count],
        }
    }

    /// Number of Gaussians; 0 if its parts have different numbers.
    pub(super) fn len(&self) -> usize {
        let lengths = [self.second.len(), self.steps.len()];
        if lengths == [self.first.len(); 2] { self.first.len() } else { 0 }
    }

    /// Moves the parameters along the gradient, within their limits; `done` is the share of all
    /// steps that were made.
    pub(super) fn step(
        &mut self,
        parameters: &mut Parameters,
        gradient: &Gradient<'_>,
        limits: &Limits,
        done: f64,
        extent_m: f32,
    ) {
        let fall = |end: f32| end.powf(done as f32);
        let mut rates = [0.0; WIDTH];
        rates[MEAN..SCALE].fill(MEANS * extent_m * fall(MEANS_FALL));
        rates[SCALE..ROTATION].fill(SCALES * fall(FALL));
        rates[ROTATION..OPACITY].fill(ROTATIONS * fall(FALL));
        rates[OPACITY] = OPACITIES * fall(FALL);
        rates[COLOR..].fill(COLORS * fall(FALL));
        let all = (&mut parameters.rows, &mut self.first, &mut self.second, &mut self.steps);
        let all = all.into_par_iter().with_min_len(PIECE).enumerate();
        all.for_each(|(g, (row, first, second, steps))| {
            *steps += 1;
            let age = (*steps).min(10_000) as i32;
            let (whole1, whole2) = (1.0 - BETA1.powi(age), 1.0 - BETA2.powi(age));
            let slopes = gradient.of(g, row);
            for k in 0..WIDTH {
                let slope = slopes[k];
                first[k] = BETA1 * first[k] + (1.0 - BETA1) * slope;
                second[k] = BETA2 * second[k] + (1.0 - BETA2) * slope * slope;
                let scale = (second[k] / whole2).sqrt() + EPSILON;
                row[k] -= rates[k] * (first[k] / whole1) / scale;
            }
            limits.keep(row);
        });
    }

    /// The moments of some Gaussians, in this order; none of those without an index.
    pub(super) fn select(&self, kept: &[Option<usize>]) -> Self {
        let of = |moments: &[[f32; WIDTH]]| {
            kept.iter().map(|k| k.map_or([0.0; WIDTH], |g| moments[g])).collect()
        };
        Self {
            first: of(&self.first),
            second: of(&self.second),
            steps: kept.iter().map(|k| k.map_or(0, |g| self.steps[g])).collect(),
        }
    }
}
