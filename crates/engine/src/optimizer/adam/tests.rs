use super::*;

const DECAY: Decay = Decay { beta1: 0.9, beta2: 0.99, prior: 0.0 };

#[test]
fn the_first_step_has_the_length_of_the_rate() {
    let mut theta = [1.0, 1.0, 1.0];
    let bounds = [[-10.0, 10.0]; 3];
    let bounds = Bounds { rates: &[1.0; 3], bounds: &bounds, start: &[1.0; 3] };
    Adam::new(3).step(&mut theta, &[3e-7, -4e5, 0.0], 0.1, bounds, DECAY);
    for (x, expected) in theta.iter().zip([0.9, 1.1, 1.0]) {
        assert!((x - expected).abs() < 1e-5, "{x} for {expected}");
    }
}

#[test]
fn descends_a_badly_scaled_bowl_and_respects_bounds() {
    let (mut adam, mut theta) = (Adam::new(2), [5.0, 5.0]);
    let bounds = [[-9.0, 9.0], [-1.0, 9.0]];
    let bounds = Bounds { rates: &[1.0; 2], bounds: &bounds, start: &[5.0; 2] };
    for _ in 0..2000 {
        let gradient = [1e4 * theta[0], 1e-3 * (theta[1] + 3.0)];
        adam.step(&mut theta, &gradient, 0.02, bounds, DECAY);
    }
    assert!(theta[0].abs() < 0.05, "{}", theta[0]);
    assert_eq!(theta[1], -1.0);
}

/// A gradient that keeps its sign holds a coordinate `1 / prior` times its relative rate from the
/// start; one that is gone lets it come back.
#[test]
fn the_start_draws_coordinates_back() {
    let decay = Decay { prior: 0.5, ..DECAY };
    let (mut adam, mut theta) = (Adam::new(2), [1.0, 1.0]);
    let bounds = Bounds { rates: &[1.0, 0.1], bounds: &[[-9.0, 9.0]; 2], start: &[1.0; 2] };
    for _ in 0..2000 {
        adam.step(&mut theta, &[-1.0, 1.0], 0.05, bounds, decay);
    }
    assert!((theta[0] - 3.0).abs() < 1e-6 && (theta[1] - 0.8).abs() < 1e-6, "{theta:?}");
    for _ in 0..4000 {
        adam.step(&mut theta, &[0.0; 2], 0.05, bounds, decay);
    }
    assert!(theta.iter().all(|x| (x - 1.0).abs() < 1e-6), "{theta:?}");
}
