//! Rods that twist: the ways through a cable from one clamp to another, or to the first branch.
//!
//! A *clamp* is an edge whose two nodes are both pinned: it gives the cable a direction there, and
//! with it a frame. A free end has no frame and turns freely, and neither has a single pinned node:
//! no torque reaches them. The part of a cable between two clamps carries one.
//!
//! A branch without clamps stands off to a side of the cable, and that side defines the cable's
//! frame there: a junction is stiff. The cable cannot turn there without lifting the branch, so the
//! first such junction ends a rod, with the branch's first node as its arm; of several, the one
//! that stands most nearly square to the rod. Between two such junctions there is no rod: the start
//! of a rollout does not determine the orientation without twist there, as it does at a clamp.
//!
//! If all branches at a junction lead to clamps, it turns until the torques of what meets there add
//! up to zero: a star of torsion springs about one free angle. Eliminating that angle leaves one
//! spring for every pair of clamps (as a star of resistors is a mesh of them): one rod for every
//! pair, each with its own stiffness.
//!
//! A third clamp on the way ends the rod, as it holds the frame. In a piece with a loop a torque
//! has two ways around, which no set of rods describes: it gets none.

use bendtwin_core::Point;

use super::NodeSample;

/// Clamps of a piece up to which it gets rods, whose number grows with the square of clamps.
const MAX_CLAMPS: usize = 16;

/// The rods of a cable, ordered by their ends; none without known edges.
pub(super) fn find(sample: &NodeSample) -> Vec<Vec<u32>> {
    let Some(edges) = &sample.edges else { return Vec::new() };
    let n = sample.node_count();
    let mut cable = Cable {
        points: sample.undeformed(),
        neighbours: vec![Vec::new(); n],
        is_pinned: vec![false; n],
    };
    sample.pins.iter().for_each(|p| cable.is_pinned[p.node as usize] = true);
    for &[a, b] in edges.iter().filter(|[a, b]| a != b) {
        cable.neighbours[a as usize].push(b);
        cable.neighbours[b as usize].push(a);
    }
    cable.neighbours.iter_mut().for_each(|near| {
        near.sort_unstable();
        near.dedup();
    });
    let mut is_done = vec![false; n];
    let mut rods = Vec::new();
    for start in 0..n as u32 {
        if !is_done[start as usize] {
            let piece = cable.piece(start, &mut is_done);
            rods.extend(cable.rods(&piece));
        }
    }
    rods
}

/// A cable's nodes as a graph.
struct Cable<'a> {
    /// Undeformed, shape [N, 3].
    points: &'a [Point],
    /// Sorted, shape [N].
    neighbours: Vec<Vec<u32>>,
    is_pinned: Vec<bool>,
}

impl Cable<'_> {
    fn near(&self, node: u32) -> &[u32] {
        &self.neighbours[node as usize]
    }

    fn is_pinned(&self, node: u32) -> bool {
        self.is_pinned[node as usize]
    }

    /// The nodes that hang together with one, sorted.
    fn piece(&self, start: u32, is_done: &mut [bool]) -> Vec<u32> {
        let (mut piece, mut next) = (vec![start], 0);
        is_done[start as usize] = true;
        while let Some(&node) = piece.get(next) {
            for &other in self.near(node) {
                if !std::mem::replace(&mut is_done[other as usize], true) {
                    piece.push(other);
                }
            }
            next += 1;
        }
        piece.sort_unstable();
        piece
    }

    /// The first pinned neighbour of a pinned node: the other node of its clamp.
    fn clamp(&self, node: u32) -> Option<u32> {
        let held = |other: &u32| self.is_pinned(*other);
        if self.is_pinned(node) { self.near(node).iter().copied().find(held) } else { None }
    }

    fn rods(&self, piece: &[u32]) -> Vec<Vec<u32>> {
        let edges: usize = piece.iter().map(|&i| self.near(i).len()).sum::<usize>() / 2;
        let is_tree = edges + 1 == piece.len();
        let leads_out = |i: &u32| self.near(*i).iter().any(|&o| !self.is_pinned(o));
        let inner_end = |i: u32| self.clamp(i).filter(|_| leads_out(&i)).map(|outer| [outer, i]);
        let clamps: Vec<[u32; 2]> = piece.iter().filter_map(|&i| inner_end(i)).collect();
        if !is_tree || clamps.len() > MAX_CLAMPS {
            return Vec::new();
        }
        let mut rods = Vec::new();
        for &[outer, inner] in &clamps {
            let free = self.near(inner).iter().filter(|o| !self.is_pinned(**o));
            for &first in free {
                self.walk(vec![outer, inner, first], &mut rods);
            }
        }
        // Between clamps each was found from both of its ends.
        let ends_in_arm = |rod: &[u32]| rod.last().is_some_and(|&last| !self.is_pinned(last));
        rods.retain(|rod| ends_in_arm(rod) || rod.get(1) < rod.iter().rev().nth(1));
        rods.sort_unstable();
        rods
    }

    /// The arm of a rod that comes to a node from the one before; none unless branches without
    /// clamps begin there.
    fn arm(&self, before: u32, at: u32) -> Option<u32> {
        let on = || self.near(at).iter().copied().filter(|&next| next != before);
        if self.is_pinned(at) || on().count() < 2 {
            return None;
        }
        let free = on().filter(|&next| !self.is_pinned(next) && !self.leads_to_clamp(at, next));
        free.max_by(|&a, &b| {
            self.sine_squared(before, at, a).total_cmp(&self.sine_squared(before, at, b))
        })
    }

    /// True if a clamp lies beyond an edge of a component that is a tree.
    fn leads_to_clamp(&self, from: u32, to: u32) -> bool {
        let mut ways = vec![[from, to]];
        while let Some([before, at]) = ways.pop() {
            if self.clamp(at).is_some() {
                return true;
            }
            ways.extend(
                self.near(at).iter().filter(|&&next| next != before).map(|&next| [at, next]),
            );
        }
        false
    }

    /// Squared sine of the angle between two successive edges; 0 where one has no length.
    fn sine_squared(&self, before: u32, at: u32, after: u32) -> f64 {
        let offset = |from: u32, to: u32| -> [f64; 3] {
            let (a, b) = (self.points[from as usize], self.points[to as usize]);
            std::array::from_fn(|c| f64::from(b[c]) - f64::from(a[c]))
        };
        let (e, g) = (offset(before, at), offset(at, after));
        let dot = |u: [f64; 3], w: [f64; 3]| u.iter().zip(w).map(|(u, w)| u * w).sum::<f64>();
        let both = dot(e, e) * dot(g, g);
        if both > 0.0 { 1.0 - dot(e, g).powi(2) / both } else { 0.0 }
    }

    /// Adds the ways on from a path to every clamp or arm that it can reach; the piece is a tree.
    fn walk(&self, path: Vec<u32>, rods: &mut Vec<Vec<u32>>) {
        let mut ways = vec![path];
        while let Some(path) = ways.pop() {
            let [.., before, at] = path[..] else { continue };
            let with = |next: u32| path.iter().copied().chain([next]).collect::<Vec<u32>>();
            if let Some(arm) = self.arm(before, at) {
                rods.push(with(arm));
                continue;
            }
            match self.clamp(at) {
                Some(outer) if outer != before => rods.push(with(outer)),
                _ => {
                    let on = self.near(at).iter().filter(|&&next| next != before);
                    ways.extend(on.map(|&next| with(next)));
                }
            }
        }
    }
}

#[cfg(test)]
mod tests;
