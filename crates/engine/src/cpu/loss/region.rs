//! Regions of space that nodes are to stay in: the way from a node into a half space or a box, which
//! its squared length makes a term of.

use std::sync::Arc;

use bendtwin_core::Point;

use super::mean_over;
use crate::cpu::arithmetic::{Node, Quad, Real, add_scaled, dot, quad, scale};

/// A half space or a box.
#[derive(Clone, Copy, Debug)]
pub(super) enum Region {
    /// normal · x >= offset.
    Above { normal: Point, offset_m: f32 },
    /// low <= x <= high by coordinate.
    Within { low: Point, high: Point },
}

impl Region {
    /// From the nearest point of the region to a node; zero within.
    fn beyond<T: Real>(&self, x: Quad<T>) -> Quad<T> {
        match *self {
            Self::Above { normal, offset_m } => {
                let normal = quad(normal);
                let depth = (T::from_f32(offset_m) - dot(normal, x)).at_least(T::ZERO);
                scale(normal, -depth)
            }
            Self::Within { low, high } => {
                let (low, high) = (quad::<T>(low), quad::<T>(high));
                std::array::from_fn(|k| x[k] - x[k].at_least(low[k]).at_most(high[k]))
            }
        }
    }

    /// Mean of the squared distance of these nodes, or of all.
    pub(super) fn value<T: Real>(&self, some: Option<&Arc<Vec<u32>>>, nodes: &[Node<T>]) -> f64 {
        let square = |node: &Node<T>| {
            let d = self.beyond(node.x);
            dot(d, d).to_f64()
        };
        match some {
            None => nodes.iter().map(square).sum::<f64>() * mean_over(nodes.len()),
            Some(some) => {
                let sum: f64 = some.iter().map(|&i| square(&nodes[i as usize])).sum();
                sum * mean_over(some.len())
            }
        }
    }

    /// Adds the gradient of [`Self::value`], weighted, to `bar`.
    pub(super) fn add_gradient<T: Real>(
        &self,
        some: Option<&Arc<Vec<u32>>>,
        nodes: &[Node<T>],
        weight: f64,
        bar: &mut [Node<T>],
    ) {
        let count = some.map_or(nodes.len(), |some| some.len());
        let w = T::from_f64(2.0 * weight * mean_over(count));
        // The normal of a half space has length one to rounding: d depth² / dx = 2 depth normal.
        let mut add = |i: usize| bar[i].x = add_scaled(bar[i].x, w, self.beyond(nodes[i].x));
        match some {
            None => (0..nodes.len()).for_each(add),
            Some(some) => some.iter().for_each(|&i| add(i as usize)),
        }
    }
}
