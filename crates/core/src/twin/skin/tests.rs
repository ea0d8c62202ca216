use proptest::prelude::*;

use super::*;
use crate::NodeKind;

/// A skin of one point that three of four nodes carry, with an offset in a frame.
fn one_point() -> (Skin, [Vector; 4]) {
    let mut skin = Skin::default();
    skin.push(3, &[(0, 0.5), (1, 0.75), (3, -0.25)], [0, 1, 2], [0.02, -0.03, 0.05]);
    (skin, [[0.1, 0.0, 0.2], [0.9, 0.3, -0.1], [0.2, 0.8, 0.4], [-0.3, 0.1, 0.6]])
}

fn vector() -> impl Strategy<Value = Vector> {
    [-1.0..1.0_f64, -1.0..1.0, -1.0..1.0]
}

proptest! {
    /// The adjoint is the derivative, by central differences.
    #[test]
    fn the_gradient_is_the_derivative(bar in vector(), way in [vector(), vector(), vector(), vector()]) {
        let (skin, nodes) = one_point();
        let value = |step: f64| {
            let at = |i: u32| add(nodes[i as usize], scaled(way[i as usize], step));
            dot(bar, skin.position(0, at))
        };
        let step = 1e-5;
        let expected = (value(step) - value(-step)) / (2.0 * step);
        let mut found = 0.0;
        skin.add_gradient(0, |i| nodes[i as usize], bar, |i, b| found += dot(b, way[i as usize]));
        prop_assert!((found - expected).abs() < 1e-7, "{found} instead of {expected}");
    }

    /// The velocity is the derivative of the position by time, by central differences.
    #[test]
    fn the_velocity_is_the_derivative(way in [vector(), vector(), vector(), vector()]) {
        let (skin, nodes) = one_point();
        let place = |time: f64| {
            skin.position(0, |i| add(nodes[i as usize], scaled(way[i as usize], time)))
        };
        let step = 1e-5;
        let expected = scaled(sub(place(step), place(-step)), 0.5 / step);
        let found = skin.velocity(0, |i| nodes[i as usize], |i| way[i as usize]);
        prop_assert!(length(sub(found, expected)) < 1e-7, "{found:?} instead of {expected:?}");
    }

    /// A rigid motion of the nodes carries a point along, its offset included.
    #[test]
    fn rigid_motions_carry_points(axis in vector(), angle in -3.0..3.0_f64, shift in vector()) {
        prop_assume!(length(axis) > 0.1);
        let (skin, nodes) = one_point();
        let unit = nalgebra::Unit::new_normalize(nalgebra::Vector3::from(axis));
        let turn = nalgebra::Rotation3::from_axis_angle(&unit, angle);
        let moved = |p: Vector| -> Vector {
            add((turn * nalgebra::Vector3::from(p)).into(), shift)
        };
        let expected = moved(skin.position(0, |i| nodes[i as usize]));
        let found = skin.position(0, |i| moved(nodes[i as usize]));
        prop_assert!(length(sub(found, expected)) < 1e-9, "{found:?} instead of {expected:?}");
    }
}

#[test]
fn the_offset_of_a_frame_gives_the_point_back() {
    let (mut skin, nodes) = one_point();
    let p = [0.3, 0.2, 0.9];
    skin.offsets_m[0] = [0.0; 3];
    let rest = sub(p, skin.position(0, |i| nodes[i as usize]));
    let offset = offset_in_frame([nodes[0], nodes[1], nodes[2]], rest).expect("a triangle");
    skin.offsets_m[0] = offset.map(|x| x as f32);
    let found = skin.position(0, |i| nodes[i as usize]);
    assert!(length(sub(found, p)) < 1e-6, "{found:?}");
}

#[test]
fn a_triangle_that_collapsed_gives_finite_numbers() {
    let (skin, _) = one_point();
    let line = |i: u32| [f64::from(i), 0.0, 0.0];
    assert!(skin.position(0, line).iter().all(|x| x.is_finite()));
    assert_eq!(offset_in_frame([line(0), line(1), line(2)], [0.0, 0.0, 1.0]), None);
    // In single precision this is a line.
    assert_eq!(offset_in_frame([line(0), line(1), [2.0, 1e-4, 0.0]], [0.0, 0.0, 1.0]), None);
    assert!(offset_in_frame([line(0), line(1), [2.0, 1e-3, 0.0]], [0.0, 0.0, 1.0]).is_some());
    skin.add_gradient(0, line, [1.0; 3], |_, b| assert!(b.iter().all(|x| x.is_finite())));
}

#[test]
fn nodes_can_serve_as_the_skin() {
    let graph = Graph {
        rest_positions: vec![[0.0; 3], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0]],
        kinds: vec![NodeKind::Observed, NodeKind::Completed, NodeKind::Interior],
        observed_points: vec![7, Graph::NOT_OBSERVED, Graph::NOT_OBSERVED],
        ..Graph::default()
    };
    let skin = Skin::of_nodes(&graph);
    assert_eq!(skin.check(3), Ok(()));
    assert!(skin.is_nodes(&graph));
    assert_eq!(skin.positions(&graph.rest_positions), graph.rest_positions[..2]);
    assert!(!Skin::default().is_nodes(&graph));
    assert_eq!(Skin::default().check(3), Ok(()));
}

#[test]
fn chosen_points_stay_what_they_were() {
    let (mut skin, nodes) = one_point();
    skin.push(9, &[(2, 1.0)], [Skin::NO_FRAME; 3], [0.0, 0.0, 0.25]);
    let at = |i: u32| nodes[i as usize];
    let chosen = skin.select(&[1, 7, 0, 1]);
    assert_eq!(chosen.check(4), Ok(()));
    assert_eq!(chosen.observed_points, [9, 3, 9]);
    for (own, of) in [1, 0, 1].into_iter().enumerate() {
        assert_eq!(chosen.position(own, at), skin.position(of, at));
    }
    assert!(skin.select(&[]).is_empty());
    let at_nodes = Skin::at_nodes(&[3, 1]);
    assert_eq!(at_nodes.check(4), Ok(()));
    assert_eq!([0, 1].map(|p| at_nodes.position(p, at)), [nodes[3], nodes[1]]);
}

#[test]
fn carriers_are_nodes_of_weights_and_frame() {
    let (mut skin, _) = one_point();
    assert_eq!(skin.carriers(0).collect::<Vec<_>>(), [0, 1, 3, 0, 1, 2]);
    skin.frames[0] = [Skin::NO_FRAME; 3];
    assert_eq!(skin.carriers(0).collect::<Vec<_>>(), [0, 1, 3]);
}

#[test]
fn a_point_of_too_many_weights_is_refused() {
    let point = |count: usize| {
        let mut skin = Skin::default();
        skin.push(0, &vec![(0, 1.0 / count as f32); count], [Skin::NO_FRAME; 3], [0.0; 3]);
        skin.check(1)
    };
    assert_eq!(point(Skin::MOST_WEIGHTS), Ok(()));
    assert!(point(Skin::MOST_WEIGHTS + 1).unwrap_err().contains("65 weights"));
}

#[test]
fn contradictions_are_named() {
    type Fault = (&'static str, fn(&mut Skin));
    let faults: [Fault; 8] = [
        ("carried by node 9", |s| s.nodes[1] = 9),
        ("sum up to", |s| s.weights[0] = 2.0),
        ("sum up to", |s| s.weights[0] = f32::NAN),
        ("not finite", |s| s.offsets_m[0][1] = f32::INFINITY),
        ("do not divide", |s| s.starts[1] = 2),
        ("starts of weights", |s| s.starts.clear()),
        ("frames", |s| s.frames.clear()),
        ("the frame of", |s| s.frames[0] = [0, 1, Skin::NO_FRAME]),
    ];
    for (expected, spoil) in faults {
        let (mut skin, _) = one_point();
        spoil(&mut skin);
        let fault = skin.check(4).expect_err(expected);
        assert!(fault.contains(expected), "{fault}");
    }
}
