use super::*;
use crate::scene;

fn sheet() -> Vec<Vector3<f64>> {
    let at = |i: usize| Vector3::new(0.02 * (i % 9) as f64, 0.02 * (i / 9) as f64, 0.0);
    (0..81).map(at).collect()
}

#[test]
fn the_distance_above_a_sheet_is_the_height() {
    let surface = Surface::new(&sheet(), 0.02).unwrap();
    for p in [[0.05, 0.05, 0.007], [0.033, 0.071, 0.007], [0.09, 0.09, -0.007]] {
        let foot = surface.foot(p);
        assert!((foot.distance_m - 0.007).abs() < 1e-6, "{foot:?}");
        assert!((foot.weights.iter().sum::<f64>() - 1.0).abs() < 1e-12);
    }
    // Beyond the edge the nearest point is on the edge.
    let foot = surface.foot([-0.03, 0.05, 0.0]);
    assert!((foot.distance_m - 0.03).abs() < 1e-6, "{foot:?}");
}

#[test]
fn nodes_far_apart_have_no_surface_between_them() {
    let nodes = [Vector3::zeros(), Vector3::new(1.0, 0.0, 0.0)];
    let foot = Surface::new(&nodes, 0.02).unwrap().foot([0.4, 0.0, 0.0]);
    assert!((foot.distance_m - 0.4).abs() < 1e-6, "{foot:?}");
    assert!(Surface::new(&[], 0.02).is_none());
    assert!(Surface::new(&[Vector3::new(f64::NAN, 0.0, 0.0)], 0.02).is_none());
}

#[test]
fn spacing_is_that_of_neighbours() {
    let model = scene::model();
    let found = spacing(&model.graph.rest_positions);
    assert!((0.019..0.025).contains(&found), "{found}");
    assert_eq!(spacing(&[]), 0.0);
    assert_eq!(spacing(&[[0.0; 3]]), 0.0);
}
