//! Adam (Kingma and Ba, arXiv 1412.6980) with a rate per coordinate and bounds.

use serde::{Deserialize, Serialize};

/// Addend to the divisor, which keeps a step finite where a gradient is zero.
pub const EPSILON: f64 = 1e-12;

/// Decay rates of Adam's moments, and the pull towards the start.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Decay {
    /// Of the first moment, 0..1.
    pub beta1: f64,
    /// Of the second moment, 0..1.
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
    /// Decaying mean of the gradient's square, one per coordinate.
    pub second: Vec<f64>,
}

/// Relative rates, bounds and start of the coordinates; all of one length.
#[derive(Clone, Copy, Debug)]
pub struct Bounds<'a> {
    /// Each coordinate's step relative to the learning rate.
    pub rates: &'a [f64],
    /// Least and greatest value of each coordinate.
    pub bounds: &'a [[f64; 2]],
    /// Each coordinate at the start of the run.
    pub start: &'a [f64],
}

impl Adam {
    /// Zero moments for this many coordinates.
    pub fn new(coordinates: usize) -> Self {
        Self { steps: 0, first: vec![0.0; coordinates], second: vec![0.0; coordinates] }
    }

    /// Divisors of the moments after this many steps, which correct their start at zero.
    pub fn unbias(steps: u64, decay: Decay) -> [f64; 2] {
        let t = steps.min(i32::MAX as u64) as i32;
        [1.0 - decay.beta1.powi(t), 1.0 - decay.beta2.powi(t)]
    }

    /// Moves `theta` down the gradient: coordinate `i` by at most about `rate` times `rates[i]`,
    /// within `bounds[i]`, and towards `start`. Gradients must be finite. All slices have the
    /// length of [`Adam::new`].
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
        let moments = self.first.iter_mut().zip(&mut self.second);
        let Bounds { rates, bounds, start } = bounds;
        let constants = gradient.iter().zip(rates).zip(bounds.iter().zip(start));
        let back = (decay.prior * rate).clamp(0.0, 1.0);
        for ((x, (m, v)), ((&g, &relative), (&[low, high], &start))) in
            theta.iter_mut().zip(moments).zip(constants)
        {
            *m = decay.beta1 * *m + (1.0 - decay.beta1) * g;
            *v = decay.beta2 * *v + (1.0 - decay.beta2) * g * g;
            let step = (*m / unbias_first) / ((*v / unbias_second).sqrt() + EPSILON);
            *x = (*x - rate * relative * step - back * (*x - start)).clamp(low, high);
        }
    }
}

#[cfg(test)]
mod tests;
