//! Knots spread evenly over a horizon, and the curve between them. It is linear in the knots, so a
//! gradient by the curve becomes one by the knots through the transpose.

use crate::Knots;

/// Curve between knots.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Curve {
    /// Straight lines.
    #[default]
    Linear,
    /// Catmull-Rom through the knots, continued in a straight line beyond the ends.
    Cubic,
}

impl Curve {
    /// Adds the weights of `knots` knots at a time in units of knot spacing, as (knot, weight); the
    /// same knot may come twice. Before the first knot and after the last one the curve stays there.
    pub(crate) fn weights(self, time: f64, knots: usize) -> Vec<(usize, f64)> {
        let last = knots.saturating_sub(1);
        let time = time.clamp(0.0, last as f64);
        let i = (time.floor() as usize).min(last.saturating_sub(1));
        let t = time - i as f64;
        if knots < 2 {
            return vec![(0, 1.0)];
        }
        match self {
            Self::Linear => vec![(i, 1.0 - t), (i + 1, t)],
            Self::Cubic => {
                let (t2, t3) = (t * t, t * t * t);
                let before = 0.5 * (-t + 2.0 * t2 - t3);
                let after = 0.5 * (t3 - t2);
                let mut weights =
                    vec![(i, 1.0 - 2.5 * t2 + 1.5 * t3), (i + 1, 0.5 * (t + 4.0 * t2 - 3.0 * t3))];
                // Beyond an end: 2 p[0] - p[1], or 2 p[K - 1] - p[K - 2].
                match i.checked_sub(1) {
                    Some(knot) => weights.push((knot, before)),
                    None => weights.extend([(0, 2.0 * before), (1, -before)]),
                }
                match i + 2 {
                    knot if knot < knots => weights.push((knot, after)),
                    _ => weights.extend([(last, 2.0 * after), (last - 1, -after)]),
                }
                weights
            }
        }
    }

    /// The coordinates of a plan at a time in units of knot spacing, shape [D].
    pub fn at(self, plan: &[f64], dims: usize, time: f64) -> Vec<f64> {
        let mut point = vec![0.0; dims];
        for (knot, weight) in self.weights(time, plan.len() / dims.max(1)) {
            let row = plan.iter().skip(knot * dims);
            point.iter_mut().zip(row).for_each(|(p, x)| *p += weight * x);
        }
        point
    }

    /// The coordinates in every frame 0..=F, shape [F + 1, D].
    pub fn path(self, plan: &[f64], dims: usize, frames: usize) -> Vec<f64> {
        let spacing = frames.max(1) as f64 / (plan.len() / dims.max(1)).saturating_sub(1) as f64;
        (0..=frames).flat_map(|f| self.at(plan, dims, f as f64 / spacing)).collect()
    }

    /// The knots of the same curve from a time in units of knot spacing on; at its end it stands
    /// still.
    pub fn shifted(self, plan: &[f64], dims: usize, time: f64) -> Knots {
        let knots = plan.len() / dims.max(1);
        (0..knots).flat_map(|k| self.at(plan, dims, k as f64 + time)).collect()
    }

    /// d cost / d knots, shape [K, D], of the gradient by the coordinates in every frame, shape
    /// [F + 1, D].
    pub fn gradient_by_knots(self, by_frame: &[f64], dims: usize, knots: usize) -> Knots {
        let rows = by_frame.len() / dims.max(1);
        let per_frame = knots.saturating_sub(1) as f64 / rows.saturating_sub(1).max(1) as f64;
        let mut gradient = vec![0.0; knots * dims];
        for (frame, row) in by_frame.chunks_exact(dims.max(1)).enumerate() {
            for (knot, weight) in self.weights(frame as f64 * per_frame, knots) {
                let to = gradient.iter_mut().skip(knot * dims);
                to.zip(row).for_each(|(g, x)| *g += weight * x);
            }
        }
        gradient
    }
}

#[cfg(test)]
mod tests;
