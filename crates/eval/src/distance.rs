//! Distances from observed points to the nearest surface node.

use bendtwin_core::Point;
use kiddo::{ImmutableKdTree, Manhattan, SquaredEuclidean};

/// Mean distances over points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct MeanDistances {
    /// In the L1 norm, each to the node that is nearest in it [m].
    pub(crate) l1_m: f64,
    /// Euclidean [m].
    pub(crate) l2_m: f64,
}

/// Chamfer distances from `points` to `nodes`, one-sided; `None` if either is empty.
pub(crate) fn chamfer(points: &[Point], nodes: &[Point]) -> Option<MeanDistances> {
    if points.is_empty() || nodes.is_empty() {
        return None;
    }
    let tree: ImmutableKdTree<f32, 3> = ImmutableKdTree::new_from_slice(nodes).ok()?;
    let (mut l1, mut l2) = (0.0, 0.0);
    for p in points {
        l1 += f64::from(tree.query(p).nearest_one::<Manhattan<f32>>().execute().distance);
        let square = tree.query(p).nearest_one::<SquaredEuclidean<f32>>().execute().distance;
        l2 += f64::from(square).sqrt();
    }
    let n = points.len() as f64;
    Some(MeanDistances { l1_m: l1 / n, l2_m: l2 / n })
}

/// Index of the nearest of `nodes`, ties to the first; `None` without nodes.
pub(crate) fn nearest(point: Point, nodes: &[Point]) -> Option<usize> {
    let distances = nodes.iter().map(|n| euclidean(*n, point)).enumerate();
    distances.min_by(|a, b| a.1.total_cmp(&b.1)).map(|(i, _)| i)
}

/// Euclidean distance [m].
pub(crate) fn euclidean(a: Point, b: Point) -> f64 {
    a.iter().zip(b).map(|(x, y)| f64::from(x - y).powi(2)).sum::<f64>().sqrt()
}

pub(crate) fn is_finite(p: &Point) -> bool {
    p.iter().all(|x| x.is_finite())
}

#[cfg(test)]
mod tests;
