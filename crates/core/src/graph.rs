//! The graph of a twin: nodes, springs, bending triplets and rods. Topology and rest
//! geometry only; the numbers that fitting changes are in [`crate::Params`].

use serde::{Deserialize, Serialize};

use crate::{
    Point,
    geometry::{length, sub},
};

/// The kind of a node. Nodes are ordered by kind: all observed surface nodes, then completed
/// surface, then interior. The numbers are the file format's.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[repr(u8)]
pub enum NodeKind {
    /// A tracked point of the capture.
    Observed = 0,
    /// Surface from a shape prior, seen by no camera.
    Completed = 1,
    /// Inside the object.
    Interior = 2,
}

impl NodeKind {
    /// True if metrics and the Chamfer loss count this node.
    pub fn is_surface(self) -> bool {
        self != Self::Interior
    }
}

/// A node that a control point prescribes exactly, as a gripper that clamps a
/// cable end: its position is the control point's plus `offset_m`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Pin {
    /// Node index.
    pub node: u32,
    /// Control point index.
    pub control: u32,
    /// Node minus control point at rest [m].
    pub offset_m: Point,
}

/// Nodes, springs, triplets and rods.
///
/// **Endpoints.** Springs and triplets name *endpoints*: `e < N` is node `e`,
/// `N <= e < N + C` is control point `e - N`. A control spring is therefore a
/// spring like any other, and a triplet may include a control point. A rod names nodes.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Graph {
    /// Rest positions [m], shape [N, 3].
    pub rest_positions: Vec<Point>,
    /// Kind of each node, shape [N]; non-decreasing.
    pub kinds: Vec<NodeKind>,
    /// Mass of each node in node-mass units, shape [N]; positive.
    pub masses: Vec<f32>,
    /// Object of each node (contact acts between objects), shape [N].
    pub object_ids: Vec<u32>,
    /// The capture's observed point for each node, shape [N]; `u32::MAX` for nodes without one.
    pub observed_points: Vec<u32>,
    /// Control points at rest [m], shape [C, 3].
    pub control_rest: Vec<Point>,
    /// Axial springs as unordered endpoint pairs, shape [E, 2]; the first end is a node.
    pub springs: Vec<[u32; 2]>,
    /// Bending triplets as endpoints (i, j, k), j the centre, shape [T, 3].
    pub triplets: Vec<[u32; 3]>,
    /// Nodes prescribed by control points.
    pub pins: Vec<Pin>,
    /// Rods that twist: each a path of nodes, in order, of at least [`Graph::MIN_ROD_NODES`]. Its
    /// first two nodes are pinned: a clamp, which gives a position and a direction; its rotation
    /// about that direction is carried along by parallel transport. Its last two are either a clamp
    /// too, or a junction and the first node of a branch there, its *arm*, whose direction holds
    /// the rod's frame. Clamps may open later, and hands clamp the rod elsewhere.
    #[serde(default)]
    pub rods: Vec<Vec<u32>>,
}

impl Graph {
    /// Marks a node that is no observed point of the capture.
    pub const NOT_OBSERVED: u32 = u32::MAX;

    /// Fewest nodes of a rod: two at each of its ends.
    pub const MIN_ROD_NODES: usize = 4;

    /// True if a rod ends in the arm of a branch, and not in a clamp.
    pub fn has_arm(&self, rod: &[u32]) -> bool {
        rod.last().is_some_and(|&last| self.pins.iter().all(|p| p.node != last))
    }

    /// Share of a rod's length at rest that belongs to each of its inner nodes: half of both edges
    /// there. They sum up to 1.
    pub fn rod_shares(&self, rod: &[u32]) -> Vec<f32> {
        let edge = |pair: &[u32]| {
            let [a, b] = [pair[0], pair[1]].map(|i| self.rest_positions[i as usize]);
            length(sub(b, a)).max(f32::MIN_POSITIVE)
        };
        let edges: Vec<f32> = rod.windows(2).map(edge).collect();
        let inner: Vec<f32> = edges.windows(2).map(|pair| pair[0] + pair[1]).collect();
        let whole: f32 = inner.iter().sum();
        inner.into_iter().map(|length| length / whole).collect()
    }

    /// Number of nodes N.
    pub fn node_count(&self) -> usize {
        self.rest_positions.len()
    }

    /// Number of control points C.
    pub fn control_count(&self) -> usize {
        self.control_rest.len()
    }

    /// Number of surface nodes; they are nodes `0..surface_count()`.
    pub fn surface_count(&self) -> usize {
        self.kinds.iter().take_while(|k| k.is_surface()).count()
    }

    /// Rest position of an endpoint, node or control point [m].
    pub fn rest_endpoint(&self, endpoint: u32) -> Point {
        let n = self.node_count();
        let e = endpoint as usize;
        if e < n { self.rest_positions[e] } else { self.control_rest[e - n] }
    }

    /// Checks that lengths agree, indices exist and numbers are finite.
    ///
    /// # Errors
    /// The first contradiction found, as a sentence.
    pub fn check(&self) -> Result<(), String> {
        let (n, c) = (self.node_count(), self.control_count());
        let lengths = [
            ("kinds", self.kinds.len()),
            ("masses", self.masses.len()),
            ("object ids", self.object_ids.len()),
            ("observed points", self.observed_points.len()),
        ];
        if let Some((what, len)) = lengths.into_iter().find(|(_, len)| *len != n) {
            return Err(format!("{n} nodes but {len} {what}"));
        }
        if !self.kinds.is_sorted() {
            return Err("nodes are not ordered by kind".into());
        }
        let points = self.rest_positions.iter().chain(&self.control_rest).flatten();
        if !points.chain(self.pins.iter().flat_map(|p| &p.offset_m)).all(|x| x.is_finite()) {
            return Err("a rest position is not finite".into());
        }
        if let Some(i) = self.masses.iter().position(|m| !(m.is_finite() && *m > 0.0)) {
            return Err(format!("node {i} has mass {}: it must be positive", self.masses[i]));
        }
        let limit = (n + c) as u32;
        for (i, &[a, b]) in self.springs.iter().enumerate() {
            if a as usize >= n || b >= limit || a == b {
                return Err(format!(
                    "spring {i} joins endpoints {a} and {b} of {n} nodes and {c} control points"
                ));
            }
        }
        for (t, &[i, j, k]) in self.triplets.iter().enumerate() {
            if i >= limit || j >= limit || k >= limit || i == j || j == k || i == k {
                return Err(format!(
                    "triplet {t} names endpoints {i}, {j}, {k} of {n} nodes and {c} control points"
                ));
            }
        }
        let mut pinned = vec![false; n];
        for p in &self.pins {
            if p.node as usize >= n || p.control as usize >= c {
                return Err(format!("a pin joins node {} and control point {}", p.node, p.control));
            }
            if std::mem::replace(&mut pinned[p.node as usize], true) {
                return Err(format!("node {} is pinned twice", p.node));
            }
        }
        self.rods.iter().enumerate().try_for_each(|(r, rod)| check_rod(r, rod, &pinned))
    }
}

/// A rod is a path without loops from a clamp to a clamp or an arm; `pinned` has an entry per node.
fn check_rod(index: usize, rod: &[u32], pinned: &[bool]) -> Result<(), String> {
    let least = Graph::MIN_ROD_NODES;
    if rod.len() < least {
        return Err(format!("rod {index} has {} nodes: it takes at least {least}", rod.len()));
    }
    if let Some(node) = rod.iter().find(|&&i| i as usize >= pinned.len()) {
        return Err(format!("rod {index} names node {node} of {} nodes", pinned.len()));
    }
    let mut sorted = rod.to_vec();
    sorted.sort_unstable();
    if let Some(twice) = sorted.windows(2).find(|pair| pair[0] == pair[1]) {
        return Err(format!("rod {index} passes node {} twice", twice[0]));
    }
    if let Some(node) = rod[..2].iter().find(|&&i| !pinned[i as usize]) {
        return Err(format!(
            "rod {index} is not clamped at node {node}: its first two nodes must be pinned"
        ));
    }
    let [before, last] = [2, 1].map(|back| rod[rod.len() - back]);
    if pinned[before as usize] != pinned[last as usize] {
        return Err(format!(
            "rod {index} ends in nodes {before} and {last}: both must be pinned (a clamp) or none (an arm)"
        ));
    }
    Ok(())
}

#[cfg(test)]
mod tests;
