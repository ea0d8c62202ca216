//! The share of points that an object's surface does not cover.
//!
//! With the distance d from a target to the nearest point of the surface the value is the mean of
//! u = 1 - exp(-d² / (2 reach²)); `d u / d x = exp(-d² / (2 reach²)) (x - target) / reach²` for that
//! point x.

use bendtwin_core::Point;

use super::{mean_over, points::Points};
use crate::{
    cpu::arithmetic::{Node, Quad, Real, dot, scale},
    objective::PointSet,
};

/// How far the points of a surface cover.
#[derive(Clone, Copy, Debug)]
pub(super) struct Coverage {
    pub(super) reach_m: f32,
}

impl Coverage {
    /// -d² / (2 reach²).
    fn exponent<T: Real>(&self, d: Quad<T>) -> f64 {
        -dot(d, d).to_f64() / (2.0 * f64::from(self.reach_m).powi(2))
    }

    /// Mean over targets of the uncovered share.
    pub(super) fn value<T: Real>(
        &self,
        points: &Points<'_, T>,
        of: PointSet,
        targets: &[Point],
    ) -> f64 {
        let found = points.to_nearest(of, targets);
        // Without a surface nothing is covered.
        let bare = (targets.len() - found.len()) as f64;
        let uncovered: f64 = found.map(|(_, d)| -self.exponent(d).exp_m1()).sum();
        (bare + uncovered) * mean_over(targets.len())
    }

    /// Adds the gradient of [`Self::value`], weighted, to `bar`.
    pub(super) fn add_gradient<T: Real>(
        &self,
        points: &Points<'_, T>,
        of: PointSet,
        targets: &[Point],
        weight: f64,
        bar: &mut [Node<T>],
    ) {
        let w = weight * mean_over(targets.len()) / f64::from(self.reach_m).powi(2);
        let pull = |d: Quad<T>| scale(d, T::from_f64(w * self.exponent(d).exp()));
        let bars = points.to_nearest(of, targets).map(|(i, d)| (i, pull(d)));
        points.add_point_bars(of, bars, bar);
    }
}
