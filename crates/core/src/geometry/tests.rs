use nalgebra::{Matrix3, Rotation3, Vector3};
use proptest::prelude::*;

use super::*;
use crate::Point;

fn numbers() -> impl Strategy<Value = [f32; 3]> {
    prop::array::uniform3(-10.0_f32..10.0)
}

proptest! {
    #[test]
    fn distances_are_the_same_bits_as_those_of_columns(a in numbers(), b in numbers()) {
        let columns = (vector3(a) - vector3(b)).norm();
        prop_assert_eq!(point_distance(a, b).to_bits(), columns.to_bits());
    }

    #[test]
    fn a_cross_product_is_perpendicular(a in numbers(), b in numbers()) {
        let (a, b) = (wide(a), wide(b));
        let c = cross(a, b);
        prop_assert!(dot(a, c).abs() < 1e-9 * (1.0 + length(a) * length(c)));
        prop_assert_eq!(sub(add(a, b), b).map(|x| x as f32), a.map(|x| x as f32));
    }
}

#[test]
fn the_median_is_a_number_of_the_list() {
    assert_eq!(median::<f64>(&mut []), None);
    assert_eq!(median(&mut [3.0_f32, 1.0, 2.0]), Some(2.0));
    assert_eq!(median(&mut [4.0, 1.0, 2.0, 3.0]), Some(3.0));
    assert_eq!(median(&mut [f64::NAN, 1.0, 2.0]), Some(2.0));
}

#[test]
fn a_vector_without_direction_has_no_unit() {
    assert_eq!(unit([0.0; 3]), None);
    assert_eq!(unit([f64::INFINITY, 0.0, 0.0]), None);
    assert_eq!(unit([0.0, 2.0, 0.0]), Some([0.0, 1.0, 0.0]));
}

#[test]
fn turning_back_undoes_a_turn() {
    let matrix = Rotation3::new(Vector3::new(0.4, -0.2, 0.9));
    let rows = std::array::from_fn(|i| std::array::from_fn(|j| matrix[(i, j)]));
    let p = [0.3, -1.2, 2.0];
    assert!(distance(turn_back(&rows, turn(&rows, p)), p) < 1e-12);
}

/// A spiral of points, and a motion of it; of every third pair the end went astray.
fn astray(motion: &RigidMotion) -> Vec<Pair> {
    let at = |i: usize| {
        let angle = 0.9 * i as f32;
        [0.1 * angle.cos(), 0.1 * angle.sin(), 0.01 * i as f32]
    };
    (0..30)
        .map(|i| {
            let before: Point = at(i);
            let mut after = motion.apply(before);
            after[i % 2] += if i % 3 == 0 { 0.2 } else { 0.0 };
            Pair { before, after, weight: 1.0 }
        })
        .collect()
}

#[test]
fn a_motion_is_found_in_spite_of_outliers() {
    let rotation = *Rotation3::new(Vector3::new(0.1, 0.05, -0.2)).matrix();
    let motion = RigidMotion { rotation, translation: Vector3::new(0.02, -0.01, 0.03) };
    let pairs = astray(&motion);
    for about_origin in [false, true] {
        let rule = RobustRule {
            rounds: 8,
            least_width_m: 0.002,
            first_width: 2.0,
            least_agreeing: 4,
            fits_last: true,
            about_origin,
            kabsch: Kabsch::default(),
        };
        let fit = rule.fit(&pairs, rule.start(&pairs).unwrap()).unwrap();
        assert!((fit.motion.rotation - rotation).norm() < 1e-4, "{fit:?}");
        assert!(fit.residual_m < 1e-4, "{fit:?}");
        let back = fit.motion.motion().inverse();
        assert!(point_distance(back.apply(pairs[1].after), pairs[1].before) < 1e-4);
    }
}

#[test]
fn a_prior_decides_what_points_on_a_line_leave_open() {
    let pairs: Vec<Pair> = (0..5)
        .map(|i| {
            let p = [0.1 * i as f32, 0.0, 0.0];
            Pair { before: p, after: p, weight: 1.0 }
        })
        .collect();
    let about_x = *Rotation3::new(Vector3::new(0.7, 0.0, 0.0)).matrix();
    let prior = Some(Prior { rotation: about_x, deviation_m: 0.002 });
    let found = kabsch(&pairs, &[1.0; 5], &Kabsch { prior, ..Kabsch::default() }).unwrap();
    assert!((found.rotation - about_x).norm() < 1e-6, "{found:?}");
    assert_eq!(kabsch(&pairs, &[0.0; 5], &Kabsch::default()), None);
    let still = RigidMotion { rotation: Matrix3::identity(), translation: Vector3::zeros() };
    let half = still.between(&found.motion(), 0.5, [0.0; 3]);
    assert!((half.rotation - Rotation3::new(Vector3::new(0.35, 0.0, 0.0)).matrix()).norm() < 1e-6);
}
