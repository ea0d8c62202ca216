//! Rotations as quaternions x, y, z, w, and the one nearest to a matrix.

use std::f64::consts::FRAC_PI_2;

use bendtwin_core::geometry::{Vector, add, cross, dot, length, scaled};

/// No rotation.
pub(super) const IDENTITY: [f64; 4] = [0.0, 0.0, 0.0, 1.0];

/// Steps towards the nearest rotation: from 170 degrees it is reached within rounding.
const STEPS: usize = 40;
/// Angle below which a step changes nothing that f32 keeps [rad].
const LEAST_RAD: f64 = 1e-12;

/// The rotation R nearest to a matrix A: the one with the largest Σ r_k · a_k over their columns.
///
/// After Müller et al. 2016, "A robust method to extract the rotational part of deformations":
/// R turns by ω = Σ r_k × a_k / |Σ r_k · a_k| until it is zero. It starts from no rotation, so that
/// where A leaves an axis open, as on a line, nothing turns about it. A step is a right angle at
/// most, which the method of the paper does not limit: near two thirds of a half turn its quotient
/// has no bound.
pub(super) fn nearest_rotation(a: &[[f64; 3]; 3]) -> [f64; 4] {
    let columns: [Vector; 3] = [0, 1, 2].map(|k| [a[0][k], a[1][k], a[2][k]]);
    let size = columns.iter().map(|c| dot(*c, *c)).sum::<f64>().sqrt();
    let mut q = IDENTITY;
    if !(size > 0.0 && size.is_finite()) {
        return q;
    }
    for _ in 0..STEPS {
        let axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(|e| turn(q, e));
        let mut torque = [0.0; 3];
        let mut along = 0.0;
        for (r, a) in axes.into_iter().zip(columns) {
            torque = add(torque, cross(r, a));
            along += dot(r, a);
        }
        let turning = length(torque);
        // Within rounding of the sums it has no direction.
        if turning <= LEAST_RAD * size {
            break;
        }
        let angle = (turning / along.abs().max(LEAST_RAD * size)).min(FRAC_PI_2);
        let (sine, cosine) = (0.5 * angle).sin_cos();
        let [x, y, z] = scaled(torque, sine / turning);
        q = normalized(multiply([x, y, z, cosine], q)).unwrap_or(IDENTITY);
    }
    q
}

/// The quaternion of length 1; `None` if it has no length.
pub(super) fn normalized(q: [f64; 4]) -> Option<[f64; 4]> {
    let length = q.iter().map(|x| x * x).sum::<f64>().sqrt();
    (length > 1e-9).then(|| q.map(|x| x / length))
}

/// Numbers that quaternions are made of.
pub(super) trait Real:
    Copy
    + std::ops::Add<Output = Self>
    + std::ops::Sub<Output = Self>
    + std::ops::Mul<Output = Self>
    + std::ops::Neg<Output = Self>
{
}
impl Real for f32 {}
impl Real for f64 {}

/// The rotation by `b`, then by `a`.
pub(super) fn multiply<T: Real>([ax, ay, az, aw]: [T; 4], [bx, by, bz, bw]: [T; 4]) -> [T; 4] {
    [
        aw * bx + ax * bw + ay * bz - az * by,
        aw * by - ax * bz + ay * bw + az * bx,
        aw * bz + ax * by - ay * bx + az * bw,
        aw * bw - ax * bx - ay * by - az * bz,
    ]
}

/// A vector, turned by a unit quaternion.
pub(super) fn turn<T: Real>([x, y, z, w]: [T; 4], [a, b, c]: [T; 3]) -> [T; 3] {
    // v + 2 w (n × v) + 2 n × (n × v).
    let [p, q, r] = [y * c - z * b, z * a - x * c, x * b - y * a];
    let [p, q, r] = [p + p, q + q, r + r];
    [a + w * p + (y * r - z * q), b + w * q + (z * p - x * r), c + w * r + (x * q - y * p)]
}

/// A vector, turned by the inverse of a unit quaternion.
pub(super) fn turn_back<T: Real>([x, y, z, w]: [T; 4], v: [T; 3]) -> [T; 3] {
    turn([-x, -y, -z, w], v)
}
