//! The places at which hands meet the object. Control points there hold it; those on a wrist or a forearm would
//! hold nothing.

use bendtwin_core::Point;
use bendtwin_near::PointTree;

use crate::{rigid::distance, thin::farthest_first};

/// Control points this near to the object hold it: nodes are within the control radius of a fit
/// there, though there are fewer of them than points [m].
const NEAR_M: f64 = 0.01;
/// Farther from the object than this a control point holds nothing: the control radius of a fit
/// [m].
pub(crate) const REACH_M: f64 = 0.02;
/// Fewest control points of a hand, however far it is from the object.
const LEAST: usize = 4;

/// Most points of the object from which a place is measured that is out of reach.
const MOST_MEASURED: usize = 2000;

/// Object and hands in the first frame.
pub(crate) struct Contact {
    /// Points of the object: its surface, and the completed ones [m].
    object: Vec<Point>,
    tree: PointTree,
    /// The hands' surface, as all cameras see it [m].
    pub(super) hands: Vec<Point>,
}

impl Contact {
    pub(crate) fn new(object: Vec<Point>, hands: Vec<Point>) -> Self {
        Self { tree: PointTree::new(object.iter().copied()), object, hands }
    }

    /// Distance of a place from the object [m], roughly where it is out of reach; infinite if nothing
    /// is known of the object.
    fn distance_m(&self, place: Point) -> f64 {
        let near = self.tree.within(place, REACH_M, 1);
        near.first().map(|near| near.square.sqrt()).unwrap_or_else(|| {
            let stride = self.object.len().div_ceil(MOST_MEASURED).max(1);
            let some = self.object.iter().step_by(stride).map(|p| distance(*p, place));
            some.fold(f64::INFINITY, f64::min)
        })
    }

    /// Up to `count` of some places on a hand, spread over where it meets the object, and how far each
    /// of them is from that [m]. The reach grows from [`NEAR_M`] to [`REACH_M`] while there are fewer
    /// places than asked for, and beyond that for a hand that holds by a few points or by none.
    pub(super) fn choose(&self, places: &[Point], count: usize) -> (Vec<usize>, Vec<f64>) {
        let mut order: Vec<(f64, usize)> =
            places.iter().enumerate().map(|(i, p)| (self.distance_m(*p), i)).collect();
        order.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let within = |reach_m: f64| order.iter().take_while(|(d, _)| *d <= reach_m).count();
        let unknown = self.object.is_empty();
        let most = if unknown { places.len() } else { within(REACH_M).max(LEAST) };
        let kept = within(NEAR_M).max(count.min(most)).min(order.len());
        let kept = if unknown { order.len() } else { kept };
        order.truncate(kept);
        // Ties of places are broken by their order, not by their distance.
        order.sort_by_key(|(_, i)| *i);
        let near: Vec<Point> = order.iter().map(|(_, i)| places[*i]).collect();
        let picked = farthest_first(&near, count);
        (picked.iter().map(|i| order[*i].1).collect(), picked.iter().map(|i| order[*i].0).collect())
    }
}

/// Number of places that hold something.
pub(super) fn holding(distances_m: &[f64]) -> usize {
    distances_m.iter().filter(|d| **d <= REACH_M).count()
}

#[cfg(test)]
mod tests;
