//! The running mean of a run's positions.
//!
//! Steps of a constant length end in circling a minimum; the mean of the positions lies nearer to it
//! than any of them. It does in a fit what a rate that falls towards the last pass does, without
//! knowing which pass will be the last (Polyak and Juditsky 1992, doi:10.1137/0330046).

use serde::{Deserialize, Serialize};

/// Weight of the newest position: the mean reaches back about twenty passes.
const NEWEST: f64 = 0.05;
/// Passes between two scores of the mean, each of which costs a rollout.
const EVERY: u32 = 10;

/// The mean of the positions since the start or since the last return to the best parameters.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Average(Vec<f64>);

impl Average {
    /// True if the mean is scored at the end of this pass, counted from 0.
    pub(crate) fn is_due(pass: u32) -> bool {
        (pass + 1).is_multiple_of(EVERY)
    }

    /// The mean, if there is a position in it.
    pub(crate) fn theta(&self) -> Option<&[f64]> {
        (!self.0.is_empty()).then_some(&self.0[..])
    }

    /// Takes in the position after a pass.
    pub(crate) fn add(&mut self, theta: &[f64]) {
        if self.0.is_empty() {
            self.0 = theta.to_vec();
        }
        self.0.iter_mut().zip(theta).for_each(|(mean, x)| *mean += NEWEST * (x - *mean));
    }

    /// Forgets all positions.
    pub(crate) fn clear(&mut self) {
        self.0.clear();
    }
}

#[cfg(test)]
mod tests;
