use super::*;

#[test]
fn no_gradient_counts_with_more_than_the_median_length() {
    let of = |lengths: &[f64]| -> Vec<f64> {
        lengths.iter().zip(weights(lengths)).map(|(l, w)| l * w).collect()
    };
    assert_eq!(of(&[1.0, 2.0, 1e6, 4.0]), [0.25, 0.5, 1.0, 1.0]);
    assert_eq!(of(&[0.0, 0.0, 3.0]), [0.0, 0.0, 1.0], "the silent ones do not silence it");
    assert_eq!(weights(&[0.0, 0.0]), [0.5, 0.5]);
    assert!(weights(&[]).is_empty());
}

#[test]
fn gradients_reach_less_and_less_until_a_frame_is_left() {
    let ladder = |from: u32| -> Vec<u32> {
        std::iter::successors(Some(from), |&reach| shorter(reach)).skip(1).collect()
    };
    assert_eq!(ladder(0), [16, 4, 1]);
    assert_eq!(ladder(1_000_000), [16, 4, 1]);
    assert_eq!(ladder(16), [4, 1]);
    assert_eq!(ladder(7), [1]);
    assert_eq!(ladder(2), [1]);
    assert!(ladder(1).is_empty());
}
