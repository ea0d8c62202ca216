//! Springs between nodes, and between control points and nodes.

use std::num::NonZero;

use bendtwin_core::{Graph, NodeKind, Point};
use kiddo::{ImmutableKdTree, SquaredEuclidean};

use super::{
    Connectivity, LeftOut, MIN_REST_LENGTH_M, NodeSample, SurfacePoints, components, rods, spread,
    triplets,
};

/// Control points nearer than this to each other belong to one hand [m].
const HAND_LINK_M: f32 = 0.08;
/// Number of nodes that a hand reaches at least, and that a control point is attached to if its hand
/// does not.
const FALLBACK_NODES: usize = 4;
/// Distance from such a hand within which control points are attached, as a multiple of the nearest
/// one's.
const FALLBACK_REACH: f32 = 1.5;

/// Changes beyond what a [`Connectivity`] asks for; worth a warning to the user.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Notes {
    /// Hands that had too few nodes within the control radius and were attached
    /// to the nodes nearest to them.
    pub hands_out_of_reach: usize,
    /// Pieces without any spring to the rest of the object that were joined to
    /// the piece nearest to them.
    pub pieces_joined: usize,
}

impl std::fmt::Display for Notes {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let mut parts = Vec::new();
        match self.hands_out_of_reach {
            0 => {}
            1 => parts.push(
                "a hand reaches fewer than four nodes within the control radius and holds those nearest to it"
                    .to_owned(),
            ),
            n => parts.push(format!(
                "{n} hands reach fewer than four nodes within the control radius and hold those nearest to them"
            )),
        }
        if self.pieces_joined > 0 {
            parts.push(format!(
                "{} loose pieces were joined to the nearest part of the object: raise the radius if they should hold more firmly",
                self.pieces_joined
            ));
        }
        f.write_str(&parts.join("; "))
    }
}

/// Joins nodes by springs and triplets; see [`connect_with_notes`].
pub fn connect(sample: &NodeSample, connectivity: &Connectivity) -> Graph {
    connect_with_notes(sample, connectivity).0
}

/// Joins nodes by springs and triplets.
///
/// - Every node opens a spring to its up to `max_neighbours` nearest nodes
///   within `radius_m · spacing_scale`; a pair has one spring, longer than
///   [`MIN_REST_LENGTH_M`]. Nodes of different objects are never joined.
/// - Pieces that then do not hang together are joined where they are closest.
///   Known edges replace both steps: a cable's topology is taken as given.
/// - Every control point that pins no node opens springs to its up to
///   `control_neighbours` nearest nodes within `control_radius_m`, or within the
///   spacing of the nodes if that is more: a hand holds what it touches, and nodes
///   that are farther apart stand for what lies between them.
///   Control points closer than 8 cm to each other are one hand; a hand that
///   reaches fewer than four nodes is attached to the nodes nearest to it.
/// - With `rods`, what lies between two clamps of a cable with known edges is a rod.
/// - Springs between nodes come first, ordered by their ends, control springs after.
pub fn connect_with_notes(sample: &NodeSample, connectivity: &Connectivity) -> (Graph, Notes) {
    let mut notes = Notes::default();
    let tree = spread::tree(&sample.positions);
    let mut springs = match (&sample.edges, &tree) {
        (Some(edges), _) => edges.iter().map(|&[a, b]| [a.min(b), a.max(b)]).collect(),
        (None, Some(tree)) => node_springs(sample, connectivity, tree),
        (None, None) => Vec::new(),
    };
    tidy(&mut springs);
    if let (None, Some(tree)) = (&sample.edges, &tree) {
        notes.pieces_joined = components::join(sample, tree, &mut springs);
        tidy(&mut springs);
    }
    let mut graph = Graph {
        rest_positions: sample.positions.clone(),
        kinds: sample.kinds.clone(),
        masses: masses(sample),
        object_ids: sample.object_ids.clone(),
        observed_points: sample.observed_points.clone(),
        control_rest: sample.control_rest.clone(),
        springs,
        triplets: Vec::new(),
        pins: sample.pins.clone(),
        rods: if connectivity.rods { rods::find(sample) } else { Vec::new() },
    };
    if let Some(choice) = &connectivity.triplets {
        graph.triplets = triplets::find(sample, &graph.springs, choice);
    }
    if let Some(tree) = &tree {
        let (springs, attached) = held(sample, connectivity, tree);
        notes.hands_out_of_reach = attached;
        graph.springs.extend(springs);
    }
    (graph, notes)
}

/// Springs by which control points hold nodes that are at `nodes` [m], by the rules of
/// [`connect_with_notes`]; control point `c` is endpoint `nodes.len() + c`.
pub fn hold(nodes: &[Point], controls: &[Point], connectivity: &Connectivity) -> Vec<[u32; 2]> {
    let Some(tree) = spread::tree(nodes) else { return Vec::new() };
    let sample = NodeSample {
        positions: nodes.to_vec(),
        kinds: vec![NodeKind::Observed; nodes.len()],
        observed_points: vec![Graph::NOT_OBSERVED; nodes.len()],
        object_ids: vec![0; nodes.len()],
        control_rest: controls.to_vec(),
        pins: Vec::new(),
        edges: None,
        rest_shape: None,
        point_spacing_m: spread::mean_spacing(nodes),
        spacing_scale: 1.0,
        surface: SurfacePoints::default(),
        left_out: LeftOut::default(),
    };
    held(&sample, connectivity, &tree).0
}

/// Springs of the control points, and the number of hands that were attached to the nodes nearest to
/// them.
fn held(
    sample: &NodeSample,
    connectivity: &Connectivity,
    tree: &ImmutableKdTree<f32, 3>,
) -> (Vec<[u32; 2]>, usize) {
    let mut springs = control_springs(sample, connectivity, tree);
    let attached = attach_hands(sample, connectivity, tree, &mut springs);
    tidy(&mut springs);
    (springs, attached)
}

/// Masses of the nodes. Of a cable each stands for half of the edges that end in it, and those that
/// are free weigh one on average; anything else is sampled evenly.
fn masses(sample: &NodeSample) -> Vec<f32> {
    let n = sample.node_count();
    let Some(edges) = &sample.edges else { return vec![1.0; n] };
    let points = sample.undeformed();
    let mut lengths = vec![0.0; n];
    for ends in edges.iter().map(|edge| edge.map(|e| e as usize)) {
        let [a, b] = ends.map(|e| points[e]);
        let square: f64 = a.iter().zip(b).map(|(x, y)| f64::from(x - y).powi(2)).sum();
        ends.iter().for_each(|&e| lengths[e] += 0.5 * square.sqrt());
    }
    let mut is_free = vec![true; n];
    sample.pins.iter().for_each(|p| is_free[p.node as usize] = false);
    let free = || lengths.iter().zip(&is_free).filter(|(_, free)| **free).map(|(length, _)| length);
    let mean = free().sum::<f64>() / free().count() as f64;
    // A node without edges still has a mass.
    let mass = |&l: &f64| if l > 0.0 && mean > 0.0 { (l / mean) as f32 } else { 1.0 };
    lengths.iter().map(mass).collect()
}

fn tidy<T: Ord>(list: &mut Vec<T>) {
    list.sort_unstable();
    list.dedup();
}

fn node_springs(
    sample: &NodeSample,
    connectivity: &Connectivity,
    tree: &ImmutableKdTree<f32, 3>,
) -> Vec<[u32; 2]> {
    let radius = (connectivity.radius_m * sample.spacing_scale) as f32;
    // One more than asked for: a node is its own nearest neighbour.
    let wanted = connectivity.max_neighbours.min(sample.node_count());
    let Some(wanted) = NonZero::new(wanted + 1) else { return Vec::new() };
    let mut springs = Vec::with_capacity(sample.node_count() * wanted.get() / 2);
    for (i, p) in sample.positions.iter().enumerate() {
        let found = tree
            .query(p)
            .nearest_n::<SquaredEuclidean<f32>>(wanted)
            .within(radius * radius)
            .execute();
        let i = i as u32;
        let others = found.iter().filter(|n| n.item != i).take(connectivity.max_neighbours);
        springs.extend(
            others
                .filter(|n| n.distance.sqrt() > MIN_REST_LENGTH_M)
                .filter(|n| sample.object_ids[i as usize] == sample.object_ids[n.item as usize])
                .map(|n| [i.min(n.item), i.max(n.item)]),
        );
    }
    springs
}

/// Control points that hold by springs: those that pin no node.
fn free_controls(sample: &NodeSample) -> Vec<usize> {
    let mut pins = vec![false; sample.control_rest.len()];
    for p in &sample.pins {
        pins[p.control as usize] = true;
    }
    (0..pins.len()).filter(|&c| !pins[c]).collect()
}

fn control_springs(
    sample: &NodeSample,
    connectivity: &Connectivity,
    tree: &ImmutableKdTree<f32, 3>,
) -> Vec<[u32; 2]> {
    let radius = connectivity.control_radius_m.max(node_spacing(sample)) as f32;
    let mut springs = Vec::new();
    for c in free_controls(sample) {
        springs.extend(nearest_nodes(sample, tree, c, connectivity.control_neighbours, radius));
    }
    springs
}

/// Mean spacing of the nodes [m].
fn node_spacing(sample: &NodeSample) -> f64 {
    sample.point_spacing_m * sample.spacing_scale
}

/// Springs from the up to `count` nodes within `radius` to a control point.
fn nearest_nodes(
    sample: &NodeSample,
    tree: &ImmutableKdTree<f32, 3>,
    control: usize,
    count: usize,
    radius: f32,
) -> Vec<[u32; 2]> {
    let n = sample.node_count();
    let Some(count) = NonZero::new(count.min(n)) else { return Vec::new() };
    tree.query(&sample.control_rest[control])
        .nearest_n::<SquaredEuclidean<f32>>(count)
        .within(radius * radius)
        .execute()
        .iter()
        .filter(|found| found.distance.sqrt() > MIN_REST_LENGTH_M)
        .map(|found| [found.item, (n + control) as u32])
        .collect()
}

/// Attaches every hand that holds too few nodes to the nodes nearest to it; returns how many those
/// were.
fn attach_hands(
    sample: &NodeSample,
    connectivity: &Connectivity,
    tree: &ImmutableKdTree<f32, 3>,
    springs: &mut Vec<[u32; 2]>,
) -> usize {
    if connectivity.control_neighbours == 0 {
        return 0;
    }
    let n = sample.node_count();
    let mut attached = 0;
    for hand in hands(&sample.control_rest, free_controls(sample)) {
        let mut held: Vec<u32> =
            springs.iter().filter(|s| hand.contains(&(s[1] as usize - n))).map(|s| s[0]).collect();
        tidy(&mut held);
        if held.len() >= FALLBACK_NODES.min(n) {
            continue;
        }
        let reach = |c: usize| {
            let found = tree
                .query(&sample.control_rest[c])
                .nearest_one::<SquaredEuclidean<f32>>()
                .execute();
            found.distance.sqrt()
        };
        let reaches: Vec<f32> = hand.iter().map(|&c| reach(c)).collect();
        let nearest = reaches.iter().copied().fold(f32::INFINITY, f32::min);
        for (&c, _) in hand.iter().zip(&reaches).filter(|(_, r)| **r <= FALLBACK_REACH * nearest) {
            let count = FALLBACK_NODES.min(connectivity.control_neighbours);
            springs.extend(nearest_nodes(sample, tree, c, count, f32::MAX.sqrt()));
        }
        attached += 1;
    }
    attached
}

/// Control points by hand: those of `left` that are linked by steps of at most [`HAND_LINK_M`].
fn hands(controls: &[Point], mut left: Vec<usize>) -> Vec<Vec<usize>> {
    let mut hands = Vec::new();
    while let Some(first) = left.first().copied() {
        left.remove(0);
        let mut hand = vec![first];
        let mut next = 0;
        while next < hand.len() {
            let at = controls[hand[next]];
            let link = HAND_LINK_M * HAND_LINK_M;
            let is_linked = |c: &usize| spread::distance_squared(at, controls[*c]) <= link;
            let (linked, rest) = left.iter().copied().partition(is_linked);
            left = rest;
            hand.extend::<Vec<usize>>(linked);
            next += 1;
        }
        hands.push(hand);
    }
    hands
}

/// The hand of each control point, from 0: points closer than 8 cm to each other are one hand's.
pub fn hand_of_each(controls: &[Point]) -> Vec<usize> {
    let mut of = vec![0; controls.len()];
    for (number, hand) in hands(controls, (0..controls.len()).collect()).iter().enumerate() {
        hand.iter().for_each(|&c| of[c] = number);
    }
    of
}
