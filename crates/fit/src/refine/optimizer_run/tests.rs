use super::*;

#[test]
fn no_gradient_counts_with_more_than_the_median_norm() {
    let of = |norms: &[f64]| -> Vec<f64> {
        norms.iter().zip(weights(norms)).map(|(n, w)| n * w).collect()
    };
    assert_eq!(of(&[1.0, 2.0, 1e6, 4.0]), [0.25, 0.5, 1.0, 1.0]);
    assert_eq!(of(&[0.0, 0.0, 3.0]), [0.0, 0.0, 1.0], "zero gradients do not count in the median");
    assert_eq!(weights(&[0.0, 0.0]), [0.5, 0.5]);
    assert!(weights(&[]).is_empty());
}
