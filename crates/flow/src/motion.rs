//! Motion of a neighbourhood: the rigid motion that takes it from one set of places to another,
//! robustly.

use bendtwin_core::Point;
use nalgebra::{Matrix3, Vector3};

/// `x` becomes `rotation · (x - from) + to`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Motion {
    pub(crate) rotation: Matrix3<f64>,
    pub(crate) from: Vector3<f64>,
    pub(crate) to: Vector3<f64>,
}

/// A neighbour before and after.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Pair {
    pub(crate) before: Point,
    pub(crate) after: Point,
    pub(crate) weight: f64,
}

/// Rounds of reweighting.
const ROUNDS: usize = 6;
/// Distances below this are noise of depth [m]: nothing is gained by telling them apart.
const NOISE_M: f64 = 0.002;

impl Motion {
    /// The place that a point is moved to.
    pub(crate) fn apply(&self, point: Point) -> Point {
        let p = self.rotation * (vector(point) - self.from) + self.to;
        [p.x as f32, p.y as f32, p.z as f32]
    }
}

/// The motion on which most of the weight agrees (iteratively reweighted Kabsch with Tukey's
/// biweight); `None` if fewer than four of four or more do.
///
/// `likely` is a rotation to stay near in directions of which the neighbours say nothing: about
/// their line, if they lie on one, or all if they are too few.
pub(crate) fn rigid(pairs: &[Pair], likely: &Matrix3<f64>) -> Option<Motion> {
    let least = pairs.len().min(4);
    if least == 0 {
        return None;
    }
    let mut weights: Vec<f64> = pairs.iter().map(|p| p.weight).collect();
    let mut found = None;
    for round in 0..ROUNDS {
        let motion = kabsch(pairs, &weights, likely)?;
        let misses: Vec<f64> = pairs
            .iter()
            .map(|p| (vector(motion.apply(p.before)) - vector(p.after)).norm())
            .collect();
        let mut sorted = misses.clone();
        sorted.sort_by(f64::total_cmp);
        let median = sorted[sorted.len() / 2];
        // Wide at first, so that a start that outliers have pulled away can come back.
        let width = (3.0 * median).max(NOISE_M) * if round == 0 { 2.0 } else { 1.0 };
        for ((weight, miss), pair) in weights.iter_mut().zip(&misses).zip(pairs) {
            let q = miss / width;
            *weight = if q < 1.0 { pair.weight * (1.0 - q * q).powi(2) } else { 0.0 };
        }
        let agreeing = weights.iter().filter(|&&w| w > 0.0).count();
        if agreeing < least {
            return None;
        }
        found = Some(motion);
    }
    found
}

/// The best rigid motion in the sense of weighted least squares.
fn kabsch(pairs: &[Pair], weights: &[f64], likely: &Matrix3<f64>) -> Option<Motion> {
    let total: f64 = weights.iter().sum();
    if total <= 0.0 {
        return None;
    }
    let mut from = Vector3::zeros();
    let mut to = Vector3::zeros();
    for (pair, w) in pairs.iter().zip(weights) {
        from += vector(pair.before) * *w;
        to += vector(pair.after) * *w;
    }
    from /= total;
    to /= total;
    let mut covariance = likely * (total * NOISE_M * NOISE_M);
    for (pair, w) in pairs.iter().zip(weights) {
        covariance += (vector(pair.after) - to) * (vector(pair.before) - from).transpose() * *w;
    }
    let svd = covariance.try_svd(true, true, 1e-15, 200)?;
    let (u, v_t) = (svd.u?, svd.v_t?);
    let mut sign = Matrix3::identity();
    if (u * v_t).determinant() < 0.0 {
        // The direction with the smallest singular value is mirrored; nalgebra sorts them.
        sign[(2, 2)] = -1.0;
    }
    let rotation = u * sign * v_t;
    rotation.iter().all(|r| r.is_finite()).then_some(Motion { rotation, from, to })
}

pub(crate) fn vector(p: Point) -> Vector3<f64> {
    Vector3::new(f64::from(p[0]), f64::from(p[1]), f64::from(p[2]))
}

pub(crate) fn distance(a: Point, b: Point) -> f64 {
    (vector(a) - vector(b)).norm()
}
