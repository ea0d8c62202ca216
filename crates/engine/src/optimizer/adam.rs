//! Adam (Kingma and Ba, arXiv 1412.6980) with one second moment for all parameters of a kind (as in
//! Adam-mini, Zhang et al., arXiv 2406.16793), a rate per coordinate and bounds.
//!
//! With a separate second moment each, all coordinates move by the same length, and coordinates
//! that the data hardly constrain move as far as those that they determine: noise, for most springs
//! of a body. With a common second moment a coordinate moves in proportion to its gradient, up to
//! the rate.

use std::ops::Range;

use serde::{Deserialize, Serialize};

/// Addend to the divisor, which keeps a step finite where a gradient is zero.
pub const EPSILON: f64 = 1e-12;

/// Gradient over the root mean square of its kind, inverted, from which on a coordinate moves by the
/// whole rate. Gradients differ by orders of magnitude within a kind; with 1 most coordinates would
/// hardly move.
pub const SLOPE: f64 = 7.0;

/// Decay rates of Adam's moments, and the pull towards the start.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Decay {
    /// Decay of the first moment, 0..1.
    pub beta1: f64,
    /// Decay of the second moment, 0..1.
    pub beta2: f64,
    /// Decoupled decay towards the start: share of the distance from it that a coordinate loses in
    /// a step, per unit of learning rate (Loshchilov and Hutter, arXiv 1711.05101, around the start
    /// instead of zero); 0 for none. Gradients whose mean is a share s of their size hold a
    /// coordinate `s / prior` times its relative rate away from the start.
    pub prior: f64,
}

/// Adam's moments. They need the range of f64: squares of small gradients underflow in f32, and
/// [`EPSILON`] then stops a coordinate that should move.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Adam {
    /// Steps made.
    pub steps: u64,
    /// Decaying mean of the gradient, one per coordinate.
    pub first: Vec<f64>,
    /// Decaying mean of the gradient's mean square over the coordinates of a kind, one per kind.
    pub second: Vec<f64>,
}

/// Relative rates, bounds and start of the coordinates, all of one length, and their kinds.
#[derive(Clone, Copy, Debug)]
pub struct Bounds<'a> {
    /// Coordinates of each kind, one range after another.
    pub kinds: &'a [Range<usize>],
    /// Each coordinate's step relative to the learning rate.
    pub rates: &'a [f64],
    /// Least and greatest value of each coordinate.
    pub bounds: &'a [[f64; 2]],
    /// Each coordinate at the start of the run.
    pub start: &'a [f64],
}

impl Adam {
    /// Zero moments for the given numbers of coordinates and kinds.
    pub fn new(coordinates: usize, kinds: usize) -> Self {
        Self { steps: 0, first: vec![0.0; coordinates], second: vec![0.0; kinds] }
    }

    /// Divisors of the moments after this many steps, which correct their start at zero.
    pub fn unbias(steps: u64, decay: Decay) -> [f64; 2] {
        let t = steps.min(i32::MAX as u64) as i32;
        [1.0 - decay.beta1.powi(t), 1.0 - decay.beta2.powi(t)]
    }

    /// Moves `theta` down the gradient: coordinate `i` by at most `rate` times `rates[i]`,
    /// within `bounds[i]`, and towards `start`. Gradients must be finite. All slices have the
    /// lengths of [`Adam::new`].
    pub fn step(
        &mut self,
        theta: &mut [f64],
        gradient: &[f64],
        rate: f64,
        bounds: Bounds<'_>,
        decay: Decay,
    ) {
        self.steps += 1;
        let [unbias_first, unbias_second] = Self::unbias(self.steps, decay);
        let Bounds { kinds, rates, bounds, start } = bounds;
        let back = (decay.prior * rate).clamp(0.0, 1.0);
        for (kind, v) in kinds.iter().zip(&mut self.second) {
            let squares: f64 = gradient[kind.clone()].iter().map(|g| g * g).sum();
            let mean = squares / kind.len().max(1) as f64;
            *v = decay.beta2 * *v + (1.0 - decay.beta2) * mean;
            let size = (*v / unbias_second).sqrt() + EPSILON;
            for i in kind.clone() {
                let (m, x) = (&mut self.first[i], &mut theta[i]);
                *m = decay.beta1 * *m + (1.0 - decay.beta1) * gradient[i];
                let step = (SLOPE * (*m / unbias_first) / size).clamp(-1.0, 1.0);
                let [low, high] = bounds[i];
                *x = (*x - rate * rates[i] * step - back * (*x - start[i])).clamp(low, high);
            }
        }
    }
}

#[cfg(test)]
mod tests;
