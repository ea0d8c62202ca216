use bendtwin_proto::v1::{Capsule, ConvexMesh, Cuboid, Sphere, Tensor};

use super::*;

/// A quarter turn about z, 1 m up.
fn turned() -> Vec<f32> {
    let half = std::f32::consts::FRAC_1_SQRT_2;
    vec![0.0, 0.0, 1.0, 0.0, 0.0, half, half]
}

fn collider(shape: Wire) -> Collider {
    Collider { shape: Some(shape), margin_m: 0.01, ..Collider::default() }
}

fn close(a: Point, b: Point) -> bool {
    a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-6)
}

#[test]
fn a_sphere_is_a_capsule_without_length_and_grows_by_its_margin() {
    let sphere = Sphere { center: vec![0.1, 0.0, 0.0], radius_m: 0.05 };
    let wire = Collider { pose: turned(), ..collider(Wire::Sphere(sphere)) };
    let Shape::Capsule { from, to, radius_m } = read(&wire, 0).unwrap() else { panic!() };
    assert!(close(from, [0.0, 0.1, 1.0]) && from == to, "{from:?}");
    assert!((radius_m - 0.06).abs() < 1e-7);
    let capsule = Capsule { from: vec![0.0; 3], to: vec![0.1, 0.0, 0.0], radius_m: 0.02 };
    let wire = Collider { pose: turned(), ..collider(Wire::Capsule(capsule)) };
    let Shape::Capsule { from, to, .. } = read(&wire, 0).unwrap() else { panic!() };
    assert!(close(from, [0.0, 0.0, 1.0]) && close(to, [0.0, 0.1, 1.0]));
}

#[test]
fn a_box_and_the_hull_of_its_corners_are_the_same() {
    let cuboid = Cuboid { low: vec![0.0; 3], high: vec![0.1, 0.2, 0.3] };
    let wire = Collider { pose: turned(), ..collider(Wire::Cuboid(cuboid)) };
    let Shape::Convex(sides) = read(&wire, 0).unwrap() else { panic!() };
    let corners = [0usize, 1, 2, 3, 4, 5, 6, 7].map(|i| {
        [0.1, 0.2, 0.3]
            .map(f32::from)
            .into_iter()
            .enumerate()
            .map(|(axis, x)| if i >> axis & 1 == 0 { 0.0 } else { x })
            .collect::<Vec<f32>>()
    });
    let points = Some(Tensor::pack(&[8, 3], corners.concat().as_slice()));
    let mesh = collider(Wire::ConvexMesh(ConvexMesh { points }));
    let Shape::Convex(faces) = read(&Collider { pose: turned(), ..mesh }, 0).unwrap() else {
        panic!()
    };
    assert_eq!((sides.len(), faces.len()), (6, 6));
    for side in sides.iter() {
        let same =
            |f: &&Face| close(f.normal, side.normal) && (f.offset_m - side.offset_m).abs() < 1e-5;
        assert!(faces.iter().any(|f| same(&f)), "{side:?} in {faces:?}");
    }
    // A point 5 cm outside the box's far end along y, which the turn put at -x.
    let p = [-0.25, 0.05, 1.1];
    let distance = sides.iter().map(|f| dot(f.normal, p) - f.offset_m).fold(f32::MIN, f32::max);
    assert!((distance - 0.04).abs() < 1e-5, "{distance}");
}

#[test]
fn a_flat_mesh_is_refused_by_its_field() {
    let points = Some(Tensor::pack(&[4, 3], &[0.0f32; 12]));
    let error = read(&collider(Wire::ConvexMesh(ConvexMesh { points })), 3).unwrap_err();
    let text = error.to_string();
    assert!(text.contains("world.colliders[3].convex_mesh.points") && text.contains("volume"));
}
