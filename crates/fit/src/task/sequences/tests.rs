use super::*;

use SequenceMean::{Arithmetic, Geometric};

#[test]
fn a_lost_sequence_does_not_drown_the_others() {
    assert_eq!(mean(Arithmetic, [1.0, 1.0, 100.0]), 34.0);
    assert_eq!(gradient_scales(Arithmetic, &[1.0, 1.0, 100.0]), [1.0; 3]);
    let all = mean(Geometric, [1.0, 1.0, 100.0]);
    assert!((4.6..4.7).contains(&all), "{all}");
    let [one, _, lost] = gradient_scales(Geometric, &[1.0, 1.0, 100.0])[..] else {
        panic!("three")
    };
    assert!(one > 4.6 && (0.1..0.11).contains(&lost), "{one} {lost}");
}

#[test]
fn scales_are_the_gradient_of_the_mean() {
    let losses = [0.5, 2.0, 3.0];
    for kind in [Arithmetic, Geometric] {
        for i in 0..3 {
            let mut more = losses;
            more[i] += 1e-6;
            let slope = (mean(kind, more) - mean(kind, losses)) / 1e-6;
            assert!((slope - gradient_scales(kind, &losses)[i] / 3.0).abs() < 1e-5);
        }
    }
}

#[test]
fn what_is_not_finite_stays_so() {
    for kind in [Arithmetic, Geometric] {
        assert!(mean(kind, [1.0, f64::NAN]).is_nan());
        assert_eq!(mean(kind, [1.0, f64::INFINITY]), f64::INFINITY);
    }
    assert!(mean(Geometric, [0.0, 0.0]) > 0.0);
}
