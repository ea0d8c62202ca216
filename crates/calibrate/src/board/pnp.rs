//! The pose of a camera that sees a flat board: from the homography of the board's plane, refined on
//! pixels.

use nalgebra::{Isometry3, Matrix3, Rotation3, Translation3, UnitQuaternion, Vector3};

use super::{
    adjust::{Observation, Poses},
    homography::Homography,
};
use crate::lens::Lens;

/// Least corners for a pose.
pub(crate) const MIN_CORNERS: usize = 6;

/// The motion from the board to the camera. Of the two poses in which a plane looks nearly alike (Collins and Bartoli, *Infinitesimal plane-based pose
/// estimation*, 2014) that which fits better. `None` for too few corners, or corners in a line.
pub(crate) fn pose(
    lens: &Lens,
    points: &[[f64; 2]],
    pixels: &[[f64; 2]],
) -> Option<Isometry3<f64>> {
    if points.len() < MIN_CORNERS {
        return None;
    }
    let rays: Vec<[f64; 2]> = pixels.iter().map(|at| lens.ray(*at)).collect();
    let start = decomposed(&Homography::of(points, &rays)?)?;
    let seen: Vec<Observation> = points
        .iter()
        .zip(pixels)
        .map(|(point, at)| Observation { camera: 0, board: 0, point: *point, at: *at, weight: 1.0 })
        .collect();
    let refined = |start: Isometry3<f64>| {
        let mut poses = Poses { cameras: vec![start], boards: vec![Isometry3::identity()] };
        let rms = poses.adjust(&[*lens], &seen);
        let pose = poses.cameras[0];
        let finite = pose.to_homogeneous().iter().all(|x| x.is_finite());
        // The printed side faces the camera.
        let facing = (pose.rotation * Vector3::z()).dot(&pose.translation.vector) < 0.0;
        (finite && facing && pose.translation.z > 0.0 && rms.is_finite()).then_some((pose, rms))
    };
    let first = refined(start);
    let other = tilted(&first.map_or(start, |(pose, _)| pose)).and_then(refined);
    let best = first.into_iter().chain(other).min_by(|a, b| a.1.total_cmp(&b.1));
    best.map(|(pose, _)| pose)
}

/// The pose of a plane at z = 0 whose homography to the normalised image plane is known.
fn decomposed(plane: &Homography) -> Option<Isometry3<f64>> {
    let [a, b, c] = [0, 1, 2].map(|k| Vector3::from(plane.0.column(k)));
    let mut scale = 2.0 / (a.norm() + b.norm());
    if c.z < 0.0 {
        scale = -scale;
    }
    let (x, y) = (a * scale, b * scale);
    let matrix = Matrix3::from_columns(&[x, y, x.cross(&y)]);
    let svd = matrix.svd(true, true);
    let rotation = svd.u? * svd.v_t?;
    if rotation.determinant() < 0.5 {
        return None;
    }
    let rotation =
        UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(rotation));
    let pose = Isometry3::from_parts(Translation3::from(c * scale), rotation);
    pose.to_homogeneous().iter().all(|x| x.is_finite()).then_some(pose)
}

/// The pose with the board's normal on the other side of the line of sight.
fn tilted(pose: &Isometry3<f64>) -> Option<Isometry3<f64>> {
    let sight = pose.translation.vector.normalize();
    let normal = pose.rotation * Vector3::z();
    let other = sight * (2.0 * normal.dot(&sight)) - normal;
    let turn = UnitQuaternion::rotation_between(&normal, &other)?;
    Some(Isometry3::from_parts(pose.translation, turn * pose.rotation))
}
