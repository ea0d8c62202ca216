//! Homographies between planes.

use nalgebra::{DMatrix, Matrix3, Vector3};

/// A projective map of a plane.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Homography(pub(crate) Matrix3<f64>);

impl Homography {
    /// The map that takes points to others, by the direct linear transform with normalised
    /// coordinates (Hartley and Zisserman, *Multiple view geometry*, algorithm 4.2). `None` for fewer
    /// than four points, or if three of four lie on a line.
    pub(crate) fn of(from: &[[f64; 2]], to: &[[f64; 2]]) -> Option<Self> {
        let count = from.len().min(to.len());
        if count < 4 {
            return None;
        }
        let (a, b) = (normalising(&from[..count])?, normalising(&to[..count])?);
        let mut rows = DMatrix::<f64>::zeros(2 * count.max(5), 9);
        for (n, (p, q)) in from.iter().zip(to).enumerate() {
            let (p, q) = (a * Vector3::new(p[0], p[1], 1.0), b * Vector3::new(q[0], q[1], 1.0));
            for k in 0..3 {
                rows[(2 * n, k)] = -p[k];
                rows[(2 * n, 6 + k)] = q[0] * p[k];
                rows[(2 * n + 1, 3 + k)] = -p[k];
                rows[(2 * n + 1, 6 + k)] = q[1] * p[k];
            }
        }
        let gram = rows.transpose() * &rows;
        let eigen = gram.symmetric_eigen();
        let (least, _) = eigen.eigenvalues.iter().enumerate().min_by(|a, b| a.1.total_cmp(b.1))?;
        let column = eigen.eigenvectors.column(least);
        let normalised = Matrix3::from_fn(|i, j| column[3 * i + j]);
        let map = b.try_inverse()? * normalised * a;
        let scale = map.norm();
        let map = map / scale;
        (map.iter().all(|x| x.is_finite()) && map.determinant().abs() > 1e-18).then_some(Self(map))
    }

    /// A point's image; far away for points at infinity.
    pub(crate) fn apply(&self, [x, y]: [f64; 2]) -> Option<[f64; 2]> {
        let p = self.0 * Vector3::new(x, y, 1.0);
        let at = [p[0] / p[2], p[1] / p[2]];
        at.iter().all(|x| x.is_finite()).then_some(at)
    }
}

/// Moves points about the origin, at a mean distance of √2.
fn normalising(points: &[[f64; 2]]) -> Option<Matrix3<f64>> {
    let count = points.len() as f64;
    let middle = [0, 1].map(|axis| points.iter().map(|p| p[axis]).sum::<f64>() / count);
    let distance =
        points.iter().map(|p| (p[0] - middle[0]).hypot(p[1] - middle[1])).sum::<f64>() / count;
    if !(distance > 1e-12 && distance.is_finite()) {
        return None;
    }
    let s = std::f64::consts::SQRT_2 / distance;
    Some(Matrix3::new(s, 0.0, -s * middle[0], 0.0, s, -s * middle[1], 0.0, 0.0, 1.0))
}
