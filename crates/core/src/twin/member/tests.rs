use super::*;

#[test]
fn the_spread_is_the_root_mean_square_distance_of_the_others() {
    let own = [[0.0; 3], [1.0, 0.0, 0.0]];
    let near = [[0.3, 0.0, 0.0], [1.0, 0.0, 0.0]];
    let far = [[0.0, 0.4, 0.0], [1.0, 0.0, 1.0]];
    let spreads = spread(&own, &[&near, &far]);
    let expected = [(0.25_f32 / 2.0).sqrt(), 0.5_f32.sqrt()];
    for (spread, expected) in spreads.iter().zip(expected) {
        assert!((spread - expected).abs() < 1e-6, "{spreads:?}");
    }
    assert_eq!(spread(&own, &[]), [0.0, 0.0]);
    // One that diverged says nothing of how far the others are.
    assert!(spread(&own, &[&near, &[[f32::NAN; 3]; 2]]).iter().all(|s| s.is_nan()));
    assert!(spread(&own, &[&near[..1]])[1].is_nan());
}
