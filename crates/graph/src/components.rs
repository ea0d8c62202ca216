//! Connected components of a graph, and springs that join them.

use std::{collections::HashMap, num::NonZero};

use bendtwin_core::{DisjointSets, Point};
use bendtwin_near::{PointTree, Search};
use kiddo::{ImmutableKdTree, SquaredEuclidean};

use super::{MIN_REST_LENGTH_M, NodeSample, spread::distance_squared};

/// Springs from each side of a joint: fewer would leave a hinge.
const JOINT_SPRINGS: usize = 3;
/// Share of [`MIN_REST_LENGTH_M`] below which nodes are certainly too near for a spring.
const TOO_NEAR: f32 = 0.99;
/// Nearest nodes that are searched before all nodes are.
const FEW: NonZero<usize> = NonZero::new(24).unwrap();

/// Adds springs until all nodes of an object hang together: every piece but
/// the first is joined at its closest approach to another piece, by up to three
/// springs from each of the two nodes. Returns how many pieces were joined.
/// Nodes that coincide with all others of their object stay alone: no spring of
/// positive length reaches them.
pub(super) fn join(
    sample: &NodeSample,
    tree: &ImmutableKdTree<f32, 3>,
    springs: &mut Vec<[u32; 2]>,
) -> usize {
    let n = sample.node_count();
    let mut sets = DisjointSets::new(n);
    for &[a, b] in springs.iter() {
        sets.union(a, b);
    }
    let mut joined = 0;
    loop {
        let roots = sets.names();
        let (members, trees) = (HashMap::new(), HashMap::new());
        let mut pieces = Pieces { sample, tree, roots, members, trees };
        let before = joined;
        for [a, b] in pieces.closest_approaches() {
            if sets.union(a, b) {
                joined += 1;
                pieces.joint([a, b], springs);
            }
        }
        if joined == before {
            return joined;
        }
    }
}

/// Nodes by piece.
struct Pieces<'a> {
    sample: &'a NodeSample,
    tree: &'a ImmutableKdTree<f32, 3>,
    /// Name of each node's piece, shape [N].
    roots: Vec<u32>,
    /// Nodes by piece, once they are asked for, and trees of those that were.
    members: HashMap<u32, Vec<u32>>,
    trees: HashMap<u32, PointTree>,
}

impl Pieces<'_> {
    /// Closest pair with another piece, for each piece but the first of its object.
    fn closest_approaches(&self) -> Vec<[u32; 2]> {
        let objects = &self.sample.object_ids;
        let mut first = HashMap::new();
        for (root, object) in self.roots.iter().zip(objects) {
            first.entry(*object).or_insert(*root);
        }
        let mut best = vec![(f32::INFINITY, [0_u32; 2]); self.roots.len()];
        let mut consider = |i: usize, near: Vec<(f32, u32)>| {
            let slot = &mut best[self.roots[i] as usize];
            if let Some((distance, k)) = nearest_first(near, 1).first()
                && *distance < slot.0
            {
                *slot = (*distance, [i as u32, *k]);
            }
            slot.0
        };
        let elsewhere =
            |i: usize| move |k: usize| self.roots[k] != self.roots[i] && objects[k] == objects[i];
        // Most nodes are ruled out by those that have another component among a few neighbours.
        let mut unseen = Vec::new();
        for (i, root) in self.roots.iter().enumerate() {
            if first.get(&objects[i]) != Some(root) {
                let (near, seen_to) = self.few(i, elsewhere(i));
                if near.is_empty() && seen_to.is_finite() {
                    unseen.push((i, seen_to));
                }
                consider(i, near);
            }
        }
        if unseen.is_empty() {
            return best.into_iter().filter(|(d, _)| d.is_finite()).map(|(_, pair)| pair).collect();
        }
        let all = PointTree::grouped(&self.sample.positions, &self.roots, metric);
        for (i, seen_to) in unseen {
            let nearest = consider(i, Vec::new());
            if seen_to < nearest {
                consider(i, self.elsewhere(&all, i, nearest));
            }
        }
        best.into_iter().filter(|(d, _)| d.is_finite()).map(|(_, pair)| pair).collect()
    }

    /// Adds springs from each of two nodes to the nearest nodes of the other's piece.
    fn joint(&mut self, ends: [u32; 2], springs: &mut Vec<[u32; 2]>) {
        for [from, to] in [ends, [ends[1], ends[0]]] {
            let piece = self.roots[to as usize];
            let opposite = |k: usize| self.roots[k] == piece;
            let (mut near, _) = self.few(from as usize, opposite);
            if near.is_empty() {
                near = self.of_piece(from as usize, piece);
            }
            let near = nearest_first(near, JOINT_SPRINGS);
            springs.extend(near.into_iter().map(|(_, k)| [from.min(k), from.max(k)]));
        }
    }

    /// Nodes of some kind among the few nearest to node `i`, as squared distance and node, and the
    /// squared distance up to which all were searched.
    fn few(&self, i: usize, wanted: impl Fn(usize) -> bool) -> (Vec<(f32, u32)>, f32) {
        let at = self.sample.positions[i];
        let found = self.tree.query(&at).nearest_n::<SquaredEuclidean<f32>>(FEW).execute();
        let seen_to = match found.last() {
            Some(last) if found.len() == FEW.get() => last.distance,
            _ => f32::INFINITY,
        };
        let found = found.into_iter().map(|f| (f.distance, f.item));
        (found.filter(|f| apart(f) && wanted(f.1 as usize)).collect(), seen_to)
    }

    /// The node of another piece of its object nearest to node `i`, nearer than a squared distance, if there is
    /// one. Of its own piece, and of nodes too near for a spring, there may be any number.
    fn elsewhere(&self, all: &PointTree, i: usize, within: f32) -> Vec<(f32, u32)> {
        let objects = &self.sample.object_ids;
        let others = Search {
            most: f64::from(within),
            other_than: Some((&self.roots, self.roots[i])),
            ..apart_search(1)
        };
        let wanted = |k: &(f32, u32)| apart(k) && objects[k.1 as usize] == objects[i];
        found(all, self.sample.positions[i], others, wanted)
    }

    /// The nodes of a piece nearest to node `i`.
    fn of_piece(&mut self, i: usize, piece: u32) -> Vec<(f32, u32)> {
        if self.members.is_empty() {
            for (root, k) in self.roots.iter().zip(0..) {
                self.members.entry(*root).or_default().push(k);
            }
        }
        let positions = &self.sample.positions;
        let members = self.members.get(&piece).map_or(&[][..], Vec::as_slice);
        let tree = self.trees.entry(piece).or_insert_with(|| {
            PointTree::with_metric(members.iter().map(|k| positions[*k as usize]), metric)
        });
        let near = found(tree, positions[i], apart_search(JOINT_SPRINGS), apart);
        near.into_iter().map(|(square, k)| (square, members[k as usize])).collect()
    }
}

/// Squared distances as the tree of all nodes gives them.
fn metric(a: Point, b: Point) -> f64 {
    f64::from(distance_squared(a, b))
}

/// A search for nodes that are not certainly too near.
fn apart_search(count: usize) -> Search<'static> {
    let too_near = f64::from(TOO_NEAR * MIN_REST_LENGTH_M);
    Search { beyond: too_near * too_near, ..Search::nearest(count) }
}

/// The nearest nodes that a search finds and that are wanted. The search is widened while it finds others.
fn found(
    tree: &PointTree,
    at: Point,
    search: Search<'_>,
    wanted: impl Fn(&(f32, u32)) -> bool,
) -> Vec<(f32, u32)> {
    let mut count = search.count;
    loop {
        let near = tree.search(at, &Search { count, ..search });
        let is_all = near.len() < count;
        let all = near.into_iter().map(|near| (near.square as f32, near.number));
        let found: Vec<(f32, u32)> = all.filter(&wanted).collect();
        if is_all || found.len() >= search.count {
            return found;
        }
        count *= 4;
    }
}

/// Far enough away for a spring.
fn apart(found: &(f32, u32)) -> bool {
    found.0.sqrt() > MIN_REST_LENGTH_M
}

/// The `count` nearest, in order; ties by index.
fn nearest_first(mut found: Vec<(f32, u32)>, count: usize) -> Vec<(f32, u32)> {
    let order = |a: &(f32, u32), b: &(f32, u32)| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1));
    if found.len() > count {
        found.select_nth_unstable_by(count, order);
        found.truncate(count);
    }
    found.sort_unstable_by(order);
    found
}
