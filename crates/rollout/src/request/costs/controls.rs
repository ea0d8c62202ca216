//! Costs of the motion of control points, which need no simulation.
//!
//! With dₖ the way of control point c during frame f: the path is the mean over c of the sum over f
//! of |d|, the speed cost the mean over c and f of max(0, |d| fps - limit)².

use bendtwin_core::Point;

/// A measure of the motion.
#[derive(Clone, Copy, Debug)]
pub(super) enum Motion {
    Path,
    Speed { limit_m_s: f64 },
}

/// Control points of a rollout.
#[derive(Clone, Copy, Debug)]
pub(super) struct Paths<'a> {
    /// Shape [F + 1, C].
    pub(super) controls: &'a [Point],
    /// Frames F.
    pub(super) frames: usize,
    /// Frames a second.
    pub(super) fps: f64,
}

impl Paths<'_> {
    /// Number of control points C.
    fn width(&self) -> usize {
        self.controls.len() / (self.frames + 1)
    }

    /// Share of a control point's value in a frame.
    fn share(&self, motion: Motion) -> f64 {
        let count = match motion {
            Motion::Path => self.width(),
            Motion::Speed { .. } => self.width() * self.frames,
        };
        1.0 / count.max(1) as f64
    }

    /// Ways of the control points, with the place of each at its end in `controls`.
    fn ways(&self) -> impl Iterator<Item = (usize, [f64; 3], f64)> + '_ {
        let width = self.width();
        (width..self.controls.len()).map(move |at| {
            let (to, from) = (self.controls[at], self.controls[at - width]);
            let way: [f64; 3] = std::array::from_fn(|k| f64::from(to[k]) - f64::from(from[k]));
            (at, way, way.iter().map(|d| d * d).sum::<f64>().sqrt())
        })
    }

    /// Values by frame, shape [F + 1], which add up to the cost.
    pub(super) fn values(&self, motion: Motion) -> Vec<f64> {
        let (width, share) = (self.width(), self.share(motion));
        let mut values = vec![0.0; self.frames + 1];
        for (at, _, length) in self.ways() {
            values[at / width] += share
                * match motion {
                    Motion::Path => length,
                    Motion::Speed { limit_m_s } => (length * self.fps - limit_m_s).max(0.0).powi(2),
                };
        }
        values
    }

    /// Adds d cost / d controls, weighted, to a gradient of their shape.
    pub(super) fn add_gradient(&self, motion: Motion, weight: f64, gradient: &mut [Point]) {
        let (width, share) = (self.width(), self.share(motion));
        for (at, way, length) in self.ways().filter(|(_, _, length)| *length > 0.0) {
            let slope = match motion {
                Motion::Path => 1.0,
                Motion::Speed { limit_m_s } => {
                    2.0 * self.fps * (length * self.fps - limit_m_s).max(0.0)
                }
            };
            for (k, d) in way.into_iter().enumerate() {
                let g = (weight * share * slope * d / length) as f32;
                gradient[at][k] += g;
                gradient[at - width][k] -= g;
            }
        }
    }
}
