//! Which nodes hang together, and how pieces that do not are joined.

use super::{MIN_REST_LENGTH_M, NodeSample, spread::distance_squared};

/// Springs from each side of a joint: fewer would leave a hinge.
const JOINT_SPRINGS: usize = 3;

/// Disjoint sets of nodes.
struct Sets(Vec<u32>);

impl Sets {
    fn new(n: usize) -> Self {
        Self((0..n as u32).collect())
    }

    fn find(&mut self, mut x: u32) -> u32 {
        while self.0[x as usize] != x {
            self.0[x as usize] = self.0[self.0[x as usize] as usize];
            x = self.0[x as usize];
        }
        x
    }

    /// Joins two sets; the smaller root stays, so names do not depend on order.
    fn union(&mut self, a: u32, b: u32) -> bool {
        let (a, b) = (self.find(a), self.find(b));
        self.0[a.max(b) as usize] = a.min(b);
        a != b
    }
}

/// Adds springs until all nodes of an object hang together: every piece but
/// the first is joined at its closest approach to another piece, by up to three
/// springs from each of the two nodes. Returns how many pieces were joined.
/// Nodes that coincide with all others of their object stay alone: no spring of
/// positive length reaches them. O(N²) a round, and only where pieces exist.
pub(super) fn join(sample: &NodeSample, springs: &mut Vec<[u32; 2]>) -> usize {
    let n = sample.node_count();
    let mut sets = Sets::new(n);
    for &[a, b] in springs.iter() {
        sets.union(a, b);
    }
    let mut joined = 0;
    loop {
        let roots: Vec<u32> = (0..n as u32).map(|i| sets.find(i)).collect();
        let joints = closest_approaches(sample, &roots);
        let before = joined;
        for [a, b] in joints {
            if sets.union(a, b) {
                joined += 1;
                joint(sample, &roots, [a, b], springs);
            }
        }
        if joined == before {
            return joined;
        }
    }
}

/// For each piece but the first of its object, its closest pair with another piece.
fn closest_approaches(sample: &NodeSample, roots: &[u32]) -> Vec<[u32; 2]> {
    let n = roots.len();
    let mut best = vec![(f32::INFINITY, [0_u32; 2]); n];
    let mut first_of_object = std::collections::HashMap::new();
    for (i, &root) in roots.iter().enumerate() {
        first_of_object.entry(sample.object_ids[i]).or_insert(root);
    }
    if roots.iter().zip(&sample.object_ids).all(|(r, o)| first_of_object.get(o) == Some(r)) {
        return Vec::new();
    }
    for i in 0..n {
        if first_of_object.get(&sample.object_ids[i]) == Some(&roots[i]) {
            continue;
        }
        let slot = &mut best[roots[i] as usize];
        for k in (0..n).filter(|&k| joinable(sample, roots, i, k)) {
            let d = distance_squared(sample.positions[i], sample.positions[k]);
            if d < slot.0 && d.sqrt() > MIN_REST_LENGTH_M {
                *slot = (d, [i as u32, k as u32]);
            }
        }
    }
    best.into_iter().filter(|(d, _)| d.is_finite()).map(|(_, pair)| pair).collect()
}

fn joinable(sample: &NodeSample, roots: &[u32], i: usize, k: usize) -> bool {
    roots[i] != roots[k] && sample.object_ids[i] == sample.object_ids[k]
}

/// Springs from each of the two nodes to the nearest nodes of the other's piece.
fn joint(sample: &NodeSample, roots: &[u32], ends: [u32; 2], springs: &mut Vec<[u32; 2]>) {
    for [from, to] in [ends, [ends[1], ends[0]]] {
        let at = sample.positions[from as usize];
        let piece = roots[to as usize];
        let mut near: Vec<(f32, u32)> = (0..roots.len() as u32)
            .filter(|&k| roots[k as usize] == piece)
            .map(|k| (distance_squared(at, sample.positions[k as usize]), k))
            .filter(|(d, _)| d.sqrt() > MIN_REST_LENGTH_M)
            .collect();
        near.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        springs.extend(near.iter().take(JOINT_SPRINGS).map(|&(_, k)| [from.min(k), from.max(k)]));
    }
}
