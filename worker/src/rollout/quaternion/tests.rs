use proptest::prelude::*;

use super::*;

fn close(a: Point, b: Point) -> bool {
    a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-4)
}

fn about(axis: usize, angle: f32) -> Quaternion {
    let mut q = [0.0; 4];
    q[axis] = (angle / 2.0).sin();
    q[3] = (angle / 2.0).cos();
    Quaternion::new(q).unwrap()
}

fn rotation() -> impl Strategy<Value = Quaternion> {
    prop::array::uniform4(-1.0f32..1.0).prop_filter_map("zero", Quaternion::new)
}

#[test]
fn a_quarter_turn_about_z_takes_x_to_y() {
    let q = about(2, std::f32::consts::FRAC_PI_2);
    assert!(close(q.rotate([1.0, 0.0, 0.0]), [0.0, 1.0, 0.0]));
}

#[test]
fn halfway_is_half_the_angle() {
    let (a, b) = (about(0, 0.2), about(0, 1.8));
    assert!(close(a.slerp(b, 0.5).rotate([0.0, 1.0, 0.0]), about(0, 1.0).rotate([0.0, 1.0, 0.0])));
}

#[test]
fn zero_and_infinite_quaternions_are_refused() {
    assert!(Quaternion::new([0.0; 4]).is_none());
    assert!(Quaternion::new([f32::NAN, 0.0, 0.0, 1.0]).is_none());
    assert!(Quaternion::new([f32::INFINITY, 0.0, 0.0, 1.0]).is_none());
    assert!(Quaternion::new([0.0, 0.0, 0.0, f32::MAX]).is_some());
}

proptest! {
    #[test]
    fn rotation_keeps_lengths(q in rotation(), v in prop::array::uniform3(-5.0f32..5.0)) {
        let length = |v: Point| v.iter().map(|c| c * c).sum::<f32>().sqrt();
        prop_assert!((length(q.rotate(v)) - length(v)).abs() < 1e-3);
    }

    #[test]
    fn the_inverse_undoes(q in rotation(), v in prop::array::uniform3(-1.0f32..1.0)) {
        prop_assert!(close(q.inverse().rotate(q.rotate(v)), v));
    }

    #[test]
    fn slerp_reaches_its_ends(a in rotation(), b in rotation(), v in prop::array::uniform3(-1.0f32..1.0)) {
        prop_assert!(close(a.slerp(b, 0.0).rotate(v), a.rotate(v)));
        prop_assert!(close(a.slerp(b, 1.0).rotate(v), b.rotate(v)));
    }
}
