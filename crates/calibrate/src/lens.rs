//! A camera's lens: from places in front of it to pixels, with derivatives.

use bendtwin_capture::raw::{Camera, Distortion, Intrinsics};
use nalgebra::{Matrix2x3, Vector2, Vector3};

/// Pinhole and distortion of a camera.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Lens {
    pub(crate) intrinsics: Intrinsics,
    pub(crate) distortion: Distortion,
}

/// Step of numerical derivatives on the normalised image plane.
const STEP: f64 = 1e-6;

impl Lens {
    pub(crate) fn of(camera: &Camera) -> Self {
        Self { intrinsics: camera.intrinsics, distortion: camera.distortion }
    }

    /// The pixel at which a place in the camera's axes [m] appears; `None` behind the camera.
    pub(crate) fn pixel(&self, p: Vector3<f64>) -> Option<[f64; 2]> {
        if p.z.is_nan() || p.z <= 1e-6 {
            return None;
        }
        Some(self.intrinsics.pixel(self.distortion.distort([p.x / p.z, p.y / p.z])))
    }

    /// Derivative of the pixel by the place [px/m]; `None` behind the camera.
    pub(crate) fn jacobian(&self, p: Vector3<f64>) -> Option<Matrix2x3<f64>> {
        if p.z.is_nan() || p.z <= 1e-6 {
            return None;
        }
        let [x, y] = [p.x / p.z, p.y / p.z];
        let bent = |dx: f64, dy: f64| Vector2::from(self.distortion.distort([x + dx, y + dy]));
        let by_x = (bent(STEP, 0.0) - bent(-STEP, 0.0)) / (2.0 * STEP);
        let by_y = (bent(0.0, STEP) - bent(0.0, -STEP)) / (2.0 * STEP);
        let i = &self.intrinsics;
        let flat = Matrix2x3::new(1.0, 0.0, -x, 0.0, 1.0, -y) / p.z;
        Some(Matrix2x3::from_fn(|row, column| {
            let focal = if row == 0 { i.fx } else { i.fy };
            focal * (by_x[row] * flat[(0, column)] + by_y[row] * flat[(1, column)])
        }))
    }

    /// The place at depth 1 that appears at a pixel.
    pub(crate) fn ray(&self, at: [f64; 2]) -> [f64; 2] {
        self.distortion.undistort(self.intrinsics.plane(at))
    }
}
