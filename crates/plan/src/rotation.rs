//! Rotation vectors [rad] and unit quaternions x, y, z, w.

/// Angle below which sines are those of their series [rad].
const SMALL: f64 = 1e-4;

/// The quaternion of a rotation vector.
pub(crate) fn exponential(vector: [f64; 3]) -> [f64; 4] {
    let angle = length(&vector);
    let [x, y, z] = vector.map(|v| half_sine(angle) * v);
    [x, y, z, (0.5 * angle).cos()]
}

/// d quaternion / d rotation vector, shape [4, 3].
pub(crate) fn exponential_jacobian(vector: [f64; 3]) -> [[f64; 3]; 4] {
    let angle = length(&vector);
    let s = half_sine(angle);
    let slope = match angle < SMALL {
        true => -1.0 / 24.0,
        false => (0.5 * (0.5 * angle).cos() - s) / (angle * angle),
    };
    let mut rows = [[0.0; 3]; 4];
    for (i, row) in rows.iter_mut().enumerate() {
        for (j, value) in row.iter_mut().enumerate() {
            *value = match vector.get(i) {
                Some(v) => slope * v * vector[j] + if i == j { s } else { 0.0 },
                None => -0.5 * s * vector[j],
            };
        }
    }
    rows
}

/// The rotation vector of a unit quaternion that is nearest to another vector: turns may be more
/// than half a one.
pub(crate) fn logarithm_near(quaternion: [f64; 4], near: [f64; 3]) -> [f64; 3] {
    let [x, y, z, w] = quaternion;
    let sine = length(&[x, y, z]);
    let angle = 2.0 * sine.atan2(w);
    let axis = match (sine > 0.0, length(&near)) {
        (true, _) => [x, y, z].map(|v| v / sine),
        (false, 0.0) => return [0.0; 3],
        (false, norm) => near.map(|v| v / norm),
    };
    let along: f64 = axis.iter().zip(&near).map(|(a, b)| a * b).sum();
    let turns = ((along - angle) / std::f64::consts::TAU).round();
    axis.map(|v| v * (angle + turns * std::f64::consts::TAU))
}

/// The rotation b followed by a.
pub(crate) fn product(a: [f64; 4], b: [f64; 4]) -> [f64; 4] {
    let ([ax, ay, az, aw], [bx, by, bz, bw]) = (a, b);
    [
        aw * bx + bw * ax + ay * bz - az * by,
        aw * by + bw * ay + az * bx - ax * bz,
        aw * bz + bw * az + ax * by - ay * bx,
        aw * bw - ax * bx - ay * by - az * bz,
    ]
}

/// The opposite of a rotation.
pub(crate) fn inverse([x, y, z, w]: [f64; 4]) -> [f64; 4] {
    [-x, -y, -z, w]
}

/// A quaternion of unit length; no rotation if it has no direction.
pub(crate) fn unit(quaternion: [f64; 4]) -> [f64; 4] {
    let length = length(&quaternion);
    if length > 0.0 { quaternion.map(|v| v / length) } else { [0.0, 0.0, 0.0, 1.0] }
}

/// sin(angle / 2) / angle.
fn half_sine(angle: f64) -> f64 {
    if angle < SMALL { 0.5 - angle * angle / 48.0 } else { (0.5 * angle).sin() / angle }
}

fn length(values: &[f64]) -> f64 {
    values.iter().map(|v| v * v).sum::<f64>().sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn logarithms_undo_exponentials_however_far_they_turn() {
        for scale in [0.0, 1e-6, 0.4, 3.1, 4.0, 9.0] {
            let vector = [0.6, -0.48, 0.64].map(|v| v * scale);
            let near = vector.map(|v| 0.9 * v);
            let found = logarithm_near(exponential(vector), near);
            let apart = found.iter().zip(&vector).map(|(a, b)| (a - b).abs()).sum::<f64>();
            assert!(apart < 1e-9, "{scale}: {found:?}");
        }
        let whole = exponential([0.0, 0.0, std::f64::consts::TAU]);
        assert!((logarithm_near(whole, [0.0, 0.0, 6.0])[2] - std::f64::consts::TAU).abs() < 1e-9);
    }

    #[test]
    fn the_jacobian_agrees_with_finite_differences() {
        for vector in [[0.0; 3], [1e-5, 0.0, 2e-5], [0.3, -0.7, 0.2], [2.0, 1.0, -2.0]] {
            let jacobian = exponential_jacobian(vector);
            for j in 0..3 {
                let at = |by: f64| {
                    exponential(std::array::from_fn(|i| vector[i] + if i == j { by } else { 0.0 }))
                };
                let (there, back) = (at(1e-6), at(-1e-6));
                for (i, row) in jacobian.iter().enumerate() {
                    let slope = (there[i] - back[i]) / 2e-6;
                    assert!((row[j] - slope).abs() < 1e-8, "{vector:?} {i} {j}");
                }
            }
        }
    }
}
