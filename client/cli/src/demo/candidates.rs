//! Candidate robot actions: the hands carry the object in all directions.

use bendtwin_client::Point;
use bendtwin_core::geometry::add;

/// Distance of the hands' motion [m].
const REACH: f32 = 0.12;
/// Knots of an action: start, halfway, end.
pub(super) const KNOTS: usize = 3;

/// A batch of control trajectories, shape [count, KNOTS, C]. The directions cover the upper half of
/// a sphere evenly (a Fibonacci lattice); each action curves a little.
pub(super) fn candidates(start: &[Point], count: usize) -> Vec<Point> {
    let golden = std::f32::consts::PI * (3.0 - 5f32.sqrt());
    let mut positions = Vec::with_capacity(count * KNOTS * start.len());
    for i in 0..count {
        let z = (i as f32 + 0.5) / count as f32;
        let (radius, angle) = ((1.0 - z * z).sqrt(), golden * i as f32);
        let end = [radius * angle.cos(), radius * angle.sin(), z].map(|d| REACH * d);
        let halfway = [0.5 * end[0] - 0.2 * end[1], 0.5 * end[1] + 0.2 * end[0], 0.6 * end[2]];
        for offset in [[0.0; 3], halfway, end] {
            positions.extend(start.iter().map(|p| add(*p, offset)));
        }
    }
    positions
}

/// Displacement of an action of a batch from its start to its end [m].
pub(super) fn displacement(start: &[Point], batch: &[Point], instance: usize) -> Point {
    let last = (instance * KNOTS + KNOTS - 1) * start.len();
    match (batch.get(last), start.first()) {
        (Some(end), Some(start)) => std::array::from_fn(|i| end[i] - start[i]),
        _ => [0.0; 3],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_candidate_starts_where_the_hands_are_and_reaches_as_far() {
        let start = [[0.0, 0.0, 0.3], [0.2, 0.0, 0.3]];
        let batch = candidates(&start, 10);
        assert_eq!(batch.len(), 10 * KNOTS * 2);
        for i in 0..10 {
            assert_eq!(batch[i * KNOTS * 2..][..2], start);
            let d = displacement(&start, &batch, i);
            let length = d.iter().map(|x| x * x).sum::<f32>().sqrt();
            assert!((length - REACH).abs() < 1e-5 && d[2] > 0.0);
        }
    }
}
