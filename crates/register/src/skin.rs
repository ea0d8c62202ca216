//! Points that are fixed to an object between its nodes: each moves with the nodes that are nearest
//! to it at rest.
//!
//! A point is at c + R o: c the weighted mean of its nearest nodes, R the rotation (Kabsch's) of
//! the nodes around it since the reference, o its offset from c there.

use std::sync::Arc;

use bendtwin_core::{
    Point,
    geometry::{Kabsch, Pair, Prior, kabsch, point, vector3},
};
use kiddo::{ImmutableKdTree, SquaredEuclidean};
use nalgebra::{Matrix3, Vector3};

use crate::Error;

/// Nodes in the weighted mean, at most.
pub(crate) const BLENDED: usize = 4;
/// Nodes that give the rotation, at most.
const AROUND: usize = 10;
/// Points nearer to a node than this are that node [m].
const SAME_M: f64 = 1e-6;
/// Deviation of nodes below which a rotation that they leave open stays as it is [m].
const OPEN_M: f64 = 1e-4;

/// Places of points on an object, shape [M].
#[derive(Clone, Debug, PartialEq)]
pub struct Skin {
    /// Node positions in which the points were bound [m], shape [N, 3]; empty if all are nodes.
    reference: Arc<Vec<Point>>,
    anchors: Vec<Anchor>,
}

/// The place of a point.
#[derive(Clone, Debug, PartialEq)]
struct Anchor {
    /// Nodes around it, the nearest first.
    around: Vec<u32>,
    /// Weights of the first nodes; 0 for no node.
    weights: [f64; BLENDED],
    /// Offset from the weighted mean in the reference [m].
    offset: Vector3<f64>,
}

/// A place as a weighted mean of nodes and an offset that turns with them.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Placed {
    pub(crate) nodes: [u32; BLENDED],
    pub(crate) weights: [f64; BLENDED],
    /// Offset as it is turned now [m].
    pub(crate) offset: Vector3<f64>,
}

impl Skin {
    /// Points that are nodes: keypoints of a twin.
    pub fn nodes(nodes: &[u32]) -> Self {
        let mut weights = [0.0; BLENDED];
        weights[0] = 1.0;
        let at = |&n: &u32| Anchor { around: vec![n], weights, offset: Vector3::zeros() };
        Self { reference: Arc::default(), anchors: nodes.iter().map(at).collect() }
    }

    /// Binds points to nodes, both at the same time [m]; `None` if there are no nodes, or a position
    /// is not finite.
    pub fn bind(nodes: &[Point], points: &[Point]) -> Option<Self> {
        if !nodes.iter().chain(points).flatten().all(|x| x.is_finite()) {
            return None;
        }
        let tree: ImmutableKdTree<f32, 3> = ImmutableKdTree::new_from_slice(nodes).ok()?;
        let count = AROUND.min(nodes.len()).try_into().ok()?;
        let bind = |p: &Point| {
            let found = tree.query(p).nearest_n::<SquaredEuclidean<f32>>(count).execute();
            let mut near: Vec<(f64, u32)> =
                found.iter().map(|n| (f64::from(n.distance).sqrt(), n.item)).collect();
            near.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
            Anchor::new(nodes, &near, *p)
        };
        let anchors = points.iter().map(bind).collect::<Option<_>>()?;
        Some(Self { reference: Arc::new(nodes.to_vec()), anchors })
    }

    /// Number of points M.
    pub fn len(&self) -> usize {
        self.anchors.len()
    }

    /// True without points.
    pub fn is_empty(&self) -> bool {
        self.anchors.is_empty()
    }

    /// Some of the points, in this order; indices that do not exist are left out.
    #[must_use]
    pub fn select(&self, points: &[usize]) -> Self {
        let anchors = points.iter().filter_map(|&p| self.anchors.get(p).cloned()).collect();
        Self { reference: Arc::clone(&self.reference), anchors }
    }

    /// Positions of the points when the nodes are at `nodes` [m], shape [M, 3].
    ///
    /// # Errors
    /// If the points are of an object with more nodes.
    pub fn positions(&self, nodes: &[Point]) -> Result<Vec<Point>, Error> {
        self.check(nodes.len())?;
        let nodes: Vec<Vector3<f64>> = nodes.iter().map(|p| vector3(*p)).collect();
        Ok((0..self.len()).map(|p| point(self.place(p, &nodes).position(&nodes))).collect())
    }

    /// A point's place, for nodes that are checked to exist.
    pub(crate) fn place(&self, point: usize, nodes: &[Vector3<f64>]) -> Placed {
        let anchor = &self.anchors[point];
        let mut placed =
            Placed { nodes: [0; BLENDED], weights: anchor.weights, offset: Vector3::zeros() };
        for (to, from) in placed.nodes.iter_mut().zip(&anchor.around) {
            *to = *from;
        }
        if anchor.offset != Vector3::zeros() {
            placed.offset = self.rotation(anchor, nodes) * anchor.offset;
        }
        placed
    }

    /// Rotation of the nodes around a place since the reference.
    fn rotation(&self, anchor: &Anchor, nodes: &[Vector3<f64>]) -> Matrix3<f64> {
        let reach = |n: u32| {
            let d = vector3(self.reference[n as usize])
                - vector3(self.reference[anchor.around[0] as usize]);
            d.norm_squared()
        };
        let scale = anchor.around.last().map_or(1.0, |n| reach(*n)).max(1e-12);
        let pairs: Vec<Pair> = anchor
            .around
            .iter()
            .map(|&n| Pair {
                before: self.reference[n as usize],
                after: point(nodes[n as usize]),
                weight: 1.0 / (0.1 + reach(n) / scale),
            })
            .collect();
        let weights: Vec<f64> = pairs.iter().map(|p| p.weight).collect();
        let prior = Some(Prior { rotation: Matrix3::identity(), deviation_m: OPEN_M });
        let options = Kabsch { prior, ..Kabsch::default() };
        kabsch(&pairs, &weights, &options).map_or_else(Matrix3::identity, |fit| fit.rotation)
    }

    /// Checks that the points' nodes exist.
    pub(crate) fn check(&self, node_count: usize) -> Result<(), Error> {
        let missing = |a: &Anchor| a.around.iter().any(|n| *n as usize >= node_count);
        match self.anchors.iter().position(missing) {
            Some(p) => Err(Error::Invalid(format!(
                "track {p} is on a node that the twin does not have: it has nodes 0 to {}",
                node_count.saturating_sub(1)
            ))),
            None => Ok(()),
        }
    }
}

impl Anchor {
    fn new(nodes: &[Point], near: &[(f64, u32)], p: Point) -> Option<Self> {
        let (nearest, _) = near.first()?;
        let mut weights = [0.0; BLENDED];
        if *nearest < SAME_M {
            weights[0] = 1.0;
            return Some(Self { around: vec![near[0].1], weights, offset: Vector3::zeros() });
        }
        for (w, (d, _)) in weights.iter_mut().zip(near) {
            *w = 1.0 / (d * d);
        }
        let total: f64 = weights.iter().sum();
        weights.iter_mut().for_each(|w| *w /= total);
        let mean: Vector3<f64> =
            weights.iter().zip(near).map(|(w, (_, n))| vector3(nodes[*n as usize]) * *w).sum();
        let around = near.iter().map(|(_, n)| *n).collect();
        Some(Self { around, weights, offset: vector3(p) - mean })
    }
}

impl Placed {
    /// Position [m].
    pub(crate) fn position(&self, nodes: &[Vector3<f64>]) -> Vector3<f64> {
        self.blend(nodes) + self.offset
    }

    /// Weighted mean of a quantity of the nodes.
    pub(crate) fn blend(&self, of: &[Vector3<f64>]) -> Vector3<f64> {
        self.nodes.iter().zip(self.weights).map(|(n, w)| of[*n as usize] * w).sum()
    }
}

#[cfg(test)]
mod tests;
