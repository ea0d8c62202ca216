//! Rigid motions, and the one that best takes points to points.
//!
//! Kabsch, "A solution for the best rotation to relate two sets of vectors" (1976), with weights.

use nalgebra::{Matrix3, Rotation3, UnitQuaternion, Vector3};

use super::{point, vector3};
use crate::Point;

/// A rotation, then a translation: `x` becomes `rotation · x + translation`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RigidMotion {
    /// Rotation.
    pub rotation: Matrix3<f64>,
    /// Translation [m].
    pub translation: Vector3<f64>,
}

impl RigidMotion {
    /// Image of a point.
    pub fn apply(&self, p: Point) -> Point {
        point(self.rotation * vector3(p) + self.translation)
    }

    /// Translation [m] and unit quaternion: x, y, z, then x, y, z, w.
    pub fn pose(&self) -> [f64; 7] {
        let rotation = Rotation3::from_matrix_unchecked(self.rotation);
        let turn = UnitQuaternion::from_rotation_matrix(&rotation);
        let t = self.translation;
        [t.x, t.y, t.z, turn.i, turn.j, turn.k, turn.w]
    }

    /// The motion back.
    #[must_use]
    pub fn inverse(&self) -> Self {
        let back = self.rotation.transpose();
        Self { rotation: back, translation: -(back * self.translation) }
    }

    /// Motion between this one (`share` 0) and another (`share` 1), along which `pivot` moves
    /// evenly.
    #[must_use]
    pub fn between(&self, other: &Self, share: f64, pivot: Point) -> Self {
        let turn = |m: &Matrix3<f64>| {
            UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(*m))
        };
        let (a, b) = (turn(&self.rotation), turn(&other.rotation));
        let quaternion = a.try_slerp(&b, share, 1e-9).unwrap_or(if share < 0.5 { a } else { b });
        let rotation = *quaternion.to_rotation_matrix().matrix();
        let p = vector3(pivot);
        let at = |m: &Self| m.rotation * p + m.translation;
        let middle = at(self) * (1.0 - share) + at(other) * share;
        Self { rotation, translation: middle - rotation * p }
    }
}

/// A rigid motion about middles: `x` becomes `rotation · (x - from) + to`. Far from the origin it
/// loses fewer digits than the [`RigidMotion`] that it is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Alignment {
    /// Rotation.
    pub rotation: Matrix3<f64>,
    /// Weighted mean of the points before [m].
    pub from: Vector3<f64>,
    /// Weighted mean of the points after [m].
    pub to: Vector3<f64>,
}

impl Alignment {
    /// Image of a point.
    pub fn apply(&self, p: Point) -> Point {
        point(self.rotation * (vector3(p) - self.from) + self.to)
    }

    /// The motion with the origin as its centre.
    pub fn motion(&self) -> RigidMotion {
        let translation = self.to - self.rotation * self.from;
        RigidMotion { rotation: self.rotation, translation }
    }
}

/// A point before and after a motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pair {
    /// Position before [m].
    pub before: Point,
    /// Position after [m].
    pub after: Point,
    /// Weight, from 0.
    pub weight: f64,
}

/// A rotation to stay near in directions of which the pairs say nothing: about their line if they
/// lie on one, or all if they are too few.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Prior {
    /// The rotation.
    pub rotation: Matrix3<f64>,
    /// Deviation of points [m] whose square is its weight per weight of the pairs.
    pub deviation_m: f64,
}

/// Options of [`kabsch`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Kabsch {
    /// Total weights up to this count as zero.
    pub least_weight: f64,
    /// Rotation to stay near.
    pub prior: Option<Prior>,
    /// Convergence of the singular value decomposition.
    pub epsilon: f64,
    /// Most iterations of the singular value decomposition; 0 does not limit them.
    pub iterations: usize,
}

impl Default for Kabsch {
    /// No prior, and the decomposition's own convergence.
    fn default() -> Self {
        Self { least_weight: 1e-12, prior: None, epsilon: 5.0 * f64::EPSILON, iterations: 0 }
    }
}

/// The rigid motion with the least weighted sum of squared distances; `weights` stand in for those
/// of the pairs. `None` if there is no weight, or the decomposition does not converge to a finite
/// rotation.
pub fn kabsch(pairs: &[Pair], weights: &[f64], options: &Kabsch) -> Option<Alignment> {
    let total: f64 = weights.iter().sum();
    if total <= options.least_weight {
        return None;
    }
    let (mut from, mut to) = (Vector3::zeros(), Vector3::zeros());
    for (pair, w) in pairs.iter().zip(weights) {
        from += vector3(pair.before) * *w;
        to += vector3(pair.after) * *w;
    }
    from /= total;
    to /= total;
    let mut covariance = match &options.prior {
        Some(prior) => prior.rotation * (total * prior.deviation_m * prior.deviation_m),
        None => Matrix3::zeros(),
    };
    for (pair, w) in pairs.iter().zip(weights) {
        covariance += (vector3(pair.after) - to) * (vector3(pair.before) - from).transpose() * *w;
    }
    let svd = covariance.try_svd(true, true, options.epsilon, options.iterations)?;
    let (u, v_t) = (svd.u?, svd.v_t?);
    let mut sign = Matrix3::identity();
    if (u * v_t).determinant() < 0.0 {
        // The direction with the smallest singular value is mirrored; nalgebra sorts them.
        sign[(2, 2)] = -1.0;
    }
    let rotation = u * sign * v_t;
    rotation.iter().all(|r| r.is_finite()).then_some(Alignment { rotation, from, to })
}
