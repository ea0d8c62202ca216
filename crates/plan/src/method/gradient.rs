//! Adam along the gradient of the cost, from several plans in parallel.

use rand_chacha::ChaCha12Rng;

use super::still;
use crate::{Knots, noise::correlated, settings::Settings};

const FIRST: f64 = 0.9;
const SECOND: f64 = 0.99;

/// Plans under way, with the moments of their gradients.
#[derive(Clone, Debug)]
pub(crate) struct Descent {
    plans: Vec<Knots>,
    /// Last state of each plan within the limit; `None` if it never was.
    kept: Vec<Option<Knots>>,
    first: Vec<Knots>,
    second: Vec<Knots>,
    steps: i32,
}

/// The simulation of the plans.
pub(crate) struct Batch {
    /// True for each that diverged.
    pub(crate) diverged: Vec<bool>,
    /// True for each that is beyond the limit.
    pub(crate) beyond: Vec<bool>,
    /// d cost / d knots of each, shape [K, D].
    pub(crate) gradients: Vec<Knots>,
}

impl Descent {
    pub(crate) fn begin(settings: &Settings, nominal: &Knots, random: &mut ChaCha12Rng) -> Self {
        let sigma = settings.deviations();
        let mut plans = vec![nominal.clone()];
        while plans.len() < settings.samples {
            let mut plan = correlated(random, settings.knots, settings.dims, settings.correlation);
            for ((x, n), s) in plan.iter_mut().zip(nominal).zip(&sigma) {
                *x = n + s * *x;
            }
            settings.project(&mut plan);
            plans.push(plan);
        }
        let zeros = vec![vec![0.0; nominal.len()]; plans.len()];
        let kept = vec![None; plans.len()];
        Self { plans, kept, first: zeros.clone(), second: zeros, steps: 0 }
    }

    pub(crate) fn plans(&self) -> Vec<Knots> {
        self.plans.clone()
    }

    /// Steps down; a plan that diverged restarts from the best one. A plan beyond the limit, where
    /// the gradient of the cost gives no direction back, moves halfway back to its last position
    /// within the limit, to the best plan if that is within the limit, or to staying still, and
    /// restarts there.
    pub(crate) fn learn(
        &mut self,
        settings: &Settings,
        rate: &[f64],
        batch: &Batch,
        (best, best_keeps_limit): (&Knots, bool),
    ) {
        self.steps += 1;
        let (bias1, bias2) = (1.0 - FIRST.powi(self.steps), 1.0 - SECOND.powi(self.steps));
        for (p, plan) in self.plans.iter_mut().enumerate() {
            let gradient = &batch.gradients[p];
            if batch.beyond[p] && !batch.diverged[p] {
                let safe = self.kept[p].clone().or_else(|| best_keeps_limit.then(|| best.clone()));
                let safe = safe.unwrap_or_else(|| still(plan, settings.dims));
                plan.iter_mut().zip(&safe).for_each(|(x, to)| *x = 0.5 * (*x + to));
                self.first[p].fill(0.0);
                self.second[p].fill(0.0);
                settings.project(plan);
                continue;
            }
            let is_whole = !batch.diverged[p] && gradient.iter().all(|g| g.is_finite());
            if !batch.diverged[p] {
                self.kept[p] = Some(plan.clone());
            }
            if !is_whole {
                plan.clone_from(best);
            }
            for i in 0..plan.len() {
                let is_free = is_whole && i >= settings.dims;
                let g = if is_free { gradient[i] } else { 0.0 };
                let (first, second) = (&mut self.first[p][i], &mut self.second[p][i]);
                *first = FIRST * *first + (1.0 - FIRST) * g;
                *second = SECOND * *second + (1.0 - SECOND) * g * g;
                let scale = (*second / bias2).sqrt();
                if scale > 0.0 {
                    plan[i] -= rate[i % rate.len()] * (*first / bias1) / scale;
                }
            }
            settings.project(plan);
        }
    }
}
