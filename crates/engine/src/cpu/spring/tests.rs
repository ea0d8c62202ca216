use super::*;
use crate::cpu::{jacobian::assert_adjoint, real::dot};

type Scene = (Vec<SpringBlock<f64>>, Vec<Node<f64>>, Vec<Quad<f64>>);

fn two_springs() -> Scene {
    let mut block = SpringBlock::EMPTY;
    (block.first[0], block.second[0]) = (0, 1);
    (block.first[1], block.second[1]) = (2, 1);
    (block.rate[0], block.rest[0], block.dashpot[0]) = (300.0, 0.8, 2.0);
    (block.rate[1], block.rest[1], block.dashpot[1]) = (50.0, 1.5, 7.0);
    let nodes = vec![
        Node { x: [0.1, 0.2, -0.3, 0.0], v: [1.0, -0.4, 0.3, 0.0] },
        Node { x: [0.9, -0.1, 0.4, 0.0], v: [-0.2, 0.5, 0.9, 0.0] },
        Node { x: [0.4, 0.8, 0.6, 0.0], v: [0.3, 0.1, -0.8, 0.0] },
    ];
    let lambda = vec![[0.3, -0.9, 0.5, 0.0], [1.1, 0.2, -0.7, 0.0], [-0.6, 0.4, 0.1, 0.0]];
    (vec![block], nodes, lambda)
}

fn forces(blocks: &[SpringBlock<f64>], nodes: &[Node<f64>]) -> Vec<Quad<f64>> {
    let mut forces = vec![[0.0; 4]; nodes.len()];
    spring_forces(blocks, nodes, &mut forces);
    forces
}

/// Relative 1e-6 to the largest entry: central differences in f64 with h = 1e-7.
#[test]
fn adjoint_is_the_derivative() {
    let (blocks, nodes, lambda) = two_springs();
    let mut adjoint = vec![Node::default(); nodes.len()];
    let mut gradients = vec![SpringGradient::ZERO];
    spring_adjoint(&blocks, &nodes, &lambda, &mut adjoint, &mut gradients);
    assert_adjoint(&nodes, &lambda, &adjoint, 1e-6, |n| forces(&blocks, n));
}

#[test]
fn parameter_gradients_are_derivatives() {
    let (blocks, nodes, lambda) = two_springs();
    let mut adjoint = vec![Node::default(); nodes.len()];
    let mut g = vec![SpringGradient::ZERO];
    spring_adjoint(&blocks, &nodes, &lambda, &mut adjoint, &mut g);
    for s in 0..2 {
        let work = |stiffness: f64, dashpot: f64, rest: f64| -> f64 {
            let mut blocks = blocks.clone();
            let b = &mut blocks[0];
            let k = b.rate[s] * b.rest[s] + stiffness;
            b.rest[s] += rest;
            b.rate[s] = k / b.rest[s];
            b.dashpot[s] += dashpot;
            forces(&blocks, &nodes).iter().zip(&lambda).map(|(f, l)| dot(*f, *l)).sum()
        };
        let h = 1e-5;
        let pairs = [
            (work(h, 0.0, 0.0) - work(-h, 0.0, 0.0), g[0].stiffness[s]),
            (work(0.0, h, 0.0) - work(0.0, -h, 0.0), g[0].dashpot[s]),
            (work(0.0, 0.0, h) - work(0.0, 0.0, -h), g[0].rest[s]),
        ];
        for (difference, gradient) in pairs {
            let difference = difference / (2.0 * h);
            assert!((difference - gradient).abs() < 1e-6 * gradient.abs().max(1.0));
        }
    }
}

#[test]
fn degenerate_springs_are_finite_and_still() {
    let (mut blocks, mut nodes, lambda) = two_springs();
    nodes[1] = nodes[0];
    blocks[0].rate[1] = 0.0;
    blocks[0].rest[1] = 0.0;
    let f = forces(&blocks, &nodes);
    assert!(f.iter().flatten().all(|x| x.is_finite()));
    assert_eq!(f[0], [0.0; 4]);
    let mut adjoint = vec![Node::default(); nodes.len()];
    let mut gradients = vec![SpringGradient::ZERO];
    spring_adjoint(&blocks, &nodes, &lambda, &mut adjoint, &mut gradients);
    assert!(adjoint.iter().flat_map(|n| n.x.into_iter().chain(n.v)).all(f64::is_finite));
    assert!(gradients[0].rest.iter().chain(&gradients[0].stiffness).all(|x| x.is_finite()));
}
