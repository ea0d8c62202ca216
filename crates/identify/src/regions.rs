//! Regions of an object: its nodes cut into parts of about equal extent, named by where they are.

use bendtwin_core::{
    Point, Twin,
    geometry::{Vector, distance, point_distance, scaled, sub, wide},
    identifiability::{MOST_REGIONS, Region},
};

/// Nodes of a region, at least, on average.
const NODES_PER_REGION: usize = 8;
/// Fewest and most regions of a report.
const FEWEST: usize = 2;
const MOST: usize = 8;
const _: () = assert!(MOST <= MOST_REGIONS);
/// A place is between two hands if the way over it is longer than the straight one by less than this.
const DETOUR: f64 = 1.3;
/// Rounds of k-means after the choice of the first centres.
const ROUNDS: usize = 10;

/// Parts that a twin's nodes are cut into.
#[derive(Clone, Debug, PartialEq)]
pub struct Regions {
    /// Region of each node, shape [N].
    pub of_nodes: Vec<u8>,
    /// The regions by their distance from the hands.
    pub parts: Vec<Region>,
    /// The region farthest from all hands.
    pub far: usize,
}

impl Regions {
    /// Cuts a twin's nodes: centres far from each other, moved to the middle of their nodes (k-means).
    pub fn of(twin: &Twin) -> Self {
        let nodes = &twin.graph.rest_positions;
        let wanted = (nodes.len() / NODES_PER_REGION).clamp(FEWEST, MOST).min(nodes.len().max(1));
        let hands = hand_centres(twin);
        let mut centres = far_apart(nodes, &hands, wanted);
        let mut of_nodes = nearest(nodes, &centres);
        for _ in 0..ROUNDS {
            for (region, centre) in centres.iter_mut().enumerate() {
                *centre = middle(nodes, &of_nodes, region).unwrap_or(*centre);
            }
            let moved = nearest(nodes, &centres);
            if moved == of_nodes {
                break;
            }
            of_nodes = moved;
        }
        Self::sorted(&centres, &of_nodes, &hands)
    }

    /// Regions in order of their distance from the hands, without empty ones.
    fn sorted(centres: &[Vector], of_nodes: &[usize], hands: &[Vector]) -> Self {
        let count = |region: usize| of_nodes.iter().filter(|r| **r == region).count();
        let mut order: Vec<usize> = (0..centres.len()).filter(|&r| count(r) > 0).collect();
        let reach = |r: usize| nearest_hand(centres[r], hands).map_or(0.0, |(_, d)| d);
        order.sort_by(|&a, &b| reach(a).total_cmp(&reach(b)));
        let place = |r: usize| order.iter().position(|o| *o == r).unwrap_or_default() as u8;
        let sorted: Vec<Vector> = order.iter().map(|&r| centres[r]).collect();
        let names = names(&sorted, hands);
        let part = |((&r, centre), name): ((&usize, &Vector), String)| Region {
            name,
            center: *centre,
            nodes: count(r) as u32,
        };
        Self {
            of_nodes: of_nodes.iter().map(|&r| place(r)).collect(),
            far: order.len().saturating_sub(1),
            parts: order.iter().zip(&sorted).zip(names).map(part).collect(),
        }
    }

    /// Nodes of a region that a hand or a gripper would take hold of: the quarter, at least three, that
    /// is nearest to where the region is farthest from the hands.
    pub(crate) fn handful(&self, twin: &Twin, region: usize) -> Vec<u32> {
        let nodes = &twin.graph.rest_positions;
        let hands = hand_centres(twin);
        let center = self.parts.get(region).map_or([0.0; 3], |p| p.center);
        let mut own: Vec<u32> = (0..nodes.len() as u32)
            .filter(|&i| usize::from(self.of_nodes[i as usize]) == region)
            .collect();
        let reach = |i: u32| {
            let at = wide(nodes[i as usize]);
            nearest_hand(at, &hands).map_or_else(|| -distance(at, center), |(_, d)| d)
        };
        let tip = own.iter().copied().max_by(|a, b| reach(*a).total_cmp(&reach(*b)));
        let Some(tip) = tip.map(|i| nodes[i as usize]) else { return own };
        let apart = |i: &u32| point_distance(nodes[*i as usize], tip);
        own.sort_by(|a, b| apart(a).total_cmp(&apart(b)));
        own.truncate((own.len() / 4).max(3));
        own.sort_unstable();
        own
    }
}

/// Centres of the control points of each hand at rest [m].
pub(crate) fn hand_centres(twin: &Twin) -> Vec<Vector> {
    let hands = twin.hands();
    let count = hands.iter().max().map_or(0, |h| *h as usize + 1);
    let of = |hand: usize| {
        let points = hands.iter().zip(&twin.graph.control_rest);
        let own: Vec<Vector> =
            points.filter(|(h, _)| **h as usize == hand).map(|(_, p)| wide(*p)).collect();
        mean(&own)
    };
    (0..count).filter_map(of).collect()
}

/// The nearest hand to a place and its distance [m].
fn nearest_hand(at: Vector, hands: &[Vector]) -> Option<(usize, f64)> {
    let distances = hands.iter().map(|h| distance(at, *h)).enumerate();
    distances.min_by(|a, b| a.1.total_cmp(&b.1))
}

fn mean(points: &[Vector]) -> Option<Vector> {
    let sum = points.iter().fold([0.0; 3], |s, p| std::array::from_fn(|a| s[a] + p[a]));
    (!points.is_empty()).then(|| scaled(sum, 1.0 / points.len() as f64))
}

/// Places far apart: the node nearest to a hand, then always the one farthest from those chosen.
fn far_apart(nodes: &[Point], hands: &[Vector], count: usize) -> Vec<Vector> {
    let nodes: Vec<Vector> = nodes.iter().map(|p| wide(*p)).collect();
    let Some(start) = hands.first().copied().or_else(|| mean(&nodes)) else { return Vec::new() };
    let first = nodes.iter().min_by(|a, b| distance(**a, start).total_cmp(&distance(**b, start)));
    let mut chosen: Vec<Vector> = first.copied().into_iter().collect();
    while chosen.len() < count {
        let reach =
            |p: &Vector| chosen.iter().map(|c| distance(*p, *c)).fold(f64::INFINITY, f64::min);
        let Some(next) = nodes.iter().max_by(|a, b| reach(a).total_cmp(&reach(b))) else { break };
        chosen.push(*next);
    }
    chosen
}

/// The nearest centre of each node; of equally near ones the first.
fn nearest(nodes: &[Point], centres: &[Vector]) -> Vec<usize> {
    let of = |p: &Point| {
        let apart = centres.iter().map(|c| distance(wide(*p), *c)).enumerate();
        apart.min_by(|a, b| a.1.total_cmp(&b.1)).map_or(0, |(region, _)| region)
    };
    nodes.iter().map(of).collect()
}

/// Mean of the nodes of a region; none without nodes.
fn middle(nodes: &[Point], of_nodes: &[usize], region: usize) -> Option<Vector> {
    let own = nodes.iter().zip(of_nodes).filter(|(_, r)| **r == region);
    mean(&own.map(|(p, _)| wide(*p)).collect::<Vec<_>>())
}

/// Names of regions that are sorted by their distance from the hands; none twice.
fn names(centres: &[Vector], hands: &[Vector]) -> Vec<String> {
    let whole = mean(centres).unwrap_or_default();
    let last = centres.len().saturating_sub(1);
    let mut taken = vec![false; hands.len()];
    let mut names: Vec<String> = Vec::with_capacity(centres.len());
    for (index, centre) in centres.iter().enumerate() {
        let name = match nearest_hand(*centre, hands) {
            Some((hand, _)) if !std::mem::replace(&mut taken[hand], true) => match hands.len() {
                1 => "near the hand".to_owned(),
                _ => format!("near hand {}", hand + 1),
            },
            Some(_) if index == last => match is_between(*centre, hands) {
                true => "between the hands".to_owned(),
                false => "free end".to_owned(),
            },
            Some((hand, apart)) => {
                let of = if hands.len() == 1 { String::new() } else { format!(" {}", hand + 1) };
                let the = if hands.len() == 1 { "the " } else { "" };
                format!("{:.0} cm from {the}hand{of}, {}", 100.0 * apart, side(*centre, whole))
            }
            None => side(*centre, whole),
        };
        let same = names.iter().filter(|n| **n == name).count();
        let repeated = names.iter().filter(|n| n.starts_with(&format!("{name} ("))).count();
        names.push(match same + repeated {
            0 => name,
            before => format!("{name} ({})", before + 1),
        });
    }
    names
}

/// True if a place is about on the way from one hand to another.
fn is_between(at: Vector, hands: &[Vector]) -> bool {
    let pairs = hands.iter().enumerate().flat_map(|(i, a)| hands[..i].iter().map(move |b| (a, b)));
    let mut detours =
        pairs.map(|(a, b)| (distance(at, *a) + distance(at, *b), DETOUR * distance(*a, *b)));
    detours.any(|(way, most)| way < most)
}

/// The side of the object that a place is on, by the axis along which it is farthest from the middle.
fn side(at: Vector, middle: Vector) -> String {
    let [x, y, z] = sub(at, middle);
    let (axis, by) = [("x", x), ("y", y), ("z", z)]
        .into_iter()
        .max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()))
        .unwrap_or(("x", 0.0));
    match axis {
        "z" if by > 0.0 => "upper side".to_owned(),
        "z" => "lower side".to_owned(),
        _ if by > 0.0 => format!("towards +{axis}"),
        _ => format!("towards -{axis}"),
    }
}

#[cfg(test)]
mod tests;
