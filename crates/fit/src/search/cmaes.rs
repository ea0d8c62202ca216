//! CMA-ES with an ask-and-tell interface: minimises a black box over the unit cube.
//!
//! After Hansen, "The CMA Evolution Strategy: A Tutorial" (arXiv 1604.00772), with positive
//! weights, rank-one and rank-mu update and cumulative step-size adaptation. Bounds are kept by
//! reflection: the strategy works in unbounded space, which is mapped to the cube by repeated
//! reflection, so that its statistics stay undisturbed. Samples depend on seed and generation only:
//! a strategy that was stored and restored generates exactly the samples that it would have
//! generated otherwise.

use nalgebra::{DMatrix, DVector, SymmetricEigen};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use serde::{Deserialize, Serialize};

/// Smallest and largest step size; beyond them the samples coincide or are noise.
const SIGMA_RANGE: [f64; 2] = [1e-12, 1.0];
/// Smallest ratio of the shortest to the longest axis of the sampling ellipsoid (variances).
const MIN_CONDITION: f64 = 1e-14;

/// A CMA-ES strategy. Its serialized form is a complete checkpoint.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct CmaEs {
    seed: u64,
    population: usize,
    generation: u64,
    sigma: f64,
    mean: Vec<f64>,
    /// Covariance, shape [n, n].
    covariance: Vec<f64>,
    path_sigma: Vec<f64>,
    path_c: Vec<f64>,
    best: Option<Best>,
}

/// The best point so far.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Best {
    /// The point, in the unit cube.
    pub point: Vec<f64>,
    /// Loss of the candidate.
    pub loss: f64,
    /// The generation that found it.
    pub generation: u64,
}

/// A sample: its unbounded coordinates, and the point of the cube that they map to.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Sample {
    /// Unbounded coordinates, for [`CmaEs::tell`].
    genotype: Vec<f64>,
    /// The point to evaluate, in the unit cube.
    pub point: Vec<f64>,
}

/// The population that Hansen recommends for this many variables.
pub(crate) fn default_population(variables: usize) -> usize {
    4 + (3.0 * (variables.max(1) as f64).ln()).floor() as usize
}

impl CmaEs {
    /// Starts at `mean` (in the unit cube) with step size `sigma`; a population of 0 means the
    /// default.
    pub(crate) fn new(mean: Vec<f64>, sigma: f64, population: usize, seed: u64) -> Self {
        let n = mean.len();
        let population = if population == 0 { default_population(n) } else { population.max(2) };
        let covariance = DMatrix::<f64>::identity(n, n).as_slice().to_vec();
        Self {
            seed,
            population,
            generation: 0,
            sigma: sigma.clamp(SIGMA_RANGE[0], SIGMA_RANGE[1]),
            mean,
            covariance,
            path_sigma: vec![0.0; n],
            path_c: vec![0.0; n],
            best: None,
        }
    }

    /// Number of completed generations.
    pub(crate) fn generation(&self) -> u64 {
        self.generation
    }

    /// The best point so far; `None` while no loss was finite.
    pub(crate) fn best(&self) -> Option<&Best> {
        self.best.as_ref()
    }

    /// The samples of the current generation, unchanged until the next [`CmaEs::tell`].
    pub(crate) fn ask(&self) -> Vec<Sample> {
        let n = self.mean.len();
        let mut rng = ChaCha8Rng::seed_from_u64(self.seed);
        rng.set_stream(self.generation);
        let axes = self.axes();
        (0..self.population)
            .map(|_| {
                let z = DVector::from_fn(n, |_, _| StandardNormal.sample(&mut rng));
                let step: DVector<f64> = &axes.vectors * axes.lengths.component_mul(&z);
                let genotype: Vec<f64> =
                    self.mean.iter().zip(step.iter()).map(|(m, s)| m + self.sigma * s).collect();
                let point = genotype.iter().map(|&x| reflect(x)).collect();
                Sample { genotype, point }
            })
            .collect()
    }

    /// Updates the strategy with the losses of [`CmaEs::ask`]'s samples. NaN and infinity rank last
    /// and do not contribute; a generation without any finite loss only lets the step size shrink.
    pub(crate) fn tell(&mut self, samples: &[Sample], losses: &[f64]) {
        let mut order: Vec<usize> =
            (0..samples.len().min(losses.len())).filter(|&i| losses[i].is_finite()).collect();
        order.sort_by(|&a, &b| losses[a].total_cmp(&losses[b]).then(a.cmp(&b)));
        if let Some(&first) = order.first() {
            if self.best.as_ref().is_none_or(|b| losses[first] < b.loss) {
                self.best = Some(Best {
                    point: samples[first].point.clone(),
                    loss: losses[first],
                    generation: self.generation,
                });
            }
            let ranked: Vec<&[f64]> =
                order.iter().map(|&i| samples[i].genotype.as_slice()).collect();
            self.update(&ranked);
        } else {
            self.sigma = (0.7 * self.sigma).max(SIGMA_RANGE[0]);
        }
        self.generation += 1;
    }

    /// The update proper, from the finite samples, best first.
    fn update(&mut self, ranked: &[&[f64]]) {
        let n = self.mean.len();
        let dimension = n as f64;
        // Fewer parents where many samples failed: a failure must not vote.
        let parents = (self.population / 2).clamp(1, ranked.len());
        let raw: Vec<f64> =
            (0..parents).map(|i| (parents as f64 + 0.5).ln() - ((i + 1) as f64).ln()).collect();
        let total: f64 = raw.iter().sum();
        let weights: Vec<f64> = raw.iter().map(|w| w / total).collect();
        let mu_eff = 1.0 / weights.iter().map(|w| w * w).sum::<f64>();

        let c_sigma = (mu_eff + 2.0) / (dimension + mu_eff + 5.0);
        let d_sigma =
            1.0 + 2.0 * (((mu_eff - 1.0) / (dimension + 1.0)).sqrt() - 1.0).max(0.0) + c_sigma;
        let c_c = (4.0 + mu_eff / dimension) / (dimension + 4.0 + 2.0 * mu_eff / dimension);
        let c_1 = 2.0 / ((dimension + 1.3).powi(2) + mu_eff);
        let c_mu = (2.0 * (mu_eff - 2.0 + 1.0 / mu_eff) / ((dimension + 2.0).powi(2) + mu_eff))
            .clamp(0.0, 1.0 - c_1);
        let chi = dimension.sqrt()
            * (1.0 - 1.0 / (4.0 * dimension) + 1.0 / (21.0 * dimension * dimension));

        let steps: Vec<DVector<f64>> = ranked[..parents]
            .iter()
            .map(|x| DVector::from_fn(n, |i, _| (x[i] - self.mean[i]) / self.sigma))
            .collect();
        let mut step = DVector::zeros(n);
        for (w, y) in weights.iter().zip(&steps) {
            step.axpy(*w, y, 1.0);
        }
        let axes = self.axes();
        let whitened =
            &axes.vectors * (axes.vectors.transpose() * &step).component_div(&axes.lengths);

        let mut path_sigma = DVector::from_column_slice(&self.path_sigma);
        path_sigma *= 1.0 - c_sigma;
        path_sigma.axpy((c_sigma * (2.0 - c_sigma) * mu_eff).sqrt(), &whitened, 1.0);
        let length = path_sigma.norm();
        let age = 1.0 - (1.0 - c_sigma).powf(2.0 * (self.generation + 1) as f64);
        let is_steady = length / age.sqrt() < (1.4 + 2.0 / (dimension + 1.0)) * chi;

        let mut path_c = DVector::from_column_slice(&self.path_c);
        path_c *= 1.0 - c_c;
        if is_steady {
            path_c.axpy((c_c * (2.0 - c_c) * mu_eff).sqrt(), &step, 1.0);
        }

        let mut covariance = DMatrix::from_column_slice(n, n, &self.covariance);
        let stalled = if is_steady { 0.0 } else { c_1 * c_c * (2.0 - c_c) };
        covariance *= 1.0 - c_1 - c_mu + stalled;
        covariance.ger(c_1, &path_c, &path_c, 1.0);
        for (w, y) in weights.iter().zip(&steps) {
            covariance.ger(c_mu * w, y, y, 1.0);
        }

        for (m, s) in self.mean.iter_mut().zip(step.iter()) {
            *m += self.sigma * s;
        }
        let growth = ((c_sigma / d_sigma) * (length / chi - 1.0)).min(1.0).exp();
        self.sigma = (self.sigma * growth).clamp(SIGMA_RANGE[0], SIGMA_RANGE[1]);
        self.path_sigma = path_sigma.as_slice().to_vec();
        self.path_c = path_c.as_slice().to_vec();
        // Rounding must not let the matrix drift away from symmetry.
        self.covariance = (0.5 * (&covariance + covariance.transpose())).as_slice().to_vec();
    }

    fn axes(&self) -> Axes {
        let n = self.mean.len();
        let eigen = SymmetricEigen::new(DMatrix::from_column_slice(n, n, &self.covariance));
        let longest = eigen.eigenvalues.max().max(f64::MIN_POSITIVE);
        let lengths = eigen.eigenvalues.map(|v| v.max(longest * MIN_CONDITION).sqrt());
        Axes { vectors: eigen.eigenvectors, lengths }
    }
}

/// Principal axes of the sampling ellipsoid.
struct Axes {
    vectors: DMatrix<f64>,
    lengths: DVector<f64>,
}

/// The point of the unit interval whose mirror image in the interval's ends is `x`.
fn reflect(x: f64) -> f64 {
    let folded = x.rem_euclid(2.0);
    if folded > 1.0 { 2.0 - folded } else { folded }
}

#[cfg(test)]
mod tests;
