//! Knots spread evenly over a horizon, and what lies between them.

use bendtwin_core::Point;
use bendtwin_proto::v1::Interpolation;

/// Curve on which positions between knots lie.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Curve {
    /// Straight lines.
    Linear,
    /// Catmull-Rom through the knots, continued in a straight line beyond the ends.
    Cubic,
}

impl From<Interpolation> for Curve {
    fn from(wire: Interpolation) -> Self {
        match wire {
            Interpolation::Unspecified | Interpolation::Linear => Self::Linear,
            Interpolation::Cubic | Interpolation::Zero => Self::Cubic,
        }
    }
}

/// A place between two knots.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Place {
    /// The knot at or before it.
    pub(super) knot: usize,
    /// Share of the way to the next knot, 0..1.
    pub(super) share: f32,
}

impl Place {
    /// Place of frame `frame` of `frames` among `knots` >= 2 knots. In whole numbers, so that
    /// with a knot a frame every frame is exactly its knot.
    pub(super) fn of(frame: usize, frames: usize, knots: usize) -> Self {
        let (scaled, frames) = (frame as u64 * (knots as u64 - 1), frames.max(1) as u64);
        let share = (scaled % frames) as f64 / frames as f64;
        Self { knot: (scaled / frames) as usize, share: share as f32 }
    }
}

impl Curve {
    /// The position at a place among `count` knots.
    pub(super) fn at(self, place: Place, count: usize, knot: impl Fn(usize) -> Point) -> Point {
        let (i, t) = (place.knot, place.share);
        if t == 0.0 || i + 1 >= count {
            return knot(i.min(count - 1));
        }
        let (p1, p2) = (knot(i), knot(i + 1));
        match self {
            Self::Linear => mix(p1, p2, |a, b| a + (b - a) * t),
            Self::Cubic => {
                let p0 = if i > 0 { knot(i - 1) } else { mix(p1, p2, |a, b| 2.0 * a - b) };
                let p3 = if i + 2 < count { knot(i + 2) } else { mix(p1, p2, |a, b| 2.0 * b - a) };
                std::array::from_fn(|c| catmull_rom([p0[c], p1[c], p2[c], p3[c]], t))
            }
        }
    }
}

/// Uniform Catmull-Rom between b and c.
fn catmull_rom([a, b, c, d]: [f32; 4], t: f32) -> f32 {
    let slope = 0.5 * (c - a);
    let quadratic = a - 2.5 * b + 2.0 * c - 0.5 * d;
    let cubic = 0.5 * (d - a) + 1.5 * (b - c);
    b + t * (slope + t * (quadratic + t * cubic))
}

fn mix(a: Point, b: Point, f: impl Fn(f32, f32) -> f32) -> Point {
    std::array::from_fn(|c| f(a[c], b[c]))
}

#[cfg(test)]
mod tests;
