//! Knots in time, and what lies between them.
//!
//! A position at a frame boundary is a weighted sum of at most four knots, whose weights depend on
//! the time alone: [`Place`]. The same weights carry a gradient back to the knots. With `t_k` the
//! knots' times, `i` the last knot at or before `t`, `h = t_(i+1) - t_i` and `s = (t - t_i) / h`:
//!
//! - linear: `(1 - s) p_i + s p_(i+1)`.
//! - cubic: the Hermite cubic through the knots with the slopes
//!   `m_k = (p_(k+1) - p_(k-1)) / (t_(k+1) - t_(k-1))`, at both ends that of the straight line to the
//!   neighbour: Catmull-Rom, for knots at any times.
//! - hold: `p_i`. A frame begins and ends with the knots of its two ends, so a jump is spread over
//!   the one frame in which it happens.
//!
//! Before the first knot there is nothing; the last holds until the end.

use bendtwin_proto::v1::{Interpolation, KnotTimes, knot_times::Times};

use crate::error::Error;

/// Share of a frame below which a knot counts as being at the frame's boundary: times in single
/// precision, and periods like 0.1 s, do not fall on frames exactly.
const ON_FRAME: f64 = 1e-3;

/// Curve on which positions between knots lie.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Curve {
    /// Straight lines.
    Linear,
    /// Catmull-Rom through the knots.
    Cubic,
    /// Each knot until the next.
    Hold,
}

impl From<Interpolation> for Curve {
    fn from(wire: Interpolation) -> Self {
        match wire {
            Interpolation::Unspecified | Interpolation::Linear => Self::Linear,
            Interpolation::Cubic => Self::Cubic,
            Interpolation::Zero => Self::Hold,
        }
    }
}

/// A frame boundary among the knots.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Place {
    /// The knot at or before it.
    pub(crate) knot: usize,
    /// Share of the way to the next knot, 0..1; 0 where the knot holds.
    pub(crate) share: f64,
    /// Weights of knots `knot - 1` to `knot + 2`; 0 for those that do not exist.
    weights: [f64; 4],
}

impl Place {
    /// The value here of what is interpolated component by component.
    pub(crate) fn at<const N: usize>(&self, knot: impl Fn(usize) -> [f32; N]) -> [f32; N] {
        if self.share == 0.0 {
            return knot(self.knot);
        }
        weigh(self.weights().map(|(k, weight)| (knot(k), weight)))
    }

    /// Adds the values here of what is interpolated value by value, of which each knot has a row: the
    /// same as [`Self::at`] of each.
    pub(crate) fn add_row<'a, const N: usize>(
        &self,
        row: impl Fn(usize) -> &'a [[f32; N]],
        to: &mut Vec<[f32; N]>,
    ) {
        let own = row(self.knot);
        if self.share == 0.0 {
            to.extend_from_slice(own);
            return;
        }
        let mut rows = [(own, 0.0); 4];
        let mut count = 0;
        for (k, weight) in self.weights() {
            rows[count] = (row(k), weight);
            count += 1;
        }
        let near = &rows[..count];
        to.extend(
            (0..own.len()).map(|i| weigh(near.iter().map(|(row, weight)| (row[i], *weight)))),
        );
    }

    /// The knots that count here, with their weights, which add up to 1.
    pub(crate) fn weights(&self) -> impl Iterator<Item = (usize, f64)> + use<> {
        let first = self.knot;
        let all = self.weights.into_iter().enumerate();
        all.filter(|(_, w)| *w != 0.0).map(move |(i, w)| (first + i - 1, w))
    }
}

/// The sum of values times their weights.
fn weigh<const N: usize>(values: impl Iterator<Item = ([f32; N], f64)>) -> [f32; N] {
    let mut sum = [0.0f64; N];
    for (value, weight) in values {
        for (sum, x) in sum.iter_mut().zip(value) {
            *sum += weight * f64::from(x);
        }
    }
    sum.map(|x| x as f32)
}

/// Frame boundaries 0..=F of a rollout among the knots of its actions.
#[derive(Clone, Debug)]
pub(crate) struct Schedule {
    places: Vec<Place>,
}

impl Schedule {
    /// The boundaries of `frames` frames at `fps` frames a second among `knots` >= 2 knots, at the
    /// times of a checked request or else spread evenly.
    pub(crate) fn new(
        curve: Curve,
        knots: usize,
        frames: usize,
        times: Option<KnotTimes>,
        fps: f64,
    ) -> Result<Self, Error> {
        let snapped = |s: f64| {
            let (time, whole) = (s * fps, (s * fps).round());
            if (time - whole).abs() < ON_FRAME { whole } else { time }
        };
        let at: Vec<f64> = match times.and_then(|times| times.times) {
            None => return Ok(Self::even(curve, knots, frames)),
            Some(Times::PeriodS(period)) => {
                (0..knots).map(|k| snapped(k as f64 * period)).collect()
            }
            Some(Times::AtS(tensor)) => {
                let (_, at) = tensor.unpack::<f32>("knot_times.at_s")?;
                at.into_iter().map(|s| snapped(f64::from(s))).collect()
            }
        };
        let mut knot = 0;
        let places = (0..=frames).map(|frame| {
            let now = frame as f64;
            while knot + 1 < at.len() && at[knot + 1] <= now {
                knot += 1;
            }
            let after = at.get(knot + 1).copied();
            let share = after.map_or(0.0, |after| (now - at[knot]) / (after - at[knot]));
            curve.place(knot, share, knots, |k| at[k])
        });
        Ok(Self { places: places.collect() })
    }

    /// Knots spread evenly over the horizon. In whole numbers, so that with a knot a frame every
    /// frame is exactly its knot.
    fn even(curve: Curve, knots: usize, frames: usize) -> Self {
        let places = (0..=frames).map(|frame| {
            let (scaled, frames) = (frame as u64 * (knots as u64 - 1), frames.max(1) as u64);
            let share = (scaled % frames) as f64 / frames as f64;
            curve.place((scaled / frames) as usize, share, knots, |k| k as f64)
        });
        Self { places: places.collect() }
    }

    /// The boundaries, shape [F + 1].
    pub(crate) fn places(&self) -> &[Place] {
        &self.places
    }
}

impl Curve {
    /// The place at a share of the way from a knot to the next of `knots` knots at times `at`.
    fn place(self, knot: usize, share: f64, knots: usize, at: impl Fn(usize) -> f64) -> Place {
        if share == 0.0 || self == Self::Hold || knot + 1 >= knots {
            return Place { knot, share: 0.0, weights: [0.0, 1.0, 0.0, 0.0] };
        }
        let s = share;
        if self == Self::Linear {
            return Place { knot, share, weights: [0.0, 1.0 - s, s, 0.0] };
        }
        // Hermite's basis; slopes in units of this interval.
        let rise = s * s * (3.0 - 2.0 * s);
        let (out, into) = (s * (1.0 - s) * (1.0 - s), s * s * (s - 1.0));
        let h = at(knot + 1) - at(knot);
        let mut weights = [0.0, 1.0 - rise, rise, 0.0];
        let mut slope = |from: usize, to: usize, by: f64| {
            let by = by * h / (at(to) - at(from));
            weights[from + 1 - knot] -= by;
            weights[to + 1 - knot] += by;
        };
        slope(knot.saturating_sub(1), knot + 1, out);
        slope(knot, (knot + 2).min(knots - 1), into);
        Place { knot, share, weights }
    }
}

#[cfg(test)]
mod tests;
