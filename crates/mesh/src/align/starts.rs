//! Starts of alignment: the mesh's middle on the observed middle, turned and sized in many ways.

use nalgebra::{Matrix3, Quaternion, UnitQuaternion};

use crate::{Similarity, Vec3};

/// Rotations that are spread over all; neighbours are about 30 degrees apart.
const ROTATIONS: usize = 160;
/// Scales, relative to the one that makes both clouds equally wide: partial clouds are narrower
/// than their object.
const RELATIVE_SCALES: [f64; 3] = [0.85, 1.0, 1.2];

pub(super) fn starts(mesh: &[Vec3], observed: &[Vec3]) -> Vec<Similarity> {
    let (from, to) = (Frame::of(mesh), Frame::of(observed));
    let mut rotations = Vec::new();
    // All proper ways to lay three axes onto three axes.
    for order in [[0, 1, 2], [1, 2, 0], [2, 0, 1], [0, 2, 1], [2, 1, 0], [1, 0, 2]] {
        for signs in [[1.0, 1.0], [1.0, -1.0], [-1.0, 1.0], [-1.0, -1.0]] {
            let a = to.axes.column(order[0]) * signs[0];
            let b = to.axes.column(order[1]) * signs[1];
            let target = Matrix3::from_columns(&[a, b, a.cross(&b)]);
            rotations.push(target * from.axes.transpose());
        }
    }
    rotations.extend((0..ROTATIONS).map(spiral_rotation));
    let size = to.radius / from.radius.max(f64::MIN_POSITIVE);
    let similar = |rotation: &Matrix3<f64>, factor: &f64| {
        let scale = size * factor;
        Similarity::new(*rotation, scale, to.middle - rotation * from.middle * scale)
    };
    rotations.iter().flat_map(|r| RELATIVE_SCALES.iter().map(move |f| similar(r, f))).collect()
}

/// Rotation `i` of a super-Fibonacci spiral over all rotations (Alexa 2022).
fn spiral_rotation(i: usize) -> Matrix3<f64> {
    const PSI: f64 = 1.533_751_168_755_204_3;
    let s = i as f64 + 0.5;
    let t = s / ROTATIONS as f64;
    let angle = std::f64::consts::TAU * s;
    let (inner, outer) = (t.sqrt(), (1.0 - t).sqrt());
    let (sa, ca) = (angle / std::f64::consts::SQRT_2).sin_cos();
    let (sb, cb) = (angle / PSI).sin_cos();
    let q = Quaternion::new(outer * cb, inner * sa, inner * ca, outer * sb);
    UnitQuaternion::from_quaternion(q).to_rotation_matrix().into_inner()
}

/// Middle, principal axes and root mean square radius of a cloud.
struct Frame {
    middle: Vec3,
    axes: Matrix3<f64>,
    radius: f64,
}

impl Frame {
    fn of(points: &[Vec3]) -> Self {
        let n = points.len().max(1) as f64;
        let middle = points.iter().sum::<Vec3>() / n;
        let spread: Matrix3<f64> =
            points.iter().map(|p| (p - middle) * (p - middle).transpose()).sum();
        let radius = (spread.trace() / n).sqrt();
        let mut axes = spread.symmetric_eigen().eigenvectors;
        // Right-handed, or no rotation lays one frame onto the other.
        if axes.determinant() < 0.0 {
            axes.column_mut(2).neg_mut();
        }
        Self { middle, axes, radius }
    }
}
