use proptest::prelude::*;

use super::*;

fn minimise(
    mut strategy: CmaEs,
    generations: u64,
    loss: impl Fn(&[f64]) -> f64,
) -> (CmaEs, Vec<f64>, f64) {
    for _ in 0..generations {
        let samples = strategy.ask();
        let losses: Vec<f64> = samples.iter().map(|s| loss(&s.point)).collect();
        strategy.tell(&samples, &losses);
    }
    let best = strategy.best().unwrap().clone();
    (strategy, best.point, best.loss)
}

fn sphere(x: &[f64]) -> f64 {
    x.iter().map(|x| (x - 0.37) * (x - 0.37)).sum()
}

fn rosenbrock(x: &[f64]) -> f64 {
    // The cube is [-2, 2]^n.
    let x: Vec<f64> = x.iter().map(|x| 4.0 * x - 2.0).collect();
    x.windows(2).map(|w| 100.0 * (w[1] - w[0] * w[0]).powi(2) + (1.0 - w[0]).powi(2)).sum()
}

#[test]
fn finds_the_centre_of_a_sphere() {
    let (_, x, loss) = minimise(CmaEs::new(vec![0.8; 8], 0.2, 0, 1), 200, sphere);
    assert!(loss < 1e-12, "{loss}");
    assert!(x.iter().all(|x| (x - 0.37).abs() < 1e-6));
}

#[test]
fn follows_a_bent_valley() {
    let (_, _, loss) = minimise(CmaEs::new(vec![0.3; 5], 0.1, 16, 3), 500, rosenbrock);
    assert!(loss < 1e-8, "{loss}");
}

#[test]
fn reaches_an_optimum_on_the_boundary() {
    let linear = |x: &[f64]| x.iter().zip([1.0, -1.0, 2.0]).map(|(x, w)| x * w).sum();
    let (_, x, _) = minimise(CmaEs::new(vec![0.5; 3], 1.0 / 6.0, 0, 7), 120, linear);
    for (x, expected) in x.iter().zip([0.0, 1.0, 0.0]) {
        assert!((x - expected).abs() < 1e-3, "{x} for {expected}");
    }
}

#[test]
fn failures_teach_nothing_but_do_not_stop_it() {
    // A third of the cube cannot be simulated, and NaN is as bad as infinity.
    let loss = |x: &[f64]| match x[0] {
        a if a > 0.67 => f64::INFINITY,
        a if a < 0.1 => f64::NAN,
        _ => sphere(x),
    };
    let (_, _, best) = minimise(CmaEs::new(vec![0.6; 4], 0.2, 0, 2), 150, loss);
    assert!(best < 1e-9, "{best}");
}

#[test]
fn a_hopeless_generation_keeps_the_strategy_sane() {
    let mut strategy = CmaEs::new(vec![0.5; 3], 0.3, 0, 0);
    for _ in 0..5 {
        let samples = strategy.ask();
        strategy.tell(&samples, &vec![f64::INFINITY; samples.len()]);
    }
    assert!(strategy.best().is_none());
    assert_eq!(strategy.mean, vec![0.5; 3]);
    let (_, _, loss) = minimise(strategy, 150, sphere);
    assert!(loss < 1e-9, "{loss}");
}

#[test]
fn a_restored_strategy_resumes_bit_for_bit() {
    let run = |store: bool| {
        let mut strategy = CmaEs::new(vec![0.2; 4], 0.2, 0, 9);
        for _ in 0..20 {
            let samples = strategy.ask();
            let losses: Vec<f64> = samples.iter().map(|s| rosenbrock(&s.point)).collect();
            strategy.tell(&samples, &losses);
            if store {
                let bytes = postcard::to_stdvec(&strategy).unwrap();
                strategy = postcard::from_bytes(&bytes).unwrap();
            }
        }
        strategy
    };
    assert_eq!(run(false), run(true));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(32))]

    #[test]
    fn samples_stay_in_the_cube_and_finite(
        seed: u64,
        n in 1_usize..6,
        losses in prop::collection::vec(any::<f64>(), 64),
    ) {
        let mut strategy = CmaEs::new(vec![0.9; n], 0.9, 8, seed);
        for round in losses.chunks(8) {
            let samples = strategy.ask();
            for s in &samples {
                prop_assert!(s.point.iter().all(|x| (0.0..=1.0).contains(x)));
            }
            strategy.tell(&samples, round);
            prop_assert!(strategy.sigma.is_finite() && strategy.sigma > 0.0);
        }
    }
}
