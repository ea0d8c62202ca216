use super::*;

#[test]
fn the_exponential_is_exact_to_rounding() {
    for k in 0..100_000 {
        let x = k as f32 * 8e-4;
        let expected = f64::from(-x).exp();
        let error = (f64::from(exp_minus(x)) - expected).abs() / expected;
        // The series leaves 1.2e-7, rounding of the argument x 6e-8.
        assert!(error < 3e-7 + 1.2e-7 * f64::from(x), "exp(-{x}): {error:e}");
    }
    assert_eq!(exp_minus(0.0), 1.0);
    for x in [1e3, 1e10, f32::MAX, f32::INFINITY] {
        assert!((0.0..1e-37).contains(&exp_minus(x)), "{x}");
    }
}
