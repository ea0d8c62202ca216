//! The nearest of many points.

use kiddo::{ImmutableKdTree, SquaredEuclidean};

use crate::Vec3;

/// Points in a tree.
pub(crate) struct Cloud {
    tree: ImmutableKdTree<f64, 3>,
    pub(crate) points: Vec<Vec3>,
}

impl Cloud {
    /// `None` where there are no points.
    pub(crate) fn new(points: Vec<Vec3>) -> Option<Self> {
        if points.is_empty() {
            return None;
        }
        let rows: Vec<[f64; 3]> = points.iter().map(|p| (*p).into()).collect();
        Some(Self { tree: ImmutableKdTree::new_from_slice(&rows).ok()?, points })
    }

    /// The point nearest to `p`, and its squared distance.
    pub(crate) fn nearest(&self, p: Vec3) -> (Vec3, f64) {
        let query: [f64; 3] = p.into();
        let found = self.tree.query(&query).nearest_one::<SquaredEuclidean<f64>>().execute();
        (self.points.get(found.item as usize).copied().unwrap_or(p), found.distance)
    }
}
