use super::*;
use crate::cpu::{
    arithmetic::{Portable, dot},
    elements::{jacobian::assert_adjoint, strips::OwnedElement},
};

type Scene = (Springs<f64>, Vec<Node<f64>>, Vec<Quad<f64>>);

const ENDS: [[u32; 2]; 2] = [[0, 1], [2, 1]];

/// Springs (k, l0, gamma) between the three nodes.
fn springs(parameters: [[f64; 3]; 2]) -> Springs<f64> {
    let owned = |element: u32| {
        let [owner, other] = ENDS[element as usize];
        OwnedElement { owner, others: [other], element }
    };
    Springs::new(&Strips::new(vec![owned(0), owned(1)], 3), |s| {
        let [stiffness, rest, dashpot] = parameters[s];
        Spring { ends: ENDS[s], stiffness, rest, dashpot }
    })
}

const PARAMETERS: [[f64; 3]; 2] = [[240.0, 0.8, 2.0], [75.0, 1.5, 7.0]];

fn two_springs() -> Scene {
    let nodes = vec![
        Node { x: [0.1, 0.2, -0.3, 0.0], v: [1.0, -0.4, 0.3, 0.0] },
        Node { x: [0.9, -0.1, 0.4, 0.0], v: [-0.2, 0.5, 0.9, 0.0] },
        Node { x: [0.4, 0.8, 0.6, 0.0], v: [0.3, 0.1, -0.8, 0.0] },
    ];
    let lambda = vec![[0.3, -0.9, 0.5, 0.0], [1.1, 0.2, -0.7, 0.0], [-0.6, 0.4, 0.1, 0.0]];
    (springs(PARAMETERS), nodes, lambda)
}

fn forces(springs: &Springs<f64>, nodes: &[Node<f64>]) -> Vec<Quad<f64>> {
    let mut forces = vec![[0.0; 4]; nodes.len()];
    spring_forces(Portable, springs, nodes, &mut forces);
    forces
}

/// Relative 1e-6 to the largest entry: central differences in f64 with h = 1e-7.
#[test]
fn adjoint_is_the_derivative() {
    let (springs, nodes, lambda) = two_springs();
    let mut adjoint = vec![Node::default(); nodes.len()];
    let mut gradients = vec![SpringGradient::ZERO];
    spring_adjoint(Portable, &springs, &nodes, &lambda, &mut adjoint, &mut gradients);
    assert_adjoint(&nodes, &lambda, &adjoint, 1e-6, |n| forces(&springs, n));
}

#[test]
fn parameter_gradients_are_derivatives() {
    let (all, nodes, lambda) = two_springs();
    let mut adjoint = vec![Node::default(); nodes.len()];
    let mut g = vec![SpringGradient::ZERO];
    spring_adjoint(Portable, &all, &nodes, &lambda, &mut adjoint, &mut g);
    for s in 0..2 {
        let work = |stiffness: f64, dashpot: f64, rest: f64| -> f64 {
            let mut moved = PARAMETERS;
            moved[s] = [moved[s][0] + stiffness, moved[s][1] + rest, moved[s][2] + dashpot];
            let f = forces(&springs(moved), &nodes);
            f.iter().zip(&lambda).map(|(f, l)| dot(*f, *l)).sum()
        };
        let [by_stiffness, by_dashpot, by_rest] = g[0].of(&all.blocks[0], s);
        let h = 1e-5;
        let pairs = [
            (work(h, 0.0, 0.0) - work(-h, 0.0, 0.0), by_stiffness),
            (work(0.0, h, 0.0) - work(0.0, -h, 0.0), by_dashpot),
            (work(0.0, 0.0, h) - work(0.0, 0.0, -h), by_rest),
        ];
        for (difference, gradient) in pairs {
            let difference = difference / (2.0 * h);
            assert!((difference - gradient).abs() < 1e-6 * gradient.abs().max(1.0));
        }
    }
}

#[test]
fn degenerate_springs_are_finite_and_still() {
    let (_, mut nodes, lambda) = two_springs();
    nodes[1] = nodes[0];
    let springs = springs([PARAMETERS[0], [75.0, 0.0, 7.0]]);
    let f = forces(&springs, &nodes);
    assert!(f.iter().flatten().all(|x| x.is_finite()));
    assert_eq!(f[0], [0.0; 4]);
    let mut adjoint = vec![Node::default(); nodes.len()];
    let mut gradients = vec![SpringGradient::ZERO];
    spring_adjoint(Portable, &springs, &nodes, &lambda, &mut adjoint, &mut gradients);
    assert!(adjoint.iter().flat_map(|n| n.x.into_iter().chain(n.v)).all(f64::is_finite));
    let by_parameter = [0, 1].map(|l| gradients[0].of(&springs.blocks[0], l));
    assert!(by_parameter.iter().flatten().all(|x| x.is_finite()));
}
