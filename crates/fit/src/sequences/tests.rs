use super::*;

#[test]
fn one_sequence_is_its_own_mean_and_pulls_as_it_is() {
    assert!((mean([3.0]) - 3.0).abs() < 1e-12);
    assert_eq!(pulls(&[3.0]), [1.0]);
}

#[test]
fn a_lost_sequence_does_not_drown_the_others() {
    let all = mean([1.0, 1.0, 100.0]);
    assert!((4.6..4.7).contains(&all), "{all}");
    let [one, _, lost] = pulls(&[1.0, 1.0, 100.0])[..] else { panic!("three") };
    assert!(one > 4.6 && (0.1..0.11).contains(&lost), "{one} {lost}");
}

#[test]
fn pulls_are_the_gradient_of_the_mean() {
    let losses = [0.5, 2.0, 3.0];
    for i in 0..3 {
        let mut more = losses;
        more[i] += 1e-6;
        let slope = (mean(more) - mean(losses)) / 1e-6;
        assert!((slope - pulls(&losses)[i] / 3.0).abs() < 1e-5);
    }
}

#[test]
fn what_is_not_finite_stays_so() {
    assert!(mean([1.0, f64::NAN]).is_nan() && mean([]).is_nan());
    assert_eq!(mean([1.0, f64::INFINITY]), f64::INFINITY);
    assert!(mean([0.0, 0.0]) > 0.0);
}
