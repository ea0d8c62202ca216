//! Markers along a cable or a rope: in the order of their labels each keeps its distance from the next,
//! in any shape, and others do not.

use super::gaps::Path;

/// Fewest markers of a chain.
const FEWEST: usize = 4;
/// Relative change of the distance between neighbours that stretching and noise explain, and of the
/// distance between the ends of a rigid thing.
const MAX_CHANGE: f64 = 0.12;
const MAX_RIGID_CHANGE: f64 = 0.02;
/// Longest distance between neighbours over the median one: a marker may have fallen off.
const MAX_RATIO: f64 = 2.6;

/// Pairs of neighbours if the paths are those of a chain, else none.
pub(super) fn edges(paths: &[&Path]) -> Vec<[u32; 2]> {
    if paths.len() < FEWEST {
        return Vec::new();
    }
    let mut lengths = Vec::with_capacity(paths.len());
    for pair in paths.windows(2) {
        let [a, b] = pair else { return Vec::new() };
        match steady(a, b, MAX_CHANGE) {
            Some(length) => lengths.push(length),
            None => return Vec::new(),
        }
    }
    let mut sorted = lengths.clone();
    let Some(median) = bendtwin_core::geometry::median(&mut sorted) else { return Vec::new() };
    // Rows of a cloth are near each other, but the end of one is far from the start of the next; on a
    // rigid thing all distances are steady.
    let is_rigid = match (paths.first(), paths.last()) {
        (Some(first), Some(last)) => steady(first, last, MAX_RIGID_CHANGE).is_some(),
        _ => true,
    };
    if is_rigid || lengths.iter().any(|length| *length > MAX_RATIO * median) {
        return Vec::new();
    }
    (1..paths.len() as u32).map(|i| [i - 1, i]).collect()
}

/// The median distance of two markers, if it hardly changes.
fn steady(a: &Path, b: &Path, most_changed: f64) -> Option<f64> {
    let both = a.seen.iter().zip(&b.seen).zip(a.points.iter().zip(&b.points));
    let mut lengths: Vec<f64> = both
        .filter(|((a, b), _)| **a && **b)
        .map(|(_, (p, q))| f64::from(bendtwin_core::geometry::distance(*p, *q)))
        .collect();
    let median = bendtwin_core::geometry::median(&mut lengths)?;
    let mut changes: Vec<f64> = lengths.iter().map(|length| (length - median).abs()).collect();
    changes.sort_by(f64::total_cmp);
    // One marker that was taken for another is no stretch.
    let most = *changes.get((changes.len() * 19 / 20).min(changes.len().checked_sub(1)?))?;
    (median > 0.0 && most <= most_changed * median).then_some(median)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn paths(count: usize, at: impl Fn(usize, f32) -> [f32; 3]) -> Vec<Path> {
        (0..count).map(|i| Path::of((0..40).map(|f| at(i, f as f32 / 40.0)))).collect()
    }

    fn found(paths: &[Path]) -> usize {
        edges(&paths.iter().collect::<Vec<_>>()).len()
    }

    #[test]
    fn a_rope_that_bends_is_a_chain_and_a_bar_is_none() {
        // An arc whose curvature changes.
        let arc = |i: usize, t: f32| {
            let (s, bend) = (0.05 * i as f32, 0.2 + 4.0 * t);
            [(bend * s).sin() / bend, 0.0, (1.0 - (bend * s).cos()) / bend]
        };
        assert_eq!(found(&paths(9, arc)), 8);
        assert_eq!(found(&paths(9, |i, t| [0.05 * i as f32, t, 0.0])), 0, "a rigid bar");
        assert_eq!(found(&paths(3, arc)), 0, "too few");
        // Rows of a cloth.
        let cloth = |i: usize, t: f32| {
            let [x, _, z] = arc(i % 5, t);
            [x, 0.05 * (i / 5) as f32, z]
        };
        assert_eq!(found(&paths(20, cloth)), 0, "a cloth");
    }
}
