//! The surface between the points of a skin: triangles of points that are near to a place and to
//! each other, because the nearest point alone says little where they are sparse. In a body as thin
//! as its points are apart, triangles also pass through the inside: places there count as on the
//! surface, so that a cloud says less of such a body than tracks do.

use bendtwin_core::Point;
use bendtwin_core::geometry::{point, vector3};
use kiddo::{ImmutableKdTree, SquaredEuclidean};
use nalgebra::Vector3;

use crate::elastic::CORNERS;

/// Points that may be corners.
const NEAR: usize = 7;
/// Corners are at most this many spacings apart.
const WIDEST: f64 = 2.5;

/// Points of a surface in one shape.
pub(crate) struct Surface {
    points: Vec<Vector3<f64>>,
    tree: ImmutableKdTree<f32, 3>,
    /// Largest distance of two corners [m].
    widest_m: f64,
}

/// The place on a surface that is nearest to a point.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Foot {
    pub(crate) points: [u32; CORNERS],
    /// Weights of the points, 0 for no point.
    pub(crate) weights: [f64; CORNERS],
    pub(crate) distance_m: f64,
}

impl Foot {
    /// The points with their weights.
    pub(crate) fn corners(&self) -> impl Iterator<Item = (usize, f64)> + '_ {
        self.points.iter().zip(&self.weights).map(|(p, w)| (*p as usize, *w))
    }
}

impl Surface {
    /// The surface of points with the given spacing [m]; `None` without points, or if one is not
    /// finite.
    pub(crate) fn new(points: &[Vector3<f64>], spacing_m: f64) -> Option<Self> {
        let places: Vec<Point> = points.iter().map(|p| point(*p)).collect();
        let finite = places.iter().flatten().all(|x| x.is_finite());
        let tree = finite.then(|| ImmutableKdTree::new_from_slice(&places).ok()).flatten()?;
        (!points.is_empty()).then(|| Self {
            points: points.to_vec(),
            tree,
            widest_m: WIDEST * spacing_m,
        })
    }

    /// The nearest of its points and its distance [m].
    pub(crate) fn nearest(&self, p: Point) -> (u32, f64) {
        let found = self.tree.query(&p).nearest_one::<SquaredEuclidean<f32>>().execute();
        (found.item, f64::from(found.distance).sqrt())
    }

    /// The place on the surface that is nearest to `p`.
    pub(crate) fn foot(&self, p: Point) -> Foot {
        let count =
            NEAR.min(self.points.len()).try_into().unwrap_or(std::num::NonZero::<usize>::MIN);
        let found = self.tree.query(&p).nearest_n::<SquaredEuclidean<f32>>(count).execute();
        let mut near: Vec<(f32, u32)> = found.iter().map(|n| (n.distance, n.item)).collect();
        near.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let near: Vec<u32> = near.into_iter().map(|(_, n)| n).collect();
        let y = vector3(p);
        let at = |n: u32| self.points[n as usize];
        let joined = |a: u32, b: u32| (at(a) - at(b)).norm() <= self.widest_m;
        let first = near.first().copied().unwrap_or(0);
        let mut best = Foot {
            points: [first, 0, 0],
            weights: [1.0, 0.0, 0.0],
            distance_m: (y - at(first)).norm(),
        };
        let mut offer = |points: [u32; CORNERS], weights: [f64; CORNERS]| {
            let foot: Vector3<f64> = points.iter().zip(weights).map(|(n, w)| at(*n) * w).sum();
            let distance_m = (y - foot).norm();
            if distance_m < best.distance_m {
                best = Foot { points, weights, distance_m };
            }
        };
        let others = near.get(1..).unwrap_or_default();
        for (k, &b) in others.iter().enumerate().filter(|(_, b)| joined(first, **b)) {
            let t = on_segment(y, at(first), at(b));
            offer([first, b, 0], [1.0 - t, t, 0.0]);
            for &c in others[k + 1..].iter().filter(|c| joined(first, **c) && joined(b, **c)) {
                if let Some(w) = in_triangle(y, at(first), at(b), at(c)) {
                    offer([first, b, c], w);
                }
            }
        }
        best
    }
}

/// Fraction of the way from `a` to `b` that is nearest to `y`.
fn on_segment(y: Vector3<f64>, a: Vector3<f64>, b: Vector3<f64>) -> f64 {
    let along = b - a;
    let square = along.norm_squared();
    if square > 0.0 { ((y - a).dot(&along) / square).clamp(0.0, 1.0) } else { 0.0 }
}

/// Barycentric coordinates of the foot of `y` on a triangle's plane; `None` outside the triangle, or
/// if it is too thin.
fn in_triangle(
    y: Vector3<f64>,
    a: Vector3<f64>,
    b: Vector3<f64>,
    c: Vector3<f64>,
) -> Option<[f64; 3]> {
    let (u, v, w) = (b - a, c - a, y - a);
    let (uu, uv, vv) = (u.dot(&u), u.dot(&v), v.dot(&v));
    let area = uu * vv - uv * uv;
    if area <= 0.01 * uu * vv {
        return None;
    }
    let (wu, wv) = (w.dot(&u), w.dot(&v));
    let s = (wu * vv - wv * uv) / area;
    let t = (wv * uu - wu * uv) / area;
    (s >= 0.0 && t >= 0.0 && s + t <= 1.0).then_some([1.0 - s - t, s, t])
}

/// Mean distance of points to their third neighbour [m]; 0 for fewer than two.
pub(crate) fn spacing(points: &[Point]) -> f64 {
    let count = 4.min(points.len());
    let (Ok(tree), Ok(count)) =
        (ImmutableKdTree::<f32, 3>::new_from_slice(points), std::num::NonZero::try_from(count))
    else {
        return 0.0;
    };
    let reach = |p: &Point| {
        let found = tree.query(p).nearest_n::<SquaredEuclidean<f32>>(count).execute();
        found.iter().map(|n| f64::from(n.distance)).fold(0.0, f64::max).sqrt()
    };
    points.iter().map(reach).sum::<f64>() / points.len() as f64
}

#[cfg(test)]
mod tests;
