//! The surface between the nodes: triangles of nodes that are near to a point and to each other.
//! Nodes of a coarse twin stand centimetres apart, so that the nearest node alone says little.

use bendtwin_core::Point;
use bendtwin_core::geometry::{point, vector3};
use kiddo::{ImmutableKdTree, SquaredEuclidean};
use nalgebra::Vector3;

use crate::skin::BLENDED;

/// Nodes that may be corners.
const CORNERS: usize = 7;
/// Corners are at most this many spacings apart.
const WIDEST: f64 = 2.5;

/// Surface nodes in one shape.
pub(crate) struct Surface {
    nodes: Vec<Vector3<f64>>,
    tree: ImmutableKdTree<f32, 3>,
    /// Largest distance of two corners [m].
    widest_m: f64,
}

/// The point of a surface that is nearest to another point.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Foot {
    pub(crate) nodes: [u32; BLENDED],
    pub(crate) weights: [f64; BLENDED],
    pub(crate) distance_m: f64,
}

impl Surface {
    /// The surface of nodes [m]; `None` if there are none.
    pub(crate) fn new(nodes: &[Vector3<f64>], spacing_m: f64) -> Option<Self> {
        let points: Vec<Point> = nodes.iter().map(|p| point(*p)).collect();
        let finite = points.iter().flatten().all(|x| x.is_finite());
        let tree = finite.then(|| ImmutableKdTree::new_from_slice(&points).ok()).flatten()?;
        (!points.is_empty()).then(|| Self {
            nodes: nodes.to_vec(),
            tree,
            widest_m: WIDEST * spacing_m,
        })
    }

    /// The nearest node and its distance [m].
    pub(crate) fn nearest(&self, p: Point) -> (u32, f64) {
        let found = self.tree.query(&p).nearest_one::<SquaredEuclidean<f32>>().execute();
        (found.item, f64::from(found.distance).sqrt())
    }

    /// The point of the surface that is nearest to `p`.
    pub(crate) fn foot(&self, p: Point) -> Foot {
        let count =
            CORNERS.min(self.nodes.len()).try_into().unwrap_or(std::num::NonZero::<usize>::MIN);
        let found = self.tree.query(&p).nearest_n::<SquaredEuclidean<f32>>(count).execute();
        let mut near: Vec<(f32, u32)> = found.iter().map(|n| (n.distance, n.item)).collect();
        near.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let near: Vec<u32> = near.into_iter().map(|(_, n)| n).collect();
        let y = vector3(p);
        let at = |n: u32| self.nodes[n as usize];
        let joined = |a: u32, b: u32| (at(a) - at(b)).norm() <= self.widest_m;
        let first = near.first().copied().unwrap_or(0);
        let mut best = Foot {
            nodes: [first, 0, 0, 0],
            weights: [1.0, 0.0, 0.0, 0.0],
            distance_m: (y - at(first)).norm(),
        };
        let mut offer = |nodes: [u32; 3], w: [f64; 3]| {
            let foot: Vector3<f64> = nodes.iter().zip(w).map(|(n, w)| at(*n) * w).sum();
            let distance_m = (y - foot).norm();
            if distance_m < best.distance_m {
                let nodes = [nodes[0], nodes[1], nodes[2], 0];
                best = Foot { nodes, weights: [w[0], w[1], w[2], 0.0], distance_m };
            }
        };
        let others = near.get(1..).unwrap_or_default();
        for (k, &b) in others.iter().enumerate().filter(|(_, b)| joined(first, **b)) {
            let t = on_segment(y, at(first), at(b));
            offer([first, b, 0], [1.0 - t, t, 0.0]);
            for &c in others[k + 1..].iter().filter(|c| joined(first, **c) && joined(b, **c)) {
                if let Some(w) = in_triangle(y, at(first), at(b), at(c)) {
                    offer([first, b, c], w);
                }
            }
        }
        best
    }
}

/// Fraction of the way from `a` to `b` that is nearest to `y`.
fn on_segment(y: Vector3<f64>, a: Vector3<f64>, b: Vector3<f64>) -> f64 {
    let along = b - a;
    let square = along.norm_squared();
    if square > 0.0 { ((y - a).dot(&along) / square).clamp(0.0, 1.0) } else { 0.0 }
}

/// Barycentric coordinates of the foot of `y` on a triangle's plane; `None` outside the triangle, or
/// if it is too thin.
fn in_triangle(
    y: Vector3<f64>,
    a: Vector3<f64>,
    b: Vector3<f64>,
    c: Vector3<f64>,
) -> Option<[f64; 3]> {
    let (u, v, w) = (b - a, c - a, y - a);
    let (uu, uv, vv) = (u.dot(&u), u.dot(&v), v.dot(&v));
    let area = uu * vv - uv * uv;
    if area <= 0.01 * uu * vv {
        return None;
    }
    let (wu, wv) = (w.dot(&u), w.dot(&v));
    let s = (wu * vv - wv * uv) / area;
    let t = (wv * uu - wu * uv) / area;
    (s >= 0.0 && t >= 0.0 && s + t <= 1.0).then_some([1.0 - s - t, s, t])
}

/// Mean distance of surface nodes to their third neighbour [m]; 0 for fewer than two.
pub(crate) fn spacing(nodes: &[Point]) -> f64 {
    let count = 4.min(nodes.len());
    let (Ok(tree), Ok(count)) =
        (ImmutableKdTree::<f32, 3>::new_from_slice(nodes), std::num::NonZero::try_from(count))
    else {
        return 0.0;
    };
    let reach = |p: &Point| {
        let found = tree.query(p).nearest_n::<SquaredEuclidean<f32>>(count).execute();
        found.iter().map(|n| f64::from(n.distance)).fold(0.0, f64::max).sqrt()
    };
    nodes.iter().map(reach).sum::<f64>() / nodes.len() as f64
}

#[cfg(test)]
mod tests;
