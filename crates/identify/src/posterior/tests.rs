use super::*;

/// A column of points; only the first moves, along x.
fn alone(rows: usize, by: f32) -> Vec<f32> {
    (0..rows).map(|r| if r == 0 { by } else { 0.0 }).collect()
}

#[test]
fn an_observation_leaves_what_bayes_rule_says() {
    let (by, weight) = (0.002_f32, 1e6);
    // Many points, so that a constant offset of all of them is not what moves the first.
    let column = alone(3000, by);
    let info = information(std::slice::from_ref(&column), &[], weight);
    let expected = weight * f64::from(by).powi(2);
    assert!((info[(0, 0)] / expected - 1.0).abs() < 0.01, "{info}");
    let left = covariance(&info)[(0, 0)];
    assert!((left - 1.0 / (1.0 + expected)).abs() < 0.01, "{left}");
    let query = Query::new(&[vec![0.0, 0.003, 0.0]]);
    let variance = query.variances(&covariance(&info));
    assert!((variance[0] / (left * 9e-6) - 1.0).abs() < 1e-4, "{variance:?}");
    assert!((query.rms_m(&covariance(&info)) - variance[0].sqrt()).abs() < 1e-9);
}

#[test]
fn what_an_offset_of_the_camera_explains_is_not_learnt() {
    let shift: Vec<f32> = (0..300).map(|r| if r % 3 == 2 { 0.001 } else { 0.0 }).collect();
    let info = information(&[shift], &[], 1e6)[(0, 0)];
    // Not 100 observations of a millimetre each, but one whose deviation is that of the offset.
    let expected = (0.001 / f64::from(CAMERA_OFFSET_M)).powi(2);
    assert!((info / expected - 1.0).abs() < 0.01, "{info}");
}

#[test]
fn a_nuisance_takes_what_it_explains() {
    let (column, other) = (alone(3000, 0.002), alone(3000, 1.0));
    let free = information(std::slice::from_ref(&column), &[], 1e6)[(0, 0)];
    let confused = information(std::slice::from_ref(&column), &[other], 1e6)[(0, 0)];
    assert!(free > 1.0 && confused < 1e-3, "{free} {confused}");
}

#[test]
fn shares_name_the_direction_behind_a_motion() {
    let query = Query::new(&[vec![0.003, 0.0, 0.0], vec![0.0, 0.001, 0.0]]);
    let shares = query.shares(&DMatrix::identity(2, 2));
    assert!((shares[0] - 0.9).abs() < 1e-6 && (shares[1] - 0.1).abs() < 1e-6, "{shares:?}");
}
