//! Adam (Kingma and Ba, arXiv 1412.6980) with a rate per coordinate and bounds.

use serde::{Deserialize, Serialize};

/// Keeps the step finite where a gradient is zero.
pub const EPSILON: f64 = 1e-12;

/// Decay of the moments.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Decay {
    /// Of the first moment, 0..1.
    pub beta1: f64,
    /// Of the second moment, 0..1.
    pub beta2: f64,
}

/// The moments. They want the range of f64: squares of small gradients are nothing in f32, and
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

impl Adam {
    /// No moments yet for so many coordinates.
    pub fn new(coordinates: usize) -> Self {
        Self { steps: 0, first: vec![0.0; coordinates], second: vec![0.0; coordinates] }
    }

    /// What the moments are divided by after so many steps, for they start at zero.
    pub fn unbias(steps: u64, decay: Decay) -> [f64; 2] {
        let t = steps.min(i32::MAX as u64) as i32;
        [1.0 - decay.beta1.powi(t), 1.0 - decay.beta2.powi(t)]
    }

    /// Moves `theta` down the gradient: coordinate `i` by at most about `rates[i]`, within `bounds[i]`.
    /// Gradients must be finite. All slices have the length of [`Adam::new`].
    pub fn step(
        &mut self,
        theta: &mut [f64],
        gradient: &[f64],
        rates: &[f64],
        bounds: &[[f64; 2]],
        decay: Decay,
    ) {
        self.steps += 1;
        let [unbias_first, unbias_second] = Self::unbias(self.steps, decay);
        let moments = self.first.iter_mut().zip(&mut self.second);
        let constants = gradient.iter().zip(rates).zip(bounds);
        for ((x, (m, v)), ((&g, &rate), &[low, high])) in
            theta.iter_mut().zip(moments).zip(constants)
        {
            *m = decay.beta1 * *m + (1.0 - decay.beta1) * g;
            *v = decay.beta2 * *v + (1.0 - decay.beta2) * g * g;
            let step = rate * (*m / unbias_first) / ((*v / unbias_second).sqrt() + EPSILON);
            *x = (*x - step).clamp(low, high);
        }
    }
}

#[cfg(test)]
mod tests;
