//! The order of points along a direction.
//!
//! With e = max(0, gap - direction · (x(next) - x)) the value is the mean of e² over neighbours in the
//! list; `d e² / d x(next) = -2 e direction = -d e² / d x`.

use bendtwin_core::Point;

use super::{mean_over, points::Points};
use crate::{
    cpu::arithmetic::{Node, Quad, Real, quad, scale},
    objective::PointSet,
};

/// A wanted order.
#[derive(Clone, Copy, Debug)]
pub(super) struct Order {
    /// Unit vector.
    pub(super) direction: Point,
    /// Least distance along it from a point to the next [m].
    pub(super) gap_m: f32,
}

impl Order {
    /// e of neighbours [m].
    fn lack<T: Real>(&self, from: Quad<T>, to: Quad<T>) -> f64 {
        let along = |k: usize| f64::from(self.direction[k]) * (to[k].to_f64() - from[k].to_f64());
        (f64::from(self.gap_m) - (0..3).map(along).sum::<f64>()).max(0.0)
    }

    /// Mean over neighbours of the squared lack.
    pub(super) fn value<T: Real>(
        &self,
        points: &Points<'_, T>,
        of: PointSet,
        chain: &[u32],
    ) -> f64 {
        let all = points.all(of);
        let square = |w: &[u32]| self.lack(all[w[0] as usize].x, all[w[1] as usize].x).powi(2);
        chain.windows(2).map(square).sum::<f64>() * mean_over(chain.len().saturating_sub(1))
    }

    /// Adds the gradient of [`Self::value`], weighted, to `bar`.
    pub(super) fn add_gradient<T: Real>(
        &self,
        points: &Points<'_, T>,
        of: PointSet,
        chain: &[u32],
        weight: f64,
        bar: &mut [Node<T>],
    ) {
        let all = points.all(of);
        let w = 2.0 * weight * mean_over(chain.len().saturating_sub(1));
        let direction = quad::<T>(self.direction);
        let of_link = chain.windows(2).flat_map(|link| {
            let pull = w * self.lack(all[link[0] as usize].x, all[link[1] as usize].x);
            [(link[0], pull), (link[1], -pull)]
        });
        let bars = of_link
            .filter(|(_, pull)| *pull != 0.0)
            .map(|(point, pull)| (point, scale(direction, T::from_f64(pull))));
        points.add_point_bars(of, bars, bar);
    }
}
