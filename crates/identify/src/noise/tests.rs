use super::*;

/// Numbers without a pattern, -1..1.
fn scattered(index: usize) -> f64 {
    let mut x = (index as u64 + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    x ^= x >> 29;
    x = x.wrapping_mul(0xbf58_476d_1ce4_e5b9);
    x ^= x >> 32;
    (x % 20_001) as f64 / 10_000.0 - 1.0
}

fn residuals(
    frames: usize,
    points: usize,
    of: impl Fn(usize, usize, usize) -> f64,
) -> Vec<Residuals> {
    let point = |t, p| Some(std::array::from_fn(|a| 0.01 * of(t, p, a)));
    (0..frames).map(|t| (0..points).map(|p| point(t, p)).collect()).collect()
}

#[test]
fn independent_residuals_count_one_by_one() {
    let all = residuals(40, 10, |t, p, a| scattered(t * 1000 + 10 * p + a));
    let noise = Noise::of(&all).unwrap();
    assert!(noise.frames < 1.3, "{noise:?}");
    assert!(noise.points > 8.0, "{noise:?}");
    assert!((noise.sd_m - 0.01 / 3.0_f64.sqrt()).abs() < 5e-4, "{noise:?}");
}

#[test]
fn lasting_errors_and_correlated_neighbours_count_once() {
    let lasting = Noise::of(&residuals(40, 10, |_, p, a| scattered(10 * p + a))).unwrap();
    assert_eq!(lasting.frames, 40.0);
    let alike = Noise::of(&residuals(40, 10, |t, _, a| scattered(10 * t + a))).unwrap();
    assert!((alike.points - 1.0).abs() < 1e-9, "{alike:?}");
    let few = alike.weight(40, 8, 10);
    let free = Noise { points: 10.0, ..alike }.weight(40, 8, 10);
    assert!((free / few - 10.0).abs() < 1e-6, "{few} {free}");
}

#[test]
fn nothing_seen_is_no_noise_and_a_perfect_fit_has_that_of_a_camera() {
    assert_eq!(Noise::of(&[vec![None; 3]]), None);
    let perfect = Noise::of(&residuals(5, 3, |_, _, _| 0.0)).unwrap();
    assert_eq!((perfect.sd_m, perfect.frames, perfect.points), (LEAST_M, 1.0, 3.0));
}
