use nalgebra::Rotation3;

use super::*;
use crate::testing::{point, sphere};

fn motion() -> Rigid {
    let rotation = Rotation3::from_euler_angles(0.4, -0.7, 1.9);
    Rigid { rotation: *rotation.matrix(), translation: Vector3::new(0.3, -0.1, 0.5) }
}

fn pairs(count: usize) -> Vec<(Point, Point)> {
    sphere(count).into_iter().map(|p| (point(p * 0.05), motion().apply(point(p * 0.05)))).collect()
}

#[test]
fn a_motion_is_found_again_and_turned_back() {
    let fitted = fit(&pairs(10), 1e-3).unwrap();
    assert!(fitted.residual_m < 1e-6);
    assert!((fitted.motion.rotation - motion().rotation).norm() < 1e-5);
    let p = [0.1, 0.2, -0.3];
    let back = fitted.motion.inverse().apply(fitted.motion.apply(p));
    assert!(distance(p, back) < 1e-6);
    assert!(fit(&pairs(2), 1e-3).is_none());
}

#[test]
fn outliers_do_not_pull() {
    let mut pairs = pairs(20);
    for (_, to) in pairs.iter_mut().step_by(4) {
        to[0] += 0.2;
    }
    let fitted = fit(&pairs, 1e-3).unwrap();
    assert!((fitted.motion.rotation - motion().rotation).norm() < 1e-4);
}

#[test]
fn a_mirrored_cloud_gives_a_rotation_all_the_same() {
    let mirrored: Vec<_> = pairs(10).into_iter().map(|(a, _)| (a, [-a[0], a[1], a[2]])).collect();
    let fitted = fit(&mirrored, 1e-3).unwrap();
    assert!((fitted.motion.rotation.determinant() - 1.0).abs() < 1e-9);
}

#[test]
fn between_two_poses_the_pivot_goes_straight() {
    let start = Rigid { rotation: Matrix3::identity(), translation: Vector3::zeros() };
    let pivot = [0.1, 0.0, 0.0];
    let middle = start.between(&motion(), 0.5, pivot).apply(pivot);
    let end = motion().apply(pivot);
    let straight = std::array::from_fn(|i| 0.5 * (pivot[i] + end[i]));
    assert!(distance(middle, straight) < 1e-6);
    let same = start.between(&motion(), 1.0, pivot);
    assert!((same.rotation - motion().rotation).norm() < 1e-9);
}
