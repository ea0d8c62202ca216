use std::f64::consts::PI;

use super::*;
use crate::cpu::{
    arithmetic::dot,
    elements::{jacobian::assert_adjoint, strips::OwnedElement},
};

fn block(stiffness: f64, damping: f64, rest_angle: f64) -> Triplets<f64> {
    let owned = OwnedElement { owner: 1, others: [0, 2], element: 0 };
    let triplet = Triplet { ends: [0, 1, 2], stiffness, damping, rest_angle };
    Triplets::new(&Strips::new(vec![owned], 3), |_| triplet)
}

/// Arms of different lengths that enclose `theta`, in a tilted plane, moving.
fn nodes_at(theta: f64) -> Vec<Node<f64>> {
    let (e1, e2) = ([0.6, 0.8, 0.0], [-0.48, 0.36, 0.8]);
    let centre = [0.3, -0.2, 0.5];
    let arm =
        |length: f64, angle: f64| {
            let (s, c) = angle.sin_cos();
            std::array::from_fn(|d| {
                if d == 3 { 0.0 } else { centre[d] + length * (c * e1[d] + s * e2[d]) }
            })
        };
    vec![
        Node { x: arm(0.7, 0.0), v: [0.3, -0.5, 0.2, 0.0] },
        Node { x: arm(0.0, 0.0), v: [-0.1, 0.4, 0.6, 0.0] },
        Node { x: arm(0.4, theta), v: [0.8, 0.1, -0.7, 0.0] },
    ]
}

fn lambda() -> Vec<Quad<f64>> {
    vec![[0.3, -0.9, 0.5, 0.0], [1.1, 0.2, -0.7, 0.0], [-0.6, 0.4, 0.1, 0.0]]
}

fn forces(triplets: &Triplets<f64>, nodes: &[Node<f64>]) -> Vec<Quad<f64>> {
    let mut forces = vec![[0.0; 4]; nodes.len()];
    bend_forces(Portable, triplets, nodes, &mut forces);
    forces
}

fn energy(triplets: &Triplets<f64>, nodes: &[Node<f64>]) -> f64 {
    let arm = |e: usize| std::array::from_fn(|c| nodes[e].x[c] - nodes[1].x[c]);
    let d = deviation(arm(0), arm(2), triplets.blocks[0].rest_bend[0]);
    0.5 * triplets.blocks[0].stiffness[0] * d * d
}

#[test]
fn force_is_minus_the_gradient_of_the_energy() {
    for (theta, rest) in [(0.4, 1.0), (2.0, 1.0), (3.0, PI), (PI - 6e-4, PI)] {
        let (triplets, nodes) = (block(2.0, 0.0, rest), nodes_at(theta));
        let f = forces(&triplets, &nodes);
        let h = 1e-6;
        for i in 0..3 {
            for c in 0..3 {
                let shifted = |by: f64| {
                    let mut n = nodes.clone();
                    n[i].x[c] += by;
                    energy(&triplets, &n)
                };
                let slope = (shifted(h) - shifted(-h)) / (2.0 * h);
                assert!((f[i][c] + slope).abs() < 1e-6, "{theta}: {} {slope}", f[i][c]);
            }
        }
    }
}

#[test]
fn damping_takes_energy_out_and_keeps_momentum() {
    for theta in [0.2, 1.5, 2.9] {
        let nodes = nodes_at(theta);
        let f = forces(&block(0.0, 3.0, 1.0), &nodes);
        let power: f64 = f.iter().zip(&nodes).map(|(f, n)| dot(*f, n.v)).sum();
        assert!(power < 0.0);
        for c in 0..3 {
            assert!(f.iter().map(|f| f[c]).sum::<f64>().abs() < 1e-12);
        }
    }
}

/// Relative to the largest entry. The angles beyond `MIN_SINE` from pi are in the straight limit.
#[test]
fn adjoint_is_the_derivative() {
    let cases = [
        (0.4, 1.0, 1e-6),
        (2.0, 1.0, 1e-6),
        (3.0, PI, 1e-6),
        (PI - 0.01, 2.0, 1e-5),
        (PI - 1e-5, PI, 1e-6),
        (PI, PI, 1e-6),
    ];
    for (theta, rest, tolerance) in cases {
        let (triplets, nodes, lambda) = (block(2.0, 0.3, rest), nodes_at(theta), lambda());
        let mut adjoint = vec![Node::default(); 3];
        let mut gradients = vec![TripletGradient::ZERO];
        bend_adjoint(Portable, &triplets, &nodes, &lambda, &mut adjoint, &mut gradients);
        assert_adjoint(&nodes, &lambda, &adjoint, tolerance, |n| forces(&triplets, n));
    }
}

#[test]
fn parameter_gradients_are_derivatives() {
    for theta in [0.4, 2.0, 3.0] {
        let (nodes, lambda) = (nodes_at(theta), lambda());
        let (k, c, rest) = (2.0, 0.3, 1.0);
        let mut adjoint = vec![Node::default(); 3];
        let mut g = vec![TripletGradient::ZERO];
        bend_adjoint(Portable, &block(k, c, rest), &nodes, &lambda, &mut adjoint, &mut g);
        let work = |triplets: Triplets<f64>| -> f64 {
            forces(&triplets, &nodes).iter().zip(&lambda).map(|(f, l)| dot(*f, *l)).sum()
        };
        let h = 1e-5;
        let pairs = [
            (work(block(k + h, c, rest)) - work(block(k - h, c, rest)), g[0].stiffness[0]),
            (work(block(k, c + h, rest)) - work(block(k, c - h, rest)), g[0].damping[0]),
            (work(block(k, c, rest + h)) - work(block(k, c, rest - h)), g[0].rest[0]),
        ];
        for (difference, gradient) in pairs {
            let difference = difference / (2.0 * h);
            assert!((difference - gradient).abs() < 1e-6 * gradient.abs().max(1.0));
        }
    }
}

#[test]
fn straight_limit_joins_the_general_formula() {
    let triplets = block(2.0, 0.0, PI);
    let just = |sine: f64| forces(&triplets, &nodes_at(PI - sine));
    let (inside, outside) = (just(MIN_SINE * 0.999), just(MIN_SINE * 1.001));
    for (a, b) in inside.iter().flatten().zip(outside.iter().flatten()) {
        assert!((a - b).abs() < 2e-6, "{a} {b}");
    }
}

#[test]
fn degenerate_triplets_are_finite_and_skipped() {
    let coincident = vec![nodes_at(1.0)[0]; 3];
    let mut short = nodes_at(1.0);
    short[0].x = short[1].x;
    let skipped = [
        (coincident, 1.0),
        (short, PI),
        (nodes_at(0.0), 1.0),
        (nodes_at(0.0), PI),
        (nodes_at(PI), 1.0),
        (nodes_at(PI - 1e-5), 2.0),
    ];
    for (nodes, rest) in skipped {
        let triplets = block(2.0, 0.3, rest);
        assert!(forces(&triplets, &nodes).iter().flatten().all(|&x| x == 0.0), "{rest}");
        let mut adjoint = vec![Node::default(); 3];
        let mut g = vec![TripletGradient::ZERO];
        bend_adjoint(Portable, &triplets, &nodes, &lambda(), &mut adjoint, &mut g);
        assert!(adjoint.iter().flat_map(|n| n.x.into_iter().chain(n.v)).all(|x| x == 0.0));
        assert!(g[0].stiffness.iter().chain(&g[0].damping).chain(&g[0].rest).all(|&x| x == 0.0));
    }
}
