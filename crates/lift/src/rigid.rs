//! The rigid motion that best takes points to points, in spite of some that go astray.
//!
//! Kabsch, "A solution for the best rotation to relate two sets of vectors" (1976), with weights after Tukey that are
//! computed anew a few times from the residuals' own spread.

use bendtwin_core::Point;
use nalgebra::{Matrix3, Rotation3, UnitQuaternion, Vector3};

/// A rotation, then a translation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Rigid {
    pub(crate) rotation: Matrix3<f64>,
    pub(crate) translation: Vector3<f64>,
}

/// A fitted motion with the median distance that it leaves [m].
pub(crate) struct Fitted {
    pub(crate) motion: Rigid,
    pub(crate) residual_m: f64,
}

impl Rigid {
    pub(crate) fn apply(&self, p: Point) -> Point {
        let moved = self.rotation * vector(p) + self.translation;
        [moved.x as f32, moved.y as f32, moved.z as f32]
    }

    pub(crate) fn inverse(&self) -> Self {
        let back = self.rotation.transpose();
        Self { rotation: back, translation: -(back * self.translation) }
    }

    /// Between two motions; `share` 0 is this one. `pivot` is what moves evenly.
    pub(crate) fn between(&self, other: &Self, share: f64, pivot: Point) -> Self {
        let turn = |m: &Matrix3<f64>| {
            UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(*m))
        };
        let (a, b) = (turn(&self.rotation), turn(&other.rotation));
        let quaternion = a.try_slerp(&b, share, 1e-9).unwrap_or(if share < 0.5 { a } else { b });
        let rotation = *quaternion.to_rotation_matrix().matrix();
        let p = vector(pivot);
        let at = |m: &Self| m.rotation * p + m.translation;
        let middle = at(self) * (1.0 - share) + at(other) * share;
        Self { rotation, translation: middle - rotation * p }
    }
}

/// Takes `from` to `to`; `None` with fewer than three pairs. Residuals below `least_m` count as noise.
pub(crate) fn fit(pairs: &[(Point, Point)], least_m: f64) -> Option<Fitted> {
    if pairs.len() < 3 {
        return None;
    }
    let mut weights = vec![1.0; pairs.len()];
    let mut residuals = vec![0.0; pairs.len()];
    let mut sorted = Vec::with_capacity(pairs.len());
    let mut motion = start(pairs);
    let mut residual_m = 0.0;
    for _ in 0..4 {
        for (residual, (a, b)) in residuals.iter_mut().zip(pairs) {
            *residual = (motion.rotation * vector(*a) + motion.translation - vector(*b)).norm();
        }
        sorted.clone_from(&residuals);
        let middle = sorted.len() / 2;
        let (_, median, _) = sorted.select_nth_unstable_by(middle, f64::total_cmp);
        residual_m = *median;
        let reach = 3.0 * residual_m.max(least_m);
        for (weight, residual) in weights.iter_mut().zip(&residuals) {
            let u = residual / reach;
            *weight = if u < 1.0 { (1.0 - u * u) * (1.0 - u * u) } else { 0.0 };
        }
        motion = weighted(pairs, &weights)?;
    }
    Some(Fitted { motion, residual_m })
}

/// A first guess that outliers cannot pull far: the median translation.
fn start(pairs: &[(Point, Point)]) -> Rigid {
    let mut shift = [0.0; 3];
    let mut values = Vec::with_capacity(pairs.len());
    for (axis, shift) in shift.iter_mut().enumerate() {
        values.clear();
        values.extend(pairs.iter().map(|(a, b)| f64::from(b[axis]) - f64::from(a[axis])));
        let middle = values.len() / 2;
        *shift = *values.select_nth_unstable_by(middle, f64::total_cmp).1;
    }
    Rigid { rotation: Matrix3::identity(), translation: Vector3::from(shift) }
}

fn weighted(pairs: &[(Point, Point)], weights: &[f64]) -> Option<Rigid> {
    let mut total = 0.0;
    let (mut from, mut to) = (Vector3::zeros(), Vector3::zeros());
    for ((a, b), w) in pairs.iter().zip(weights) {
        total += w;
        from += vector(*a) * *w;
        to += vector(*b) * *w;
    }
    if total <= 1e-12 {
        return None;
    }
    let (from, to) = (from / total, to / total);
    let mut covariance = Matrix3::zeros();
    for ((a, b), w) in pairs.iter().zip(weights) {
        covariance += (vector(*b) - to) * (vector(*a) - from).transpose() * *w;
    }
    let svd = covariance.svd(true, true);
    let (u, v_t) = (svd.u?, svd.v_t?);
    let mut flip = Matrix3::identity();
    flip[(2, 2)] = if (u * v_t).determinant() < 0.0 { -1.0 } else { 1.0 };
    let rotation = u * flip * v_t;
    Some(Rigid { rotation, translation: to - rotation * from })
}

pub(crate) fn vector(p: Point) -> Vector3<f64> {
    Vector3::new(f64::from(p[0]), f64::from(p[1]), f64::from(p[2]))
}

pub(crate) fn distance(a: Point, b: Point) -> f64 {
    (vector(a) - vector(b)).norm()
}

#[cfg(test)]
mod tests;
