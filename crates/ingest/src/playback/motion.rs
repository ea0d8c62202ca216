//! Points and control points of a sequence as 16-bit numbers.

use bendtwin_core::{Point, Sequence};

/// Number in place of each coordinate of an unknown point.
pub(super) const UNKNOWN: i16 = i16::MIN;

/// Indices of at most `most` of `count` points, evenly taken.
pub(super) fn thinned(count: usize, most: usize) -> Vec<usize> {
    let kept = count.min(most);
    (0..kept).map(|i| i * count / kept).collect()
}

/// Bytes that a sequence takes of which at most `most` points and control points are kept, with
/// their colours.
pub(super) fn bytes(sequence: &Sequence, point_count: usize, most: usize) -> usize {
    let points = point_count.min(most);
    let frame = 6 * points + points.div_ceil(8) + 6 * sequence.control_count().min(most);
    frame.saturating_mul(sequence.frame_count).saturating_add(3 * points)
}

/// The cube that positions are numbered in.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Grid {
    /// Centre [m].
    pub(super) origin: [f64; 3],
    /// Length of a step [m].
    pub(super) scale_m: f64,
}

impl Grid {
    /// The smallest one around all of these that are known.
    pub(super) fn around<'a>(points: impl Iterator<Item = &'a Point>) -> Self {
        let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
        for point in points.filter(|p| p.iter().all(|x| x.is_finite())) {
            for axis in 0..3 {
                low[axis] = low[axis].min(f64::from(point[axis]));
                high[axis] = high[axis].max(f64::from(point[axis]));
            }
        }
        if low[0] > high[0] {
            (low, high) = ([0.0; 3], [0.0; 3]);
        }
        let half = (0..3).map(|a| (high[a] - low[a]) / 2.0).fold(0.0, f64::max);
        Self {
            origin: std::array::from_fn(|a| (low[a] + high[a]) / 2.0),
            // Points all in one place have a step, too.
            scale_m: (half / f64::from(i16::MAX)).max(1e-9),
        }
    }

    fn number(&self, point: &Point) -> [i16; 3] {
        if !point.iter().all(|x| x.is_finite()) {
            return [UNKNOWN; 3];
        }
        std::array::from_fn(|a| {
            let steps = ((f64::from(point[a]) - self.origin[a]) / self.scale_m).round();
            steps.clamp(f64::from(-i16::MAX), f64::from(i16::MAX)) as i16
        })
    }

    /// The kept ones of `rows` rows of points as little-endian numbers.
    pub(super) fn numbers(&self, points: &[Point], rows: usize, kept: &[usize]) -> Vec<u8> {
        let width = points.len().checked_div(rows).unwrap_or(0);
        let mut out = Vec::with_capacity(6 * rows * kept.len());
        for row in points.chunks(width.max(1)) {
            for number in kept.iter().filter_map(|&i| row.get(i)).flat_map(|p| self.number(p)) {
                out.extend(number.to_le_bytes());
            }
        }
        out
    }
}

/// The kept flags of `rows` rows as bits, the lowest first; each row begins on a byte boundary.
pub(super) fn bits(flags: &[bool], rows: usize, kept: &[usize]) -> Vec<u8> {
    let width = flags.len().checked_div(rows).unwrap_or(0);
    let mut out = Vec::with_capacity(rows * kept.len().div_ceil(8));
    for row in flags.chunks(width.max(1)) {
        out.extend(kept.chunks(8).map(|eight| {
            let set = |(bit, &i): (usize, &usize)| u8::from(row.get(i) == Some(&true)) << bit;
            eight.iter().enumerate().map(set).fold(0, |byte, bit| byte | bit)
        }));
    }
    out
}

/// Colours of the kept points as bytes.
pub(super) fn colors(colors: &[Point], kept: &[usize]) -> Vec<u8> {
    let byte = |x: f32| (x.clamp(0.0, 1.0) * 255.0).round() as u8;
    kept.iter().filter_map(|&i| colors.get(i)).flat_map(|rgb| rgb.map(byte)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_are_taken_evenly() {
        assert_eq!(thinned(10, 4), [0, 2, 5, 7]);
        assert_eq!(thinned(3, 100), [0, 1, 2]);
        assert!(thinned(0, 4).is_empty());
    }

    #[test]
    fn numbers_are_positions_to_half_a_step() {
        let points = [[0.0, 1.0, 2.0], [0.3, 1.1, 1.9], [f32::NAN, 0.0, 0.0], [-0.1, 0.4, 2.0]];
        let grid = Grid::around(points.iter());
        let bytes = grid.numbers(&points, 2, &[1]);
        let read: Vec<i16> =
            bytes.chunks(2).map(|two| i16::from_le_bytes([two[0], two[1]])).collect();
        for (axis, wanted) in [0.3, 1.1, 1.9].into_iter().enumerate() {
            let at = grid.origin[axis] + grid.scale_m * f64::from(read[axis]);
            assert!((at - wanted).abs() < 0.51 * grid.scale_m + 1e-6, "{at} {wanted}");
        }
        let unknown = grid.numbers(&points, 2, &[0]);
        assert_eq!(unknown[6..], [UNKNOWN.to_le_bytes(); 3].concat());
        let one = Grid::around([[1.0, 2.0, 3.0]].iter());
        assert_eq!(one.numbers(&[[1.0, 2.0, 3.0]], 1, &[0]), [0; 6]);
    }

    #[test]
    fn flags_of_a_row_begin_with_a_byte() {
        let flags: Vec<bool> = (0..18).map(|i| i % 9 == 0 || i == 8).collect();
        let all: Vec<usize> = (0..9).collect();
        assert_eq!(bits(&flags, 2, &all), [1, 1, 1, 0]);
        assert_eq!(bits(&flags, 2, &[8]), [1, 0]);
    }
}
