use nalgebra::{Rotation3, Vector3};

use super::{Body, Surfel, parts};

/// The faces of a box with sides of 6, 8 and 10 cm, every 4 mm.
fn crate_faces() -> Vec<Surfel> {
    let half = Vector3::new(0.03, 0.04, 0.05);
    let mut surfels = Vec::new();
    for axis in 0..3 {
        let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
        for side in [-1.0, 1.0] {
            let mut normal = Vector3::zeros();
            normal[axis] = side;
            let steps = |i: usize| (half[i] / 0.002) as i32;
            for i in (-steps(u)..=steps(u)).step_by(2) {
                for j in (-steps(v)..=steps(v)).step_by(2) {
                    let mut at = Vector3::zeros();
                    at[axis] = side * half[axis];
                    at[u] = 0.002 * f64::from(i);
                    at[v] = 0.002 * f64::from(j);
                    surfels.push(Surfel { at, normal });
                }
            }
        }
    }
    surfels
}

fn ball() -> Vec<Surfel> {
    (0..600)
        .map(|i| {
            let z = 1.0 - (2.0 * f64::from(i) + 1.0) / 600.0;
            let angle = 2.399_963 * f64::from(i);
            let r = (1.0 - z * z).sqrt();
            let normal = Vector3::new(r * angle.cos(), r * angle.sin(), z);
            Surfel { at: normal * 0.04, normal }
        })
        .collect()
}

#[test]
fn a_box_is_followed_through_a_turn_and_a_shift() {
    let faces = crate_faces();
    let mut body = Body::new(faces.clone()).unwrap();
    for frame in 1..=10 {
        let t = f64::from(frame);
        let turn = Rotation3::new(Vector3::new(0.02, 0.05, -0.03) * t);
        let shift = Vector3::new(0.01, -0.004, 0.006) * t;
        // Half of it is seen.
        let seen: Vec<_> =
            faces.iter().filter(|s| s.normal.sum() > 0.0).map(|s| turn * s.at + shift).collect();
        assert!(body.register(&seen));
        let corner = Vector3::new(0.03, 0.04, 0.05);
        let miss = (body.to_world(corner) - (turn * corner + shift)).norm();
        assert!(miss < 1e-3, "frame {frame}: {miss}");
        assert!((body.to_model(body.to_world(corner)) - corner).norm() < 1e-12);
    }
}

#[test]
fn a_ball_is_taken_not_to_turn() {
    let surfels = ball();
    let mut body = Body::new(surfels.clone()).unwrap();
    let shift = Vector3::new(0.012, 0.0, -0.005);
    let seen: Vec<_> = surfels.iter().filter(|s| s.normal.z > 0.0).map(|s| s.at + shift).collect();
    assert!(body.register(&seen));
    let pole = Vector3::new(0.0, 0.0, 0.04);
    assert!((body.to_world(pole) - pole - shift).norm() < 5e-4);
}

#[test]
fn what_is_not_seen_does_not_move() {
    let mut body = Body::new(ball()).unwrap();
    assert!(!body.register(&[]));
    let far = vec![Vector3::new(1.0, 1.0, 1.0); 100];
    assert!(!body.register(&far));
    assert_eq!(body.to_world(Vector3::zeros()), Vector3::zeros());
    assert!(Body::new(ball()[..5].to_vec()).is_none());
}

#[test]
fn two_hands_are_two_parts_and_specks_are_ignored() {
    let mut both = ball();
    let other = |s: Surfel| Surfel { at: s.at + Vector3::new(0.3, 0.0, 0.0), ..s };
    both.extend(ball().into_iter().take(400).map(other));
    both.push(Surfel { at: Vector3::new(0.0, 1.0, 0.0), normal: Vector3::z() });
    let parts = parts(&both, 0.03);
    assert_eq!(parts.iter().map(Vec::len).collect::<Vec<_>>(), [600, 400]);
}
