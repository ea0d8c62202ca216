//! The winding of a chain of points around a line.
//!
//! With the parts a and b of two neighbours that are perpendicular to the line, the angle from one to
//! the next is atan2(direction · (a x b), a · b). Its derivatives are direction x b / |b|² by b and
//! -direction x a / |a|² by a. Those of the two angles that an inner point is in cancel, so what is left
//! of them turns the ends of the chain around the line.

use std::f64::consts::TAU;

use bendtwin_core::Point;

use super::points::Points;
use crate::{
    constants::LEAST_RADIUS_M,
    cpu::arithmetic::{Node, Quad, Real},
    objective::PointSet,
};

/// A line, and the wanted turns around it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Winding {
    origin: [f64; 3],
    /// Unit vector.
    direction: [f64; 3],
    turns: f64,
}

impl Winding {
    pub(super) fn new(origin: Point, direction: Point, turns: f32) -> Self {
        let wide = |p: Point| p.map(f64::from);
        Self { origin: wide(origin), direction: wide(direction), turns: turns.into() }
    }

    /// The way from the line to a point [m]; `None` where it has no direction.
    fn radius<T: Real>(&self, x: Quad<T>) -> Option<[f64; 3]> {
        let way: [f64; 3] = std::array::from_fn(|k| x[k].to_f64() - self.origin[k]);
        let along = dot(way, self.direction);
        let radius: [f64; 3] = std::array::from_fn(|k| way[k] - along * self.direction[k]);
        (dot(radius, radius) > LEAST_RADIUS_M * LEAST_RADIUS_M).then_some(radius)
    }

    fn radii<T: Real>(
        &self,
        points: &Points<'_, T>,
        of: PointSet,
        chain: &[u32],
    ) -> Vec<Option<[f64; 3]>> {
        let all = points.all(of);
        chain.iter().map(|&i| self.radius(all[i as usize].x)).collect()
    }

    /// Turns beyond the wanted ones.
    fn excess(&self, radii: &[Option<[f64; 3]>]) -> f64 {
        let angle = |pair: &[Option<[f64; 3]>]| match *pair {
            [Some(a), Some(b)] => dot(self.direction, cross(a, b)).atan2(dot(a, b)),
            _ => 0.0,
        };
        radii.windows(2).map(angle).sum::<f64>() / TAU - self.turns
    }

    /// Squared difference from the wanted turns.
    pub(super) fn value<T: Real>(
        &self,
        points: &Points<'_, T>,
        of: PointSet,
        chain: &[u32],
    ) -> f64 {
        self.excess(&self.radii(points, of, chain)).powi(2)
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
        let radii = self.radii(points, of, chain);
        let w = 2.0 * weight * self.excess(&radii) / TAU;
        let bars = chain.iter().enumerate().filter_map(|(i, &point)| {
            let radius = radii[i]?;
            let has = |other: Option<usize>| {
                other.and_then(|i| radii.get(i)).is_some_and(Option::is_some)
            };
            // Gradients of the angle that ends here, and of the one that begins.
            let (ends, begins) = (has(i.checked_sub(1)), has(Some(i + 1)));
            let share = f64::from(u8::from(ends)) - f64::from(u8::from(begins));
            let turn = cross(self.direction, radius);
            let factor = w * share / dot(radius, radius);
            let [x, y, z] = turn.map(|x| T::from_f64(factor * x));
            (share != 0.0).then_some((point, [x, y, z, T::ZERO]))
        });
        points.add_point_bars(of, bars, bar);
    }
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}
