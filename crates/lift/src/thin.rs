//! Keeping points apart: those that come first stay.

use bendtwin_core::Point;

use crate::{grid::Grid, tracks::Tracks};

/// The `candidates` that keep `spacing_m` from each other and from the points of `grid`, to which
/// they are added. Earlier ones take precedence.
pub(crate) fn spread(
    grid: &mut Grid,
    candidates: impl IntoIterator<Item = (usize, Point)>,
    spacing_m: f64,
) -> Vec<usize> {
    let mut kept = Vec::new();
    for (index, point) in candidates {
        if spacing_m <= 0.0 || !grid.any_within(point, spacing_m) {
            grid.insert(index, point);
            kept.push(index);
        }
    }
    kept
}

/// Keeps a track for each spot of the first frame, by highest priority. Returns them in the order
/// of the tracks.
pub(crate) fn one_per_spot(tracks: &Tracks, priority: &[usize], spacing_m: f64) -> Vec<usize> {
    let mut order: Vec<usize> = (0..tracks.count).collect();
    order.sort_by_key(|i| (std::cmp::Reverse(priority[*i]), *i));
    let candidates = order.into_iter().map(|i| (i, tracks.at(0, i)));
    let mut kept = spread(&mut Grid::new(spacing_m), candidates, spacing_m);
    kept.sort_unstable();
    kept
}

/// Indices of `count` points, each the farthest from those before; the first is the farthest from
/// the middle.
pub(crate) fn farthest_first(points: &[Point], count: usize) -> Vec<usize> {
    if points.is_empty() || count == 0 {
        return Vec::new();
    }
    let middle: [f64; 3] = std::array::from_fn(|i| {
        points.iter().map(|p| f64::from(p[i])).sum::<f64>() / points.len() as f64
    });
    let middle = middle.map(|x| x as f32);
    let mut chosen = Vec::new();
    let mut distance = vec![f64::INFINITY; points.len()];
    let mut next = farthest(points.iter().map(|p| crate::rigid::distance(*p, middle)));
    while chosen.len() < count.min(points.len()) {
        chosen.push(next);
        for (d, p) in distance.iter_mut().zip(points) {
            *d = d.min(crate::rigid::distance(*p, points[next]));
        }
        distance[next] = -1.0;
        next = farthest(distance.iter().copied());
    }
    chosen
}

/// Index of the largest, the first of equals.
fn farthest(distances: impl Iterator<Item = f64>) -> usize {
    let best = distances
        .enumerate()
        .fold((0, f64::NEG_INFINITY), |best, (i, d)| if d > best.1 { (i, d) } else { best });
    best.0
}

#[cfg(test)]
mod tests;
