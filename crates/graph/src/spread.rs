//! Downsampling that keeps points spread, and how far apart they then are.

use std::num::NonZero;

use bendtwin_core::Point;
use kiddo::{ImmutableKdTree, SquaredEuclidean};

/// Neighbour whose distance counts as spacing. The nearest one alone depends more on the regularity
/// of a pattern than on its density: points from farthest-point sampling have no close pairs,
/// scattered points have many.
const SPACING_NEIGHBOUR: usize = 6;

/// Adds `count` of `candidates` to `chosen` by farthest-point sampling: each
/// is the candidate farthest from all that were chosen before, ties by index.
/// Starts at candidate `start` if nothing was chosen yet. Stops early where
/// all candidates left coincide with chosen points. O(count · candidates).
pub fn farthest_points(
    points: &[Point],
    candidates: &[usize],
    chosen: &mut Vec<usize>,
    count: usize,
    start: usize,
) {
    let mut distance = vec![f32::INFINITY; candidates.len()];
    for &c in chosen.iter() {
        approach(points, candidates, &mut distance, c);
    }
    let mut next = if chosen.is_empty() {
        (start < candidates.len()).then_some(start)
    } else {
        farthest(&distance)
    };
    for _ in 0..count {
        let Some(n) = next else { return };
        chosen.push(candidates[n]);
        approach(points, candidates, &mut distance, candidates[n]);
        next = farthest(&distance);
    }
}

fn approach(points: &[Point], candidates: &[usize], distance: &mut [f32], chosen: usize) {
    for (d, &c) in distance.iter_mut().zip(candidates) {
        *d = d.min(distance_squared(points[c], points[chosen]));
    }
}

fn farthest(distance: &[f32]) -> Option<usize> {
    let mut best = (0.0, None);
    for (i, &d) in distance.iter().enumerate() {
        if d > best.0 {
            best = (d, Some(i));
        }
    }
    best.1
}

/// Most points whose neighbours are searched for the mean spacing.
const MAX_MEASURED: usize = 100_000;

/// Mean distance of a point to its sixth neighbour (to its last one where
/// there are fewer) [m]; 0 for fewer than two points. Of very many points, that of some, evenly taken.
pub fn mean_spacing(points: &[Point]) -> f64 {
    let Some(wanted) = NonZero::new(SPACING_NEIGHBOUR.min(points.len().saturating_sub(1)) + 1)
    else {
        return 0.0;
    };
    let Some(tree) = tree(points) else { return 0.0 };
    let measured = points.iter().step_by(points.len().div_ceil(MAX_MEASURED));
    let count = measured.len();
    let sum: f64 = measured
        .map(|p| {
            let found = tree.query(p).nearest_n::<SquaredEuclidean<f32>>(wanted).execute();
            found.last().map_or(0.0, |n| f64::from(n.distance).sqrt())
        })
        .sum();
    sum / count as f64
}

/// A KD-tree over `points`; none where there are no points.
pub(super) fn tree(points: &[Point]) -> Option<ImmutableKdTree<f32, 3>> {
    if points.is_empty() {
        return None;
    }
    ImmutableKdTree::new_from_slice(points).ok()
}

pub(super) fn distance_squared(a: Point, b: Point) -> f32 {
    let d = [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
    d[0] * d[0] + d[1] * d[1] + d[2] * d[2]
}
