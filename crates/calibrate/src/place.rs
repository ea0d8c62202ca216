//! Rigid motions as nalgebra calculates with them, and as a recording has them.

use bendtwin_capture::raw::Pose;
use nalgebra::Isometry3;
#[cfg(test)]
use nalgebra::{Matrix3, Rotation3, Translation3, UnitQuaternion};

/// A recording's pose, from the camera to the world, as a motion.
#[cfg(test)]
pub(crate) fn motion(pose: &Pose) -> Isometry3<f64> {
    let rotation = Matrix3::from_fn(|i, j| pose.rotation[i][j]);
    let rotation =
        UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(rotation));
    Isometry3::from_parts(Translation3::from(pose.translation), rotation)
}

/// A motion as a recording's pose.
pub(crate) fn pose(motion: &Isometry3<f64>) -> Pose {
    let rotation = motion.rotation.to_rotation_matrix();
    Pose {
        rotation: std::array::from_fn(|i| std::array::from_fn(|j| rotation[(i, j)])),
        translation: motion.translation.vector.into(),
    }
}
