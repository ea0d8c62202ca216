//! Bending triplets: O(valence) pairs of surface neighbours per centre.

use bendtwin_core::{Point, settings::TripletReference};

use super::{NodeSample, Triplets};

/// Nearest neighbours of a centre that are considered: pairs grow with their square.
const MAX_ARMS: usize = 16;
/// Up to this degree, a branch of a cable bends between all pairs of its edges.
const MAX_BRANCH_DEGREE: usize = 8;

/// A neighbour of a centre.
#[derive(Clone, Copy)]
struct Arm {
    node: u32,
    length: f32,
    /// Unit vector towards it; zero if it coincides with the centre.
    direction: Point,
}

/// Cosine of the angle between two arms: all that ordering by angle needs.
fn cosine(a: Point, b: Point) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Triplets (i, j, k) over the springs between surface nodes, ordered by centre.
/// Each pair of arms comes once, with i < k unless i is the reference arm.
pub(super) fn find(sample: &NodeSample, springs: &[[u32; 2]], choice: &Triplets) -> Vec<[u32; 3]> {
    let points = sample.undeformed();
    let mut arms: Vec<Vec<Arm>> = vec![Vec::new(); points.len()];
    let is_surface = |i: u32| sample.kinds[i as usize].is_surface();
    for &[a, b] in springs.iter().filter(|s| is_surface(s[0]) && is_surface(s[1])) {
        for [centre, node] in [[a, b], [b, a]] {
            let (x, y) = (points[centre as usize], points[node as usize]);
            let offset = [y[0] - x[0], y[1] - x[1], y[2] - x[2]];
            let length = offset.iter().map(|d| d * d).sum::<f32>().sqrt();
            let direction = offset.map(|d| if length > 0.0 { d / length } else { 0.0 });
            arms[centre as usize].push(Arm { node, length, direction });
        }
    }
    let mut triplets = Vec::new();
    for (j, arms) in arms.iter_mut().enumerate() {
        arms.sort_unstable_by(|a, b| a.length.total_cmp(&b.length).then(a.node.cmp(&b.node)));
        let pairs = if sample.edges.is_some() && arms.len() <= MAX_BRANCH_DEGREE {
            all_pairs(arms)
        } else {
            let near = &arms[..arms.len().min(MAX_ARMS)];
            match choice.reference {
                TripletReference::Nearest => from_reference(near, Some(0), choice.max_per_node),
                // The farthest of all, not of the nearest ones.
                TripletReference::Farthest => {
                    let kept: Vec<Arm> = match arms.split_last() {
                        Some((last, rest)) => {
                            rest.iter().take(MAX_ARMS - 1).chain([last]).copied().collect()
                        }
                        None => Vec::new(),
                    };
                    from_reference(&kept, kept.len().checked_sub(1), choice.max_per_node)
                }
                TripletReference::MostOpposite => {
                    from_reference(near, most_opposite(near), choice.max_per_node)
                }
                TripletReference::OppositePairs => opposite_pairs(near, choice.max_per_node),
            }
        };
        triplets.extend(pairs.into_iter().map(|[i, k]| [i, j as u32, k]));
    }
    triplets
}

fn ordered(a: Arm, b: Arm) -> [u32; 2] {
    [a.node.min(b.node), a.node.max(b.node)]
}

fn all_pairs(arms: &[Arm]) -> Vec<[u32; 2]> {
    let rest = |i: usize| arms.iter().skip(i + 1);
    let pairs = arms.iter().enumerate().flat_map(|(i, a)| rest(i).map(|b| ordered(*a, *b)));
    pairs.collect()
}

/// The reference arm with each other one, the straightest pairs first.
fn from_reference(arms: &[Arm], reference: Option<usize>, most: usize) -> Vec<[u32; 2]> {
    let Some(r) = reference else { return Vec::new() };
    let mut others: Vec<(f32, u32)> = (0..arms.len())
        .filter(|&k| k != r)
        .map(|k| (cosine(arms[r].direction, arms[k].direction), arms[k].node))
        .collect();
    others.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    others.into_iter().take(most).map(|(_, k)| [arms[r].node, k]).collect()
}

/// The arm with the widest angle to the mean direction of the others.
fn most_opposite(arms: &[Arm]) -> Option<usize> {
    let sum = arms.iter().fold([0.0; 3], |s: Point, a| {
        [s[0] + a.direction[0], s[1] + a.direction[1], s[2] + a.direction[2]]
    });
    let mut best = (f32::INFINITY, None);
    for (r, arm) in arms.iter().enumerate() {
        let d = arm.direction;
        let others = [sum[0] - d[0], sum[1] - d[1], sum[2] - d[2]];
        let length = cosine(others, others).sqrt().max(f32::MIN_POSITIVE);
        let straight = cosine(d, others) / length;
        if straight < best.0 {
            best = (straight, Some(r));
        }
    }
    best.1
}

/// The straightest pairs, no arm twice, none below a right angle except that
/// a centre with two arms or more has at least one pair.
fn opposite_pairs(arms: &[Arm], most: usize) -> Vec<[u32; 2]> {
    let mut candidates = Vec::with_capacity(arms.len() * arms.len() / 2);
    for (i, a) in arms.iter().enumerate() {
        for (k, b) in arms.iter().enumerate().skip(i + 1) {
            candidates.push((cosine(a.direction, b.direction), i, k));
        }
    }
    candidates.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then((a.1, a.2).cmp(&(b.1, b.2))));
    let mut used = vec![false; arms.len()];
    let mut pairs = Vec::new();
    for (cosine, i, k) in candidates {
        if pairs.len() == most || (cosine >= 0.0 && !pairs.is_empty()) {
            break;
        }
        if !used[i] && !used[k] {
            used[i] = true;
            used[k] = true;
            pairs.push(ordered(arms[i], arms[k]));
        }
    }
    pairs
}
