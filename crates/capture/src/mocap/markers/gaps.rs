//! Gaps of markers: frames in which cameras did not see them.

use bendtwin_core::Point;

/// A marker's path without gaps, where it was seen, and its longest gap.
#[derive(Clone, Debug)]
pub(super) struct Path {
    /// Positions, shape [T]: in gaps on a straight line, before the first and after the last sight as
    /// there. NaN throughout if it was never seen.
    pub(super) points: Vec<Point>,
    /// Shape [T].
    pub(super) seen: Vec<bool>,
    /// Length of the longest gap [frames].
    pub(super) longest_gap: usize,
}

impl Path {
    pub(super) fn of(points: impl Iterator<Item = Point>) -> Self {
        let mut points: Vec<Point> = points.collect();
        let seen: Vec<bool> = points.iter().map(|p| p.iter().all(|x| x.is_finite())).collect();
        let mut longest_gap = 0;
        let mut before: Option<usize> = None;
        for frame in 0..=points.len() {
            let is_end = frame == points.len();
            if !is_end && !seen[frame] {
                continue;
            }
            let start = before.map_or(0, |b| b + 1);
            longest_gap = longest_gap.max(frame - start);
            let from = before.map(|b| points[b]);
            let to = (!is_end).then(|| points[frame]);
            for (index, inside) in points[start..frame].iter_mut().enumerate() {
                let share = (index + 1) as f32 / (frame + 1 - start) as f32;
                *inside = match (from, to) {
                    (Some(a), Some(b)) => std::array::from_fn(|i| a[i] + share * (b[i] - a[i])),
                    (Some(one), None) | (None, Some(one)) => one,
                    (None, None) => [f32::NAN; 3],
                };
            }
            before = Some(frame);
        }
        Self { points, seen, longest_gap }
    }

    /// Frames in which it was seen.
    pub(super) fn seen_count(&self) -> usize {
        self.seen.iter().filter(|seen| **seen).count()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn path(xs: &[f32]) -> (Vec<f32>, usize) {
        let path = Path::of(xs.iter().map(|x| [*x, 0.0, 0.0]));
        (path.points.iter().map(|p| p[0]).collect(), path.longest_gap)
    }

    #[test]
    fn gaps_are_straight_and_ends_stand_still() {
        let nan = f32::NAN;
        assert_eq!(path(&[1.0, 2.0]), (vec![1.0, 2.0], 0));
        assert_eq!(path(&[nan, 1.0, nan, nan, 4.0, nan]), (vec![1.0, 1.0, 2.0, 3.0, 4.0, 4.0], 2));
        let (never, gap) = path(&[nan; 3]);
        assert!(never.iter().all(|x| x.is_nan()) && gap == 3);
        assert_eq!(path(&[]), (Vec::new(), 0));
    }
}
