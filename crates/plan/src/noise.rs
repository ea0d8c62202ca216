//! Random changes of a plan.

use rand_chacha::ChaCha12Rng;
use rand_distr::{Distribution as _, StandardNormal};

use crate::Knots;

/// Standard normal numbers for one plan, shape [K, D]; neighbouring knots have the correlation, and
/// each knot a variance of 1: e[k] = r e[k - 1] + sqrt(1 - r^2) n[k]. Row 0 is not to be used: the
/// first that counts is row 1.
pub(crate) fn correlated(
    random: &mut ChaCha12Rng,
    knots: usize,
    dims: usize,
    correlation: f64,
) -> Knots {
    let mut noise: Knots = (0..knots * dims).map(|_| StandardNormal.sample(random)).collect();
    let fresh = (1.0 - correlation * correlation).sqrt();
    for i in 2 * dims..noise.len() {
        noise[i] = correlation * noise[i - dims] + fresh * noise[i];
    }
    noise
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng as _;

    use super::*;

    #[test]
    fn neighbouring_knots_have_the_correlation_that_is_asked_for() {
        let mut random = ChaCha12Rng::seed_from_u64(0);
        let all: Vec<_> = (0..20_000).map(|_| correlated(&mut random, 4, 1, 0.8)).collect();
        let mean = |f: &dyn Fn(&Knots) -> f64| all.iter().map(f).sum::<f64>() / all.len() as f64;
        for k in 1..4 {
            assert!((mean(&|e| e[k] * e[k]) - 1.0).abs() < 0.04);
        }
        assert!((mean(&|e| e[1] * e[2]) - 0.8).abs() < 0.04);
        assert!((mean(&|e| e[1] * e[3]) - 0.64).abs() < 0.04);
    }
}
