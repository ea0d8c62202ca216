use super::*;
use crate::shapes::{cuboid, merged, sphere};

const INSIDE: [Point; 3] = [[0.0, 0.0, 0.0], [0.5, 0.5, 0.3], [-0.9, 0.1, 0.1]];
const OUTSIDE: [Point; 3] = [[1.1, 0.0, 0.0], [0.8, 0.8, 0.3], [-5.0, 9.0, 0.1]];

fn is_a_ball(solid: &Solid) {
    assert!(INSIDE.iter().all(|p| solid.contains(*p)));
    assert!(OUTSIDE.iter().all(|p| !solid.contains(*p)));
}

#[test]
fn a_closed_surface_counts_one_inside_and_nothing_outside() {
    let solid = Solid::new(&sphere(4));
    for p in INSIDE {
        assert!((solid.winding_number(p) - 1.0).abs() < 0.02, "{}", solid.winding_number(p));
    }
    for p in OUTSIDE {
        assert!(solid.winding_number(p).abs() < 0.02, "{}", solid.winding_number(p));
    }
}

#[test]
fn a_hole_changes_little() {
    let mut mesh = sphere(4);
    mesh.triangles.truncate(mesh.triangles.len() * 9 / 10);
    is_a_ball(&Solid::new(&mesh));
}

#[test]
fn triangles_that_face_any_way_are_turned() {
    let mut mesh = sphere(3);
    for (i, t) in mesh.triangles.iter_mut().enumerate() {
        if i % 3 == 0 {
            t.swap(0, 1);
        }
    }
    is_a_ball(&Solid::new(&mesh));
    mesh.triangles.iter_mut().for_each(|t| t.swap(0, 1));
    is_a_ball(&Solid::new(&mesh));
}

#[test]
fn corners_split_at_seams_are_welded() {
    let shared = sphere(3);
    let mesh = Mesh {
        vertices: shared.triangles.iter().flatten().map(|i| shared.vertices[*i as usize]).collect(),
        triangles: (0..shared.triangles.len() as u32)
            .map(|t| {
                if t % 2 == 0 {
                    [3 * t, 3 * t + 1, 3 * t + 2]
                } else {
                    [3 * t, 3 * t + 2, 3 * t + 1]
                }
            })
            .collect(),
    };
    is_a_ball(&Solid::new(&mesh));
}

#[test]
fn parts_that_overlap_are_full() {
    let mesh =
        merged(&[cuboid([0.0; 3], [1.0, 1.0, 1.0]), cuboid([0.5, 0.2, 0.2], [2.0, 0.8, 0.8])]);
    let solid = Solid::new(&mesh);
    assert!(solid.contains([0.7, 0.5, 0.5]) && solid.contains([1.5, 0.5, 0.5]));
    assert!(!solid.contains([1.5, 0.1, 0.5]));
}
