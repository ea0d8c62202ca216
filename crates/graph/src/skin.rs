//! Binding of surface points to the nodes that carry them: moving least squares at rest.
//!
//! A point's carriers are the nodes nearest to it among those that springs join closely with the
//! nearest of all, so that a hand never carries a hip that it touches. With weights θ_i that fall
//! with distance, c their mean and S their covariance, w_i = θ_i (1 + (x_i - c)ᵀ S⁻¹ (p - c)) are
//! the affine combination that gives p (Levin 1998, "The approximation power of moving
//! least-squares"). Directions in which the carriers hardly extend are damped; what that leaves over
//! is the offset of [`Skin`].

use std::{cmp::Reverse, collections::BinaryHeap};

use bendtwin_core::{
    Graph, Point, Skin,
    geometry::{Vector, add, cross, distance, length, scaled, sub, wide},
    twin::skin::offset_in_frame,
};
use kiddo::{ImmutableKdTree, SquaredEuclidean};
use nalgebra::{Matrix3, Vector3};

use crate::{SurfacePoints, spread};

/// Carriers of a point, at most.
const CARRIERS: usize = 16;
/// Nodes around a node that may be carriers of the points near it.
const AROUND: usize = 24;
/// A point nearer to a node than this is that node [m].
const SAME_M: f64 = 1e-6;
/// Offsets below this are rounding [m].
const NO_OFFSET_M: f64 = 1e-6;
/// Square of the distance over that of the farthest carrier, at which θ stops to grow.
const CORE: f64 = 0.01;
/// Directions with a variance below this share of the largest are damped.
const THIN: f64 = 0.01;
/// Largest distance from the carriers' mean, in standard deviations along an axis, that weights
/// reach; the rest is offset.
const REACH: f64 = 3.0;
/// Least area of a frame's triangle, over the square of its largest edge.
const LEAST_AREA: f64 = 0.05;

/// Binds surface points to the nodes of a graph at rest. Positions must be finite. Without nodes
/// there is no skin.
pub fn bind_skin(graph: &Graph, surface: &SurfacePoints) -> Skin {
    bind_points(graph, &graph.rest_positions, surface)
}

/// Binds points to the nodes of a graph that are at `nodes` [m], shape [N, 3]. Positions must be
/// finite, and those of the nodes as many as the graph has. Without nodes no point is bound.
pub fn bind_points(graph: &Graph, nodes: &[Point], points: &SurfacePoints) -> Skin {
    let mut skin = Skin::default();
    let Some(tree) = spread::tree(nodes) else { return skin };
    let neighbours = Neighbours::new(graph, nodes);
    let mut around: Vec<Option<Vec<u32>>> = vec![None; nodes.len()];
    for (p, &observed) in points.positions.iter().zip(&points.observed_points) {
        let nearest = nearest(&tree, p);
        let at = |i: u32| wide(nodes[i as usize]);
        if distance(at(nearest), wide(*p)) < SAME_M {
            skin.push(observed, &[(nearest, 1.0)], [Skin::NO_FRAME; 3], [0.0; 3]);
            continue;
        }
        let known = around[nearest as usize].get_or_insert_with(|| neighbours.around(nearest));
        let carriers = carriers(known, at, wide(*p));
        let weights = weights(&carriers, at, wide(*p));
        let sum =
            weights.iter().fold([0.0; 3], |sum, &(i, w)| add(sum, scaled(at(i), f64::from(w))));
        let (frame, offset) = framed(&carriers, at, sub(wide(*p), sum));
        skin.push(observed, &weights, frame, offset);
    }
    skin
}

/// The node nearest to a point, of equally near ones the first.
fn nearest(tree: &ImmutableKdTree<f32, 3>, p: &Point) -> u32 {
    let one = std::num::NonZero::<usize>::MIN;
    let found = tree.query(p).nearest_n::<SquaredEuclidean<f32>>(one).execute();
    let Some(first) = found.first() else { return 0 };
    let radius = first.distance.next_up();
    let same = tree.query(p).within::<SquaredEuclidean<f32>>(radius).execute();
    same.iter().map(|n| n.item).min().unwrap_or(first.item)
}

/// Springs between nodes, by node.
struct Neighbours<'a> {
    /// Positions of the nodes [m], shape [N, 3].
    nodes: &'a [Point],
    starts: Vec<u32>,
    ends: Vec<u32>,
}

impl<'a> Neighbours<'a> {
    fn new(graph: &Graph, nodes: &'a [Point]) -> Self {
        let n = graph.node_count();
        let inner = || graph.springs.iter().filter(|s| (s[1] as usize) < n);
        let mut starts = vec![0_u32; n + 1];
        inner().flatten().for_each(|&i| starts[i as usize + 1] += 1);
        for i in 0..n {
            starts[i + 1] += starts[i];
        }
        let mut next = starts.clone();
        let mut ends = vec![0; starts[n] as usize];
        for &[a, b] in inner() {
            for (from, to) in [(a, b), (b, a)] {
                ends[next[from as usize] as usize] = to;
                next[from as usize] += 1;
            }
        }
        Self { nodes, starts, ends }
    }

    /// The nodes nearest to a node along springs, itself the first.
    fn around(&self, from: u32) -> Vec<u32> {
        let at = |i: u32| wide(self.nodes[i as usize]);
        let mut found: Vec<u32> = Vec::with_capacity(AROUND);
        // Distances are not negative, so their bits have the same order.
        let mut open = BinaryHeap::from([Reverse((0_u64, from))]);
        while let Some(Reverse((bits, node))) = open.pop() {
            if found.contains(&node) {
                continue;
            }
            found.push(node);
            if found.len() == AROUND {
                break;
            }
            let own = self.starts[node as usize] as usize..self.starts[node as usize + 1] as usize;
            for &to in &self.ends[own] {
                if !found.contains(&to) {
                    let way = f64::from_bits(bits) + distance(at(node), at(to));
                    open.push(Reverse((way.to_bits(), to)));
                }
            }
        }
        found
    }
}

/// The nodes of `of` nearest to a point, the nearest first.
fn carriers(of: &[u32], at: impl Fn(u32) -> Vector, p: Vector) -> Vec<u32> {
    let mut by_distance: Vec<(f64, u32)> = of.iter().map(|&i| (distance(at(i), p), i)).collect();
    by_distance.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    by_distance.into_iter().take(CARRIERS).map(|(_, i)| i).collect()
}

/// Weight of each carrier.
fn weights(carriers: &[u32], at: impl Fn(u32) -> Vector, p: Vector) -> Vec<(u32, f32)> {
    let squares: Vec<f64> = carriers.iter().map(|&i| distance(at(i), p).powi(2)).collect();
    let farthest = squares.last().copied().unwrap_or_default();
    let core = (CORE * farthest).max(SAME_M * SAME_M);
    let thetas: Vec<f64> = squares.iter().map(|d| 1.0 / (d + core)).collect();
    let total: f64 = thetas.iter().sum();
    let at = |i: u32| Vector3::from(at(i));
    let each = || carriers.iter().zip(thetas.iter().map(|t| t / total));
    let mean: Vector3<f64> = each().map(|(&i, t)| at(i) * t).sum();
    let spread: Matrix3<f64> = each()
        .map(|(&i, t)| {
            let d = at(i) - mean;
            d * d.transpose() * t
        })
        .sum();
    let slope = slope(spread, Vector3::from(p) - mean);
    let weight = |(&i, t): (&u32, f64)| (i, (t * (1.0 + slope.dot(&(at(i) - mean)))) as f32);
    each().map(weight).collect()
}

/// S⁻¹ y within [`REACH`], damped along directions in which S is [`THIN`].
fn slope(spread: Matrix3<f64>, y: Vector3<f64>) -> Vector3<f64> {
    let eigen = spread.symmetric_eigen();
    let least = THIN * eigen.eigenvalues.max();
    let mut slope = Vector3::zeros();
    for (k, &variance) in eigen.eigenvalues.iter().enumerate() {
        // Nodes in one place have no spread but that of rounding.
        if variance <= SAME_M * SAME_M {
            continue;
        }
        let axis = eigen.eigenvectors.column(k);
        let deviation = variance.sqrt();
        let along = axis.dot(&y).clamp(-REACH * deviation, REACH * deviation);
        let inverse = if variance >= least { 1.0 / variance } else { variance / (least * least) };
        slope += axis * (inverse * along);
    }
    slope
}

/// Frame of an offset, and the offset along its axes [m].
fn framed(carriers: &[u32], at: impl Fn(u32) -> Vector, offset: Vector) -> ([u32; 3], Point) {
    let none = [Skin::NO_FRAME; 3];
    if length(offset) < NO_OFFSET_M {
        return (none, [0.0; 3]);
    }
    let world = (none, offset.map(|x| x as f32));
    let Some((&a, others)) = carriers.split_first() else { return world };
    let mut best = (0.0, none);
    for (k, &b) in others.iter().enumerate() {
        for &c in &others[k + 1..] {
            let edges = [sub(at(b), at(a)), sub(at(c), at(a))];
            let area = length(cross(edges[0], edges[1]));
            let largest = edges.iter().map(|e| length(*e)).fold(0.0, f64::max);
            if area > best.0 && area > LEAST_AREA * largest * largest {
                best = (area, [a, b, c]);
            }
        }
    }
    match best {
        (area, frame) if area > 0.0 => match offset_in_frame(frame.map(at), offset) {
            Some(own) => (frame, own.map(|x| x as f32)),
            None => world,
        },
        _ => world,
    }
}

#[cfg(test)]
mod tests;
