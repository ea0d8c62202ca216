//! The curve between knots, which are spread evenly or at given times. The curve is linear in the
//! knots, so a gradient by the curve becomes one by the knots through the transpose.

use crate::Knots;

/// Curve between knots.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Curve {
    /// Straight lines.
    #[default]
    Linear,
    /// Catmull-Rom through the knots, continued in a straight line beyond the ends.
    Cubic,
    /// Each knot until the next.
    Hold,
}

impl Curve {
    /// The weights of knots at rising times `at` at a time, as (knot, weight). Before the first knot
    /// and after the last one the curve stays there. Cubic is the Hermite cubic with the slopes
    /// `m_k = (p_(k+1) - p_(k-1)) / (t_(k+1) - t_(k-1))`, at both ends that of the straight line to
    /// the neighbour, as rollouts have it.
    fn weights(self, time: f64, at: &[f64]) -> Vec<(usize, f64)> {
        let last = at.len().saturating_sub(1);
        let i = at.partition_point(|t| *t <= time).saturating_sub(1);
        let (Some(start), Some(end)) = (at.get(i), at.get(i + 1)) else { return vec![(last, 1.0)] };
        let (h, s) = (end - start, ((time - start) / (end - start)).max(0.0));
        if self == Self::Hold || s == 0.0 {
            return vec![(i, 1.0)];
        }
        if self == Self::Linear {
            return vec![(i, 1.0 - s), (i + 1, s)];
        }
        // Hermite's basis; slopes in units of this interval.
        let rise = s * s * (3.0 - 2.0 * s);
        let (out, into) = (s * (1.0 - s) * (1.0 - s), s * s * (s - 1.0));
        let mut weights = vec![(i, 1.0 - rise), (i + 1, rise)];
        for (from, to, by) in [(i.saturating_sub(1), i + 1, out), (i, (i + 2).min(last), into)] {
            let slope = by * h / (at[to] - at[from]);
            weights.extend([(from, -slope), (to, slope)]);
        }
        weights
    }

    /// The coordinates of a plan at a time, with knots at times `at`, shape [D].
    fn point(self, plan: &[f64], dims: usize, time: f64, at: &[f64]) -> Vec<f64> {
        let mut point = vec![0.0; dims];
        for (knot, weight) in self.weights(time, at) {
            let row = plan.iter().skip(knot * dims);
            point.iter_mut().zip(row).for_each(|(p, x)| *p += weight * x);
        }
        point
    }

    /// The coordinates in every frame 0..=F of knots that are spread evenly, shape [F + 1, D].
    pub fn path(self, plan: &[f64], dims: usize, frames: usize) -> Vec<f64> {
        let at = even(plan.len() / dims.max(1), frames.max(1) as f64);
        (0..=frames).flat_map(|f| self.point(plan, dims, f as f64, &at)).collect()
    }

    /// The knots of the same curve from a time on, with knots at times `at`; at its end it stands
    /// still.
    pub fn shifted(self, plan: &[f64], dims: usize, time: f64, at: &[f64]) -> Knots {
        at.iter().flat_map(|t| self.point(plan, dims, t + time, at)).collect()
    }

    /// d cost / d knots, shape [K, D], of the gradient by the coordinates in every frame, shape
    /// [F + 1, D], of knots that are spread evenly.
    pub fn gradient_by_knots(self, by_frame: &[f64], dims: usize, knots: usize) -> Knots {
        let at = even(knots, (by_frame.len() / dims.max(1)).saturating_sub(1).max(1) as f64);
        let mut gradient = vec![0.0; knots * dims];
        for (frame, row) in by_frame.chunks_exact(dims.max(1)).enumerate() {
            for (knot, weight) in self.weights(frame as f64, &at) {
                let to = gradient.iter_mut().skip(knot * dims);
                to.zip(row).for_each(|(g, x)| *g += weight * x);
            }
        }
        gradient
    }
}

/// Times of knots that are spread evenly over a span.
pub(crate) fn even(knots: usize, span: f64) -> Vec<f64> {
    let last = knots.saturating_sub(1).max(1) as f64;
    (0..knots).map(|k| k as f64 * span / last).collect()
}

#[cfg(test)]
mod tests;
