use bendtwin_core::{Skin, geometry::vector3};
use nalgebra::Rotation3;

use super::*;
use crate::scene;

fn on_nodes(nodes: &[u32], target: impl Fn(usize) -> Vector3<f64>) -> (Skin, Vec<Match>) {
    let at = |(p, n): (usize, &u32)| Match {
        points: [p as u32, 0, 0],
        weights: [1.0, 0.0, 0.0],
        target: target(*n as usize),
        precision: 1e6,
    };
    (Skin::at_nodes(nodes), nodes.iter().enumerate().map(at).collect())
}

fn endpoints(graph: &Graph) -> Vec<Vector3<f64>> {
    graph.rest_positions.iter().chain(&graph.control_rest).map(|p| vector3(*p)).collect()
}

#[test]
fn a_few_points_turn_the_whole_object() {
    let model = scene::model();
    let graph = &model.graph;
    let rest = endpoints(graph);
    let turn = Rotation3::new(Vector3::new(0.05, 0.1, 0.2));
    let image: Vec<_> = rest.iter().map(|p| turn * p + Vector3::new(0.05, 0.0, 0.1)).collect();
    let elastic = Elastic::new(graph, rest.clone(), vec![false; rest.len()], &[]);
    let (skin, list) = on_nodes(&[0, 15, 31, 50, 70, 80], |n| image[n]);
    let mut x = rest.clone();
    elastic.relax(&mut x, &Matches { skin: &skin, list }, 0.03, 60, None);
    let worst = x.iter().zip(&image).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max);
    let most = rest.iter().zip(&image).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max);
    assert!(worst < 0.06 * most, "{worst} {most}");
}

#[test]
fn what_is_fixed_stays_and_what_nothing_pulls_stays_too() {
    let model = scene::model();
    let graph = &model.graph;
    let rest = endpoints(graph);
    let n = graph.node_count();
    let fixed: Vec<bool> = (0..rest.len()).map(|e| e >= n || e == 3).collect();
    let elastic = Elastic::new(graph, rest.clone(), fixed, &[]);
    let mut x = rest.clone();
    let none = Skin::default();
    elastic.relax(&mut x, &Matches { skin: &none, list: Vec::new() }, 0.03, 5, None);
    assert!(x.iter().zip(&rest).all(|(a, b)| (a - b).norm() < 1e-9));
    let up = Vector3::new(0.0, 0.0, 0.03);
    let (skin, list) = on_nodes(&[n as u32 - 1], |n| rest[n] + up);
    elastic.relax(&mut x, &Matches { skin: &skin, list }, 0.03, 20, None);
    assert!((x[n - 1] - rest[n - 1]).z > 0.01);
    assert_eq!([x[3], x[n], x[n + 1]], [rest[3], rest[n], rest[n + 1]]);
}

#[test]
fn a_covariance_without_direction_is_no_rotation() {
    assert_eq!(nearest_rotation(Matrix3::zeros()), Matrix3::identity());
    assert_eq!(nearest_rotation(Matrix3::from_element(f64::NAN)), Matrix3::identity());
    let turn = *Rotation3::new(Vector3::new(0.0, 0.0, 3.1)).matrix();
    assert!((nearest_rotation(turn * 1e-9) - turn).norm() < 1e-5);
}
