use bendtwin_core::{
    Point,
    geometry::{point, point_distance, vector3},
};
use nalgebra::{Rotation3, Vector3};

use super::*;
use crate::scene;

/// A graph of nodes in a row, each joined with the next.
fn row(count: u32) -> Graph {
    Graph {
        rest_positions: (0..count).map(|i| [0.1 * i as f32, 0.0, 0.0]).collect(),
        springs: (1..count).map(|i| [i - 1, i]).collect(),
        ..Graph::default()
    }
}

#[test]
fn a_point_turns_with_the_nodes_around_it() {
    let model = scene::model();
    let nodes = &model.graph.rest_positions;
    let points = [[0.013, 0.017, -0.01], [0.2, 0.01, 0.03], nodes[5]];
    let tracks = bind_tracks(&model.graph, nodes, &points).unwrap();
    let turn = Rotation3::new(Vector3::new(0.5, -2.0, 1.0));
    let image = |p: &Point| point(turn * vector3(*p) + Vector3::new(1.0, 2.0, 3.0));
    let moved: Vec<Point> = nodes.iter().map(image).collect();
    for (found, p) in tracks.positions(&moved).iter().zip(&points) {
        assert!(point_distance(*found, image(p)) < 2e-5, "{found:?} {:?}", image(p));
    }
}

#[test]
fn points_are_bound_in_the_state_that_is_given() {
    let model = scene::model();
    let bent = |p: &Point| [p[0], p[1], p[2] + 2.0 * p[0] * p[0]];
    let nodes: Vec<Point> = model.graph.rest_positions.iter().map(bent).collect();
    let points = [bent(&[0.13, 0.01, 0.02]), bent(&[0.24, 0.015, 0.0])];
    let tracks = bind_tracks(&model.graph, &nodes, &points).unwrap();
    for (found, p) in tracks.positions(&nodes).iter().zip(&points) {
        assert!(point_distance(*found, *p) < 2e-6, "{found:?} {p:?}");
    }
}

#[test]
fn points_of_a_straight_chain_stay_beside_it() {
    let graph = row(6);
    let nodes = &graph.rest_positions;
    let tracks = bind_tracks(&graph, nodes, &[[0.25, 0.02, 0.0]]).unwrap();
    let still = tracks.positions(nodes)[0];
    assert!(point_distance(still, [0.25, 0.02, 0.0]) < 1e-6, "{still:?}");
    let upright: Vec<Point> = nodes.iter().map(|p| [0.0, p[1], p[0]]).collect();
    let found = tracks.positions(&upright)[0];
    assert!((f64::from(found[2]) - 0.25).abs() < 1e-3, "{found:?}");
}

#[test]
fn what_cannot_be_bound_is_refused() {
    let graph = row(1);
    assert_eq!(bind_tracks(&Graph::default(), &[], &[[0.0; 3]]), None);
    assert_eq!(bind_tracks(&graph, &[], &[[0.0; 3]]), None);
    assert_eq!(bind_tracks(&graph, &[[0.0; 3]; 2], &[[0.0; 3]]), None);
    assert_eq!(bind_tracks(&graph, &[[f32::NAN; 3]], &[[0.0; 3]]), None);
    assert_eq!(bind_tracks(&graph, &[[0.0; 3]], &[[f32::INFINITY, 0.0, 0.0]]), None);
    // All nodes in one place have a point beside them all the same.
    let one = bind_tracks(&row(40), &[[1.0; 3]; 40], &[[1.0, 1.0, 1.5]]).unwrap();
    let found = one.positions(&[[2.0; 3]; 40])[0];
    assert!(point_distance(found, [2.0, 2.0, 2.5]) < 1e-5, "{found:?}");
}
