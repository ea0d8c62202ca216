//! Rays of cameras.

use bendtwin_capture::raw::Camera;
use bendtwin_core::geometry::{Vector, add, scaled, sub, turn, wide};

/// Precision of a pixel's ray.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Precision {
    /// Single: through the point that [`Camera::unproject`] gives, so that image and lifted
    /// points agree to the last digit.
    Single,
    /// Double, for comparisons of cameras.
    Double,
}

/// A ray through a pixel. Its parameter is the depth along the camera's optical axis [m].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// The camera's centre [m].
    pub origin: Vector,
    /// Direction whose part along the optical axis is 1.
    pub direction: Vector,
}

impl Ray {
    /// The ray through a pixel (column, row) of a camera in a frame.
    pub fn through(camera: &Camera, pixel: [f64; 2], frame: usize, precision: Precision) -> Self {
        let pose = camera.pose(frame);
        let origin = pose.translation;
        let direction = match precision {
            Precision::Single => sub(wide(camera.unproject(pixel, 1.0, frame)), origin),
            Precision::Double => {
                let [x, y] = camera.distortion.undistort(camera.intrinsics.plane(pixel));
                turn(&pose.rotation, [x, y, 1.0])
            }
        };
        Self { origin, direction }
    }

    /// Point of the world at a depth [m].
    pub fn at(&self, depth_m: f64) -> Vector {
        add(self.origin, scaled(self.direction, depth_m))
    }
}
