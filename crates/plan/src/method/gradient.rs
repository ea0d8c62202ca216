//! Adam along the gradient of the cost, from several plans at once.

use rand_chacha::ChaCha12Rng;

use crate::{Knots, noise::correlated, settings::Settings};

const FIRST: f64 = 0.9;
const SECOND: f64 = 0.99;

/// Plans under way, with the moments of their gradients.
#[derive(Clone, Debug)]
pub(crate) struct Descent {
    plans: Vec<Knots>,
    first: Vec<Knots>,
    second: Vec<Knots>,
    steps: i32,
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
        Self { plans, first: zeros.clone(), second: zeros, steps: 0 }
    }

    pub(crate) fn plans(&self) -> Vec<Knots> {
        self.plans.clone()
    }

    /// Steps down; a plan that diverged goes on from the best one.
    pub(crate) fn learn(
        &mut self,
        settings: &Settings,
        rate: &[f64],
        costs: &[f64],
        gradients: &[Knots],
        best: &Knots,
    ) {
        self.steps += 1;
        let (bias1, bias2) = (1.0 - FIRST.powi(self.steps), 1.0 - SECOND.powi(self.steps));
        for (p, plan) in self.plans.iter_mut().enumerate() {
            let gradient = &gradients[p];
            let is_whole = costs[p].is_finite() && gradient.iter().all(|g| g.is_finite());
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
