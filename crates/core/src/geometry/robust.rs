//! The rigid motion on which most pairs agree: Kabsch's, with weights after Tukey that are
//! recomputed a few times from the spread of the distances.

use super::{Alignment, Kabsch, Pair, kabsch, median, vector3};

/// Outlier rule of a robust fit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RobustRule {
    /// Rounds of reweighting.
    pub rounds: usize,
    /// Distances up to a third of this are noise, and not worth distinguishing [m].
    pub least_width_m: f64,
    /// Factor of the width in the first round: a start that outliers have pulled away can come
    /// back.
    pub first_width: f64,
    /// Fewest pairs that have to keep a weight in every round.
    pub least_agreeing: usize,
    /// True if the motion is also fitted to the weights of the last round, false if these only
    /// judge it.
    pub fits_last: bool,
    /// True if distances are those of the motion about the origin in double precision, false if
    /// they are those of points that the motion about its middles takes to positions in single
    /// precision.
    pub about_origin: bool,
    /// The fit of each round.
    pub kabsch: Kabsch,
}

/// A fitted motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RobustFit {
    /// The motion.
    pub motion: Alignment,
    /// Median distance that the motion before the last weights left [m].
    pub residual_m: f64,
}

impl RobustRule {
    /// Weights of the pairs themselves; the start of a fit that has no better one.
    pub fn start(&self, pairs: &[Pair]) -> Option<Alignment> {
        let weights: Vec<f64> = pairs.iter().map(|p| p.weight).collect();
        kabsch(pairs, &weights, &self.kabsch)
    }

    /// Fits from a start; `None` if too few pairs agree or no motion is determined.
    pub fn fit(&self, pairs: &[Pair], start: Alignment) -> Option<RobustFit> {
        let mut motion = start;
        let mut weights = vec![0.0; pairs.len()];
        let mut residuals = vec![0.0; pairs.len()];
        let mut sorted = Vec::with_capacity(pairs.len());
        let mut residual_m = 0.0;
        for round in 0..self.rounds {
            self.measure(&motion, pairs, &mut residuals);
            sorted.clone_from(&residuals);
            residual_m = median(&mut sorted)?;
            let factor = if round == 0 { self.first_width } else { 1.0 };
            let width = (3.0 * residual_m).max(self.least_width_m) * factor;
            for ((weight, residual), pair) in weights.iter_mut().zip(&residuals).zip(pairs) {
                *weight = pair.weight * biweight(residual / width);
            }
            if weights.iter().filter(|w| **w > 0.0).count() < self.least_agreeing {
                return None;
            }
            if self.fits_last || round + 1 < self.rounds {
                motion = kabsch(pairs, &weights, &self.kabsch)?;
            }
        }
        Some(RobustFit { motion, residual_m })
    }

    /// Distances that a motion leaves [m].
    fn measure(&self, motion: &Alignment, pairs: &[Pair], residuals: &mut [f64]) {
        let origin = motion.motion();
        for (residual, pair) in residuals.iter_mut().zip(pairs) {
            let (before, after) = (vector3(pair.before), vector3(pair.after));
            *residual = if self.about_origin {
                (origin.rotation * before + origin.translation - after).norm()
            } else {
                (vector3(motion.apply(pair.before)) - after).norm()
            };
        }
    }
}

/// Tukey's biweight: 1 at a distance of 0, 0 from a distance of 1 on.
pub fn biweight(distance: f64) -> f64 {
    if distance < 1.0 { (1.0 - distance * distance).powi(2) } else { 0.0 }
}
