//! Vectors of space in f64, and the rays of cameras.

use bendtwin_capture::raw::{Camera, Pose};
use bendtwin_core::Environment;

pub(crate) use bendtwin_core::geometry::{
    Vector, add, cross, distance, dot, length, scaled, sub, turn, turn_back, unit, wide,
};

/// From the camera's axes to the world's, in f64.
pub(crate) fn to_world(pose: &Pose, p: Vector) -> Vector {
    add(turn(&pose.rotation, p), pose.translation)
}

/// From the world's axes to the camera's, in f64.
pub(crate) fn to_camera(pose: &Pose, p: Vector) -> Vector {
    turn_back(&pose.rotation, sub(p, pose.translation))
}

/// The point in the camera's axes [m] that appears at a pixel at a depth along the optical axis
/// [m].
pub(crate) fn seen_at(camera: &Camera, pixel: [f64; 2], depth_m: f64) -> Vector {
    let [x, y] = camera.distortion.undistort(camera.intrinsics.plane(pixel));
    [x * depth_m, y * depth_m, depth_m]
}

/// The pixel at which a point in the camera's axes appears; `None` behind the camera.
pub(crate) fn pixel_of(camera: &Camera, p: Vector) -> Option<[f64; 2]> {
    // NaN is not in front either.
    if p[2].is_nan() || p[2] <= 1e-6 {
        return None;
    }
    Some(camera.intrinsics.pixel(camera.distortion.distort([p[0] / p[2], p[1] / p[2]])))
}

/// Heights over the ground; without one, along the direction against gravity from the origin.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Upright {
    pub(crate) up: Vector,
    pub(crate) offset_m: f64,
    /// True if there is a ground.
    pub(crate) grounded: bool,
}

impl Upright {
    pub(crate) fn of(environment: &Environment) -> Self {
        let against = unit(wide(environment.gravity).map(|g| -g)).unwrap_or([0.0, 0.0, 1.0]);
        match environment.ground {
            Some(ground) => Self {
                up: unit(wide(ground.normal)).unwrap_or(against),
                offset_m: f64::from(ground.offset_m),
                grounded: true,
            },
            None => Self { up: against, offset_m: 0.0, grounded: false },
        }
    }

    pub(crate) fn height(&self, p: Vector) -> f64 {
        dot(self.up, p) - self.offset_m
    }
}
