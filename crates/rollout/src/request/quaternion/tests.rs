use proptest::prelude::*;

use super::*;

fn close(a: Vector, b: Vector) -> bool {
    a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-4)
}

fn about(axis: usize, angle: f64) -> Quaternion {
    let mut q = [0.0; 4];
    q[axis] = (angle / 2.0).sin();
    q[3] = (angle / 2.0).cos();
    Quaternion::new(q).unwrap()
}

fn rotation() -> impl Strategy<Value = Quaternion> {
    prop::array::uniform4(-1.0f64..1.0).prop_filter_map("zero", Quaternion::new)
}

#[test]
fn a_quarter_turn_about_z_takes_x_to_y() {
    let q = about(2, std::f64::consts::FRAC_PI_2);
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
    assert!(Quaternion::new([f64::NAN, 0.0, 0.0, 1.0]).is_none());
    assert!(Quaternion::new([f64::INFINITY, 0.0, 0.0, 1.0]).is_none());
    assert!(Quaternion::new([0.0, 0.0, 0.0, f64::from(f32::MAX)]).is_some());
}

/// A function of rotations, and its gradient by finite differences along the unit sphere.
fn differences(q: Quaternion, f: impl Fn(Quaternion) -> f64) -> [f64; 4] {
    let moved = |i: usize, by: f64| {
        let mut xyzw = q.0;
        xyzw[i] += by;
        f(Quaternion::new(xyzw).unwrap())
    };
    std::array::from_fn(|i| (moved(i, 1e-5) - moved(i, -1e-5)) / 2e-5)
}

fn near(a: [f64; 4], b: [f64; 4]) -> bool {
    a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-6 * (1.0 + b.abs()))
}

proptest! {
    #[test]
    fn the_gradient_of_a_rotated_vector_agrees_with_differences(
        q in rotation(),
        v in prop::array::uniform3(-1.0f64..1.0),
        along in prop::array::uniform3(-1.0f64..1.0),
    ) {
        let expected = differences(q, |q| dot(q.rotate(v), along));
        prop_assert!(near(q.tangent(q.rotate_gradient(v, along)), expected));
    }

    #[test]
    fn the_gradient_of_slerp_agrees_with_differences(
        (a, b) in (rotation(), rotation()),
        share in 0.05f64..0.95,
        v in prop::array::uniform3(-1.0f64..1.0),
        along in prop::array::uniform3(-1.0f64..1.0),
    ) {
        // At the half turn the shorter arc jumps to the other side.
        prop_assume!(dot(a.0, b.0).abs() > 0.05);
        let value = |a: Quaternion, b: Quaternion| dot(a.slerp(b, share).rotate(v), along);
        let at = a.slerp(b, share).rotate_gradient(v, along);
        let [by_a, by_b] = a.slerp_gradient(b, share, at);
        prop_assert!(near(a.tangent(by_a), differences(a, |a| value(a, b))));
        prop_assert!(near(b.tangent(by_b), differences(b, |b| value(a, b))));
        // Equal ends: the chord.
        let at = a.rotate_gradient(v, along);
        let [first, _] = a.slerp_gradient(a, share, at);
        let expected = a.tangent(at).map(|g| (1.0 - share) * g);
        prop_assert!(near(a.tangent(first), expected));
    }

    #[test]
    fn rotation_keeps_lengths(q in rotation(), v in prop::array::uniform3(-5.0f64..5.0)) {
        let length = |v: Vector| v.iter().map(|c| c * c).sum::<f64>().sqrt();
        prop_assert!((length(q.rotate(v)) - length(v)).abs() < 1e-3);
    }

    #[test]
    fn the_inverse_undoes(q in rotation(), v in prop::array::uniform3(-1.0f64..1.0)) {
        prop_assert!(close(q.inverse().rotate(q.rotate(v)), v));
    }

    #[test]
    fn slerp_reaches_its_ends(a in rotation(), b in rotation(), v in prop::array::uniform3(-1.0f64..1.0)) {
        prop_assert!(close(a.slerp(b, 0.0).rotate(v), a.rotate(v)));
        prop_assert!(close(a.slerp(b, 1.0).rotate(v), b.rotate(v)));
    }
}
