use super::*;

const DECAY: Decay = Decay { beta1: 0.9, beta2: 0.99 };

#[test]
fn the_first_step_has_the_length_of_the_rate() {
    let mut theta = [1.0, 1.0, 1.0];
    let bounds = [[-10.0, 10.0]; 3];
    Adam::new(3).step(&mut theta, &[3e-7, -4e5, 0.0], &[0.1, 0.1, 0.1], &bounds, DECAY);
    for (x, expected) in theta.iter().zip([0.9, 1.1, 1.0]) {
        assert!((x - expected).abs() < 1e-5, "{x} for {expected}");
    }
}

#[test]
fn descends_a_badly_scaled_bowl_and_respects_bounds() {
    let (mut adam, mut theta) = (Adam::new(2), [5.0, 5.0]);
    for _ in 0..2000 {
        let gradient = [1e4 * theta[0], 1e-3 * (theta[1] + 3.0)];
        adam.step(&mut theta, &gradient, &[0.02; 2], &[[-9.0, 9.0], [-1.0, 9.0]], DECAY);
    }
    assert!(theta[0].abs() < 0.05, "{}", theta[0]);
    assert_eq!(theta[1], -1.0);
}
