use bendtwin_core::{Point, geometry::point_distance};
use nalgebra::{Rotation3, Vector3};

use super::*;
use crate::scene;

#[test]
fn a_point_turns_with_the_nodes_around_it() {
    let nodes = scene::model().graph.rest_positions.clone();
    let points = [[0.013, 0.017, -0.01], [0.2, 0.01, 0.03], nodes[5]];
    let skin = Skin::bind(&nodes, &points).unwrap();
    let turn = Rotation3::new(Vector3::new(0.5, -2.0, 1.0));
    let image = |p: &Point| point(turn * vector3(*p) + Vector3::new(1.0, 2.0, 3.0));
    let moved: Vec<Point> = nodes.iter().map(image).collect();
    for (found, p) in skin.positions(&moved).unwrap().iter().zip(&points) {
        assert!(point_distance(*found, image(p)) < 2e-5, "{found:?} {:?}", image(p));
    }
    assert_eq!(skin.select(&[2, 9]).positions(&moved).unwrap(), [moved[5]]);
}

#[test]
fn points_of_a_straight_chain_stay_beside_it() {
    let nodes: Vec<Point> = (0..6).map(|i| [0.1 * i as f32, 0.0, 0.0]).collect();
    let skin = Skin::bind(&nodes, &[[0.25, 0.02, 0.0]]).unwrap();
    let still = skin.positions(&nodes).unwrap()[0];
    assert!(point_distance(still, [0.25, 0.02, 0.0]) < 1e-6, "{still:?}");
    let upright: Vec<Point> = nodes.iter().map(|p| [0.0, p[1], p[0]]).collect();
    let found = skin.positions(&upright).unwrap()[0];
    assert!((f64::from(found[2]) - 0.25).abs() < 1e-3, "{found:?}");
}

#[test]
fn nodes_that_do_not_exist_are_refused() {
    let skin = Skin::nodes(&[0, 7]);
    assert!(skin.positions(&[[0.0; 3]; 8]).is_ok());
    let error = skin.positions(&[[0.0; 3]; 7]).unwrap_err();
    assert!(error.to_string().contains("track 1"), "{error}");
    assert_eq!(Skin::bind(&[], &[[0.0; 3]]), None);
    assert_eq!(Skin::bind(&[[f32::NAN; 3]], &[[0.0; 3]]), None);
    // All nodes in one place have a point beside them all the same.
    let one = Skin::bind(&[[1.0; 3]; 40], &[[1.0, 1.0, 1.5]]).unwrap();
    let found = one.positions(&[[2.0; 3]; 40]).unwrap()[0];
    assert!(point_distance(found, [2.0, 2.0, 2.5]) < 1e-5, "{found:?}");
}
