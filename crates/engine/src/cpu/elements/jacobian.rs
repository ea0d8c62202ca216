//! Finite differences of a force against its adjoint; for tests.

use crate::cpu::arithmetic::{Node, Quad, dot};

/// Compares, for every coordinate of every node, the derivative of `sum lambda . force` with the
/// adjoint; the tolerance is relative to the largest derivative.
pub(crate) fn assert_adjoint(
    nodes: &[Node<f64>],
    lambda: &[Quad<f64>],
    adjoint: &[Node<f64>],
    tolerance: f64,
    forces: impl Fn(&[Node<f64>]) -> Vec<Quad<f64>>,
) {
    let largest = |pick: fn(&Node<f64>) -> Quad<f64>| {
        adjoint.iter().flat_map(pick).fold(1e-12, |m: f64, x| m.max(x.abs()))
    };
    let (x_scale, v_scale) = (largest(|n| n.x), largest(|n| n.v));
    for i in 0..nodes.len() {
        for c in 0..3 {
            let work = |dx: f64, dv: f64| -> f64 {
                let mut moved = nodes.to_vec();
                moved[i].x[c] += dx;
                moved[i].v[c] += dv;
                forces(&moved).iter().zip(lambda).map(|(f, l)| dot(*f, *l)).sum()
            };
            let h = 1e-7;
            let by_x = (work(h, 0.0) - work(-h, 0.0)) / (2.0 * h);
            let h = 1e-4;
            let by_v = (work(0.0, h) - work(0.0, -h)) / (2.0 * h);
            let (x, v) = (adjoint[i].x[c], adjoint[i].v[c]);
            assert!((by_x - x).abs() < tolerance * x_scale, "node {i} x{c}: {by_x} but {x}");
            assert!((by_v - v).abs() < tolerance * v_scale, "node {i} v{c}: {by_v} but {v}");
        }
    }
}
