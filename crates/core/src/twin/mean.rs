//! The mean prediction of a twin's fits.

use super::Twin;
use crate::Point;

/// Least weight of a fit, relative to the fit with the lowest loss.
const LEAST_SHARE: f64 = 1e-12;

impl Twin {
    /// Weights of the fits in their mean prediction, which add up to 1, shape [1 + members]: the
    /// twin's own first. Each is in proportion to one over the square of the loss; where the loss of
    /// a fit is not known, all are equal.
    pub fn fit_weights(&self) -> Vec<f64> {
        let own = std::iter::once(self.provenance.loss);
        let losses: Option<Vec<f64>> = own.chain(self.members.iter().map(|m| m.loss)).collect();
        let Some(losses) = losses else {
            let fits = 1 + self.members.len();
            return vec![1.0 / fits as f64; fits];
        };
        // By the least of them, so that a loss of 0 has a weight too. Each has some, so that any can stand
        // alone where the others have diverged.
        let least = losses.iter().copied().fold(f64::INFINITY, f64::min);
        let ratio = |loss: &f64| if *loss == least { 1.0 } else { least / loss };
        let share = |loss: &f64| ratio(loss).powi(2).max(LEAST_SHARE);
        let shares: Vec<f64> = losses.iter().map(share).collect();
        let sum: f64 = shares.iter().sum();
        shares.iter().map(|share| share / sum).collect()
    }
}

/// A weighted mean of predictions of the same points, in the making. A prediction that is not added has
/// no share: its weight goes to the others.
#[derive(Clone, Debug, Default)]
pub struct Mean {
    sums: Vec<[f64; 3]>,
    weight: f64,
}

impl Mean {
    /// Adds a prediction, as many points as in the first.
    pub fn add(&mut self, weight: f64, points: &[Point]) {
        self.sums.resize(self.sums.len().max(points.len()), [0.0; 3]);
        for (sum, point) in self.sums.iter_mut().zip(points) {
            for (sum, x) in sum.iter_mut().zip(point) {
                *sum += weight * f64::from(*x);
            }
        }
        self.weight += weight;
    }

    /// The mean; no points if nothing was added.
    pub fn points(&self) -> Vec<Point> {
        self.sums.iter().map(|sum| sum.map(|x| (x / self.weight) as f32)).collect()
    }
}
