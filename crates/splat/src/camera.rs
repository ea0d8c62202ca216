//! Pinhole cameras.

use crate::{
    Error,
    constants::{MOST_PIXELS, MOST_SIDE_PX, MOST_VALUE},
};

/// Deviation from a rotation up to which a matrix is one; f32 keeps 1e-6.
const ROTATION_TOLERANCE: f32 = 1e-3;

/// True for a finite number that is not absurd.
fn is_within(x: f32) -> bool {
    x.abs() <= MOST_VALUE
}

/// A pinhole camera without distortion. Axes as in OpenCV: x to the right, y down, z forward; the
/// centre of the first pixel is at (0, 0).
///
/// A crop is a camera with a smaller size and a shifted principal point: it gives the same pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// Columns [px].
    pub width: u32,
    /// Rows [px].
    pub height: u32,
    /// Focal length along x [px].
    pub fx: f32,
    /// Focal length along y [px].
    pub fy: f32,
    /// Column of the principal point [px].
    pub cx: f32,
    /// Row of the principal point [px].
    pub cy: f32,
    /// Rigid motion from the world to the camera, row-major, shape [3, 4]: a rotation, and a
    /// translation [m] in the last column.
    pub world_to_camera: [[f32; 4]; 3],
}

impl Camera {
    /// Number of pixels.
    pub fn pixel_count(&self) -> usize {
        self.width as usize * self.height as usize
    }

    /// The part of the image that begins at a column and a row and has this size.
    #[must_use]
    pub fn crop(&self, left: u32, top: u32, width: u32, height: u32) -> Self {
        Self { width, height, cx: self.cx - left as f32, cy: self.cy - top as f32, ..*self }
    }

    /// Checks that sizes are in their ranges, numbers finite and the matrix a rigid motion.
    ///
    /// # Errors
    /// The first parameter that is wrong, with its value.
    pub fn check(&self) -> Result<(), Error> {
        let fail = |what, value, rule| Err(Error::Camera { what, value, rule });
        for (what, side) in [("width", self.width), ("height", self.height)] {
            if side == 0 || side > MOST_SIDE_PX {
                return fail(what, side as f32, "it must be 1 to 16384");
            }
        }
        if self.pixel_count() > MOST_PIXELS {
            let (count, most) = (self.pixel_count(), MOST_PIXELS);
            return Err(Error::TooMany { what: "pixels", count, most });
        }
        for (what, x) in [("fx", self.fx), ("fy", self.fy)] {
            if !(x > 0.0 && x <= MOST_VALUE) {
                return fail(what, x, "it must be positive, up to 1e6");
            }
        }
        for (what, x) in [("cx", self.cx), ("cy", self.cy)] {
            if !is_within(x) {
                return fail(what, x, "it must be finite, up to 1e6");
            }
        }
        let m = &self.world_to_camera;
        if let Some(x) = m.iter().flatten().find(|x| !is_within(**x)) {
            return fail("world_to_camera", *x, "it must be finite, up to 1e6");
        }
        for a in 0..3 {
            for b in 0..3 {
                let product: f32 = (0..3).map(|k| m[a][k] * m[b][k]).sum();
                let expected = if a == b { 1.0 } else { 0.0 };
                if (product - expected).abs() > ROTATION_TOLERANCE {
                    let rule = "products of its rows must be 0, and 1 with themselves: a rotation";
                    return fail("product of rows of world_to_camera", product, rule);
                }
            }
        }
        Ok(())
    }
}
