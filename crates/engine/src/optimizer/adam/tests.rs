use super::*;

const DECAY: Decay = Decay { beta1: 0.9, beta2: 0.99, prior: 0.0 };

/// Two coordinates of one kind and one of another, all with rate 1 and wide bounds.
fn wide<'a>(kinds: &'a [Range<usize>], start: &'a [f64]) -> Bounds<'a> {
    Bounds { kinds, rates: &[1.0; 3], bounds: &[[-10.0, 10.0]; 3], start }
}

#[test]
fn the_first_step_has_the_length_of_the_rate_at_most() {
    let kinds = [0..2, 2..3];
    let mut theta = [1.0; 3];
    let mut adam = Adam::new(3, 2);
    adam.step(&mut theta, &[3e5, -4e5, 2e-7], 0.1, wide(&kinds, &[1.0; 3]), DECAY);
    for (x, expected) in theta.iter().zip([0.9, 1.1, 0.9]) {
        assert!((x - expected).abs() < 1e-5, "{x} for {expected}");
    }
    assert_eq!(adam.second.len(), 2);
}

#[test]
fn within_a_kind_steps_are_in_proportion_to_gradients() {
    let kinds = [0..2, 2..3];
    let mut theta = [0.0; 3];
    let gradient = [1e-3, 1.0, 0.0];
    Adam::new(3, 2).step(&mut theta, &gradient, 0.1, wide(&kinds, &[0.0; 3]), DECAY);
    assert!((theta[1] + 0.1).abs() < 1e-9, "{theta:?}");
    let root_mean_square = (0.5 * (1.0 + 1e-6_f64)).sqrt();
    let expected = -0.1 * SLOPE * 1e-3 / root_mean_square;
    assert!((theta[0] - expected).abs() < 1e-9, "{theta:?}, {expected}");
    assert_eq!(theta[2], 0.0);
}

#[test]
fn descends_a_badly_scaled_bowl_of_two_kinds_and_respects_bounds() {
    let (mut adam, mut theta) = (Adam::new(2, 2), [5.0, 5.0]);
    let bounds = [[-9.0, 9.0], [-1.0, 9.0]];
    let bounds =
        Bounds { kinds: &[0..1, 1..2], rates: &[1.0; 2], bounds: &bounds, start: &[5.0; 2] };
    for step in 0..3000 {
        let gradient = [1e4 * theta[0], 1e-3 * (theta[1] + 3.0)];
        let rate = 0.02 * (1.0 - f64::from(step) / 3000.0);
        adam.step(&mut theta, &gradient, rate, bounds, DECAY);
    }
    assert!(theta[0].abs() < 0.05, "{}", theta[0]);
    assert_eq!(theta[1], -1.0);
}

/// A gradient that keeps its sign holds a coordinate at `1 / prior` times its relative rate from
/// the start; when it vanishes, the coordinate returns.
#[test]
fn the_start_draws_coordinates_back() {
    let decay = Decay { prior: 0.5, ..DECAY };
    let (mut adam, mut theta) = (Adam::new(2, 1), [1.0, 1.0]);
    let kinds = [Range { start: 0, end: 2 }];
    let bounds = [[-9.0, 9.0]; 2];
    let bounds = Bounds { kinds: &kinds, rates: &[1.0, 0.1], bounds: &bounds, start: &[1.0; 2] };
    for _ in 0..2000 {
        adam.step(&mut theta, &[-1.0, 1.0], 0.05, bounds, decay);
    }
    assert!((theta[0] - 3.0).abs() < 1e-6 && (theta[1] - 0.8).abs() < 1e-6, "{theta:?}");
    for _ in 0..4000 {
        adam.step(&mut theta, &[0.0; 2], 0.05, bounds, decay);
    }
    assert!(theta.iter().all(|x| (x - 1.0).abs() < 1e-6), "{theta:?}");
}
