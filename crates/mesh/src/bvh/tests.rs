use proptest::prelude::*;

use super::*;
use crate::shapes::{creature, sphere};

proptest! {
    #[test]
    fn finds_what_a_search_of_all_triangles_finds(p in prop::array::uniform3(-0.3_f32..0.3)) {
        let mesh = creature();
        let by_tree = Bvh::new(&mesh).nearest(vec3(p)).unwrap().1;
        let by_hand = mesh
            .corners()
            .map(|t| (nearest_on_triangle(vec3(p), &t) - vec3(p)).norm_squared())
            .fold(f64::INFINITY, f64::min);
        prop_assert_eq!(by_tree, by_hand);
    }
}

#[test]
fn normals_of_a_sphere_point_outwards() {
    let bvh = Bvh::new(&sphere(4));
    for p in [[2.0, 0.1, 0.3], [-0.2, 0.5, -1.9]] {
        let closest = bvh.closest(p).unwrap();
        let r = vec3(p).norm();
        assert!((closest.distance - (r - 1.0)).abs() < 0.01);
        assert!(Vec3::from(closest.normal).dot(&vec3(p)) / r > 0.99);
    }
}

#[test]
fn an_empty_mesh_is_nowhere() {
    assert_eq!(Bvh::new(&Mesh::default()).closest([0.0; 3]), None);
}
