//! Samples around a mean, which is also simulated, and at first the plan to stay still.

use rand_chacha::ChaCha12Rng;

use super::Method;
use crate::{Knots, noise::correlated, settings::Settings};

/// Mean and spread that a sampling method has arrived at.
#[derive(Clone, Debug)]
pub(crate) struct Sampling {
    center: Knots,
    spread: Knots,
    sigma: Knots,
    /// The mean was not simulated yet.
    is_new: bool,
    is_first: bool,
}

impl Sampling {
    pub(crate) fn begin(settings: &Settings, nominal: &Knots) -> Self {
        let sigma = settings.deviations();
        Self {
            center: nominal.clone(),
            spread: sigma.clone(),
            sigma,
            is_new: false,
            is_first: true,
        }
    }

    /// The mean if it is new, and samples around it. At first the mean is the nominal plan, which
    /// the caller adds; a misleading one competes with a plan that ends the motion.
    pub(crate) fn propose(&mut self, settings: &Settings, random: &mut ChaCha12Rng) -> Vec<Knots> {
        let mut plans: Vec<Knots> = self.mean().into_iter().collect();
        self.is_new = false;
        if self.is_first {
            plans.push(still(&self.center, settings.dims));
        }
        let others = 1 + usize::from(std::mem::take(&mut self.is_first));
        let count = settings.samples.saturating_sub(others).max(1);
        for scale in settings.scales(count) {
            let mut plan = correlated(random, settings.knots, settings.dims, settings.correlation);
            for ((x, c), s) in plan.iter_mut().zip(&self.center).zip(&self.spread) {
                *x = c + scale * s * *x;
            }
            plans.push(plan);
        }
        plans
    }

    pub(crate) fn mean(&self) -> Option<Knots> {
        self.is_new.then(|| self.center.clone())
    }

    /// Learns from plans and their costs, of which the first is the best of all iterations.
    pub(crate) fn learn(&mut self, method: &Method, plans: &[&Knots], costs: &[f64]) {
        match method {
            Method::Mppi { temperature } => {
                let weights = path_integral_weights(costs, *temperature);
                self.center = weighted(plans, &weights);
                self.is_new = true;
            }
            Method::Cem { elites, memory, smallest } => {
                let mut order: Vec<usize> =
                    (0..costs.len()).filter(|i| costs[*i].is_finite()).collect();
                order.sort_by(|a, b| costs[*a].total_cmp(&costs[*b]));
                let chosen: Vec<&Knots> = order.iter().take(*elites).map(|i| plans[*i]).collect();
                self.narrow(&chosen, *memory, *smallest);
                self.is_new = true;
            }
            Method::PredictiveSampling | Method::Gradient { .. } => {
                if let Some(best) = plans.first() {
                    self.center.clone_from(best);
                }
            }
        }
    }

    fn narrow(&mut self, chosen: &[&Knots], memory: f64, smallest: f64) {
        let count = chosen.len() as f64;
        for i in 0..self.center.len() {
            let mean = chosen.iter().map(|plan| plan[i]).sum::<f64>() / count;
            let variance = chosen.iter().map(|plan| (plan[i] - mean).powi(2)).sum::<f64>() / count;
            self.center[i] = memory * self.center[i] + (1.0 - memory) * mean;
            let spread = memory * self.spread[i] + (1.0 - memory) * variance.sqrt();
            self.spread[i] = spread.max(smallest * self.sigma[i]);
        }
    }
}

/// The plan that stays where it begins.
pub(crate) fn still(plan: &Knots, dims: usize) -> Knots {
    plan.iter().take(dims).copied().cycle().take(plan.len()).collect()
}

/// Softmax of -cost, scaled by the costs' spread, which sums to 1; what diverged weighs nothing.
fn path_integral_weights(costs: &[f64], temperature: f64) -> Vec<f64> {
    let finite = || costs.iter().copied().filter(|c| c.is_finite());
    let low = finite().fold(f64::INFINITY, f64::min);
    let spread = (finite().fold(low, f64::max) - low).max(f64::MIN_POSITIVE);
    let weight = |c: &f64| match c.is_finite() {
        true => (-(c - low) / spread / temperature).exp(),
        false => 0.0,
    };
    let weights: Vec<f64> = costs.iter().map(weight).collect();
    let sum: f64 = weights.iter().sum();
    weights.iter().map(|w| w / sum).collect()
}

fn weighted(plans: &[&Knots], weights: &[f64]) -> Knots {
    let mut mean = vec![0.0; plans.first().map_or(0, |plan| plan.len())];
    for (plan, weight) in plans.iter().zip(weights) {
        mean.iter_mut().zip(*plan).for_each(|(m, x)| *m += weight * x);
    }
    mean
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn diverged_plans_weigh_nothing() {
        assert_eq!(path_integral_weights(&[1.0, f64::INFINITY, 1.0], 0.1), [0.5, 0.0, 0.5]);
        let weights = path_integral_weights(&[0.0, 1.0], 1.0);
        assert!((weights[0] - 1.0 / (1.0 + (-1.0f64).exp())).abs() < 1e-12);
    }
}
