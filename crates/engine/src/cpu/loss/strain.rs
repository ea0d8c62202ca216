//! The strain of springs between two nodes as a term, with its gradients by positions and by rest
//! lengths.
//!
//! With s = l/l0 - 1 and e = max(0, |s| - limit), the value is the mean of e² over springs that have
//! a rest length; `d e² / d xj = 2 e sign(s) d / l0 = -d e² / d xi` with d = (xj - xi) / l, and
//! `d e² / d l0 = -2 e sign(s) l / l0²`.

use super::mean_over;
use crate::cpu::{
    arithmetic::{LANES, Node, Quad, Real, add_scaled, dot, sub},
    system::System,
};

/// The current stretch of a spring between two nodes.
struct Stretch<T> {
    /// Index in the graph.
    spring: usize,
    ends: [usize; 2],
    /// From the first end to the second [m].
    along: Quad<T>,
    /// l [m].
    length: f64,
    /// l0 [m].
    rest: f64,
}

impl<T: Real> Stretch<T> {
    /// e sign(s).
    fn excess(&self, limit: f32) -> f64 {
        let strain = self.length / self.rest - 1.0;
        (strain.abs() - f64::from(limit)).max(0.0).copysign(strain)
    }
}

/// All springs between two nodes that have a rest length, in the order of the system's blocks.
fn stretches<'a, T: Real>(
    system: &'a System<T>,
    nodes: &'a [Node<T>],
) -> impl Iterator<Item = Stretch<T>> + 'a {
    let blocks = system.springs.strips.iter().flat_map(|s| s.blocks().map(move |b| (s, b)));
    blocks.flat_map(|(strip, b)| (0..LANES).map(move |l| (strip, b, l))).filter_map(
        move |(strip, b, l)| {
            let block = &system.springs.blocks[b];
            let ends = [strip.owners[l] as usize, block.other[l] as usize];
            let spring = system.spring_at(b, l)?;
            let has_strain = block.rest[l] > T::ZERO && ends.iter().all(|&i| i < system.nodes);
            has_strain.then(|| {
                let along = sub(nodes[ends[1]].x, nodes[ends[0]].x);
                let length = dot(along, along).to_f64().sqrt();
                Stretch { spring, ends, along, length, rest: block.rest[l].to_f64() }
            })
        },
    )
}

/// Value of the term.
pub(super) fn value<T: Real>(system: &System<T>, nodes: &[Node<T>], limit: f32) -> f64 {
    let squares = stretches(system, nodes).map(|s| s.excess(limit).powi(2));
    let (count, sum) = squares.fold((0, 0.0), |(count, sum), x| (count + 1, sum + x));
    sum * mean_over(count)
}

/// Adds its gradient, weighted, to `bar` and to that by rest lengths, shape [E].
pub(super) fn add_gradient<T: Real>(
    system: &System<T>,
    nodes: &[Node<T>],
    limit: f32,
    weight: f64,
    bar: &mut [Node<T>],
    rest_bar: &mut [T],
) {
    let w = 2.0 * weight * mean_over(stretches(system, nodes).count());
    for s in stretches(system, nodes) {
        let slope = w * s.excess(limit);
        if slope == 0.0 {
            continue;
        }
        rest_bar[s.spring] += T::from_f64(-slope * s.length / (s.rest * s.rest));
        // Ends in one point have no direction in which to part.
        if s.length > 0.0 {
            let pull = T::from_f64(slope / (s.rest * s.length));
            let [i, j] = s.ends;
            bar[i].x = add_scaled(bar[i].x, -pull, s.along);
            bar[j].x = add_scaled(bar[j].x, pull, s.along);
        }
    }
}
