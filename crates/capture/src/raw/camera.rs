//! A calibrated camera: OpenCV's axes (x right, y down, z into the scene) and pixel convention (the
//! centre of the first pixel is (0, 0)).

use bendtwin_core::Point;

use crate::{Error, frame::Frame};

/// A calibrated camera with colour and aligned depth.
#[derive(Clone, Debug, PartialEq)]
pub struct Camera {
    /// A person's name for it: a serial number, say.
    pub name: String,
    /// Columns of its images.
    pub width: usize,
    /// Rows of its images.
    pub height: usize,
    /// The pinhole.
    pub intrinsics: Intrinsics,
    /// Distortion by the lens.
    pub distortion: Distortion,
    /// From the camera to the world: one for a camera that stands, or one for each frame; empty if no
    /// camera of the recording is calibrated.
    pub poses: Vec<Pose>,
    /// When each frame was taken, seconds on a clock that all cameras share, NaN for frames that
    /// are missing, shape [T]; empty if the recording has no times.
    pub times_s: Vec<f64>,
    /// Frames per second of this camera, if it is known to be lower than that of the recording: the
    /// frames between have no images of it.
    pub fps: Option<f64>,
}

/// A pinhole in pixels: `u = fx x/z + cx`, `v = fy y/z + cy`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Intrinsics {
    /// Focal length in columns.
    pub fx: f64,
    /// Focal length in rows.
    pub fy: f64,
    /// Column of the principal point.
    pub cx: f64,
    /// Row of the principal point.
    pub cy: f64,
}

/// Lens distortion, with OpenCV's coefficients.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Distortion {
    /// No distortion.
    #[default]
    None,
    /// Radial and tangential, rational: k1, k2, p1, p2, k3, k4, k5, k6.
    BrownConrady([f64; 8]),
    /// Fisheye: k1, k2, k3, k4.
    KannalaBrandt([f64; 4]),
}

/// A camera's place in the world: `x_world = rotation · x_camera + translation`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose {
    /// Rotation, row-major.
    pub rotation: [[f64; 3]; 3],
    /// Translation [m].
    pub translation: [f64; 3],
}

impl Camera {
    /// The pixel at which a point of the world appears, as column and row, and its depth along the
    /// optical axis [m]. `None` behind the camera. It may lie outside the image.
    pub fn project(&self, point: Point, frame: usize) -> Option<([f64; 2], f64)> {
        let [x, y, z] = self.pose(frame).from_world(point);
        if z <= 1e-6 {
            return None;
        }
        Some((self.intrinsics.pixel(self.distortion.distort([x / z, y / z])), z))
    }

    /// The point of the world [m] that appears at a pixel (column, row) at a depth along the
    /// optical axis [m].
    pub fn unproject(&self, pixel: [f64; 2], depth_m: f64, frame: usize) -> Point {
        let [x, y] = self.distortion.undistort(self.intrinsics.plane(pixel));
        self.pose(frame).to_world([x * depth_m, y * depth_m, depth_m])
    }

    /// Pose in a frame; [`Pose::IDENTITY`] if the camera is not calibrated.
    pub fn pose(&self, frame: usize) -> &Pose {
        self.poses.get(frame).or(self.poses.first()).unwrap_or(&Pose::IDENTITY)
    }
}

impl Intrinsics {
    /// The pixel (column, row) of a place on the plane at depth 1.
    pub fn pixel(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        [self.fx * x + self.cx, self.fy * y + self.cy]
    }

    /// The place on the plane at depth 1 of a pixel (column, row).
    pub fn plane(&self, [column, row]: [f64; 2]) -> [f64; 2] {
        [(column - self.cx) / self.fx, (row - self.cy) / self.fy]
    }
}

impl Distortion {
    /// From 4, 5 or 8 coefficients in OpenCV's order; none where all are zero. `None` for another
    /// number of them.
    pub(super) fn brown_conrady(coefficients: &[f64]) -> Option<Self> {
        if !matches!(coefficients.len(), 0 | 4 | 5 | 8) {
            return None;
        }
        let mut all = [0.0; 8];
        all.iter_mut().zip(coefficients).for_each(|(k, c)| *k = *c);
        Some(if all == [0.0; 8] { Self::None } else { Self::BrownConrady(all) })
    }

    /// Place on the normalised image plane at which a ray through (x, y) at depth 1 appears.
    pub fn distort(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        match self {
            Self::None => [x, y],
            Self::BrownConrady([k1, k2, p1, p2, k3, k4, k5, k6]) => {
                let r2 = x * x + y * y;
                let radial = (1.0 + r2 * (k1 + r2 * (k2 + r2 * k3)))
                    / (1.0 + r2 * (k4 + r2 * (k5 + r2 * k6)));
                [
                    x * radial + 2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x),
                    y * radial + p1 * (r2 + 2.0 * y * y) + 2.0 * p2 * x * y,
                ]
            }
            Self::KannalaBrandt([k1, k2, k3, k4]) => {
                let r = x.hypot(y);
                if r < 1e-9 {
                    return [x, y];
                }
                let angle = r.atan();
                let a2 = angle * angle;
                let bent = angle * (1.0 + a2 * (k1 + a2 * (k2 + a2 * (k3 + a2 * k4))));
                [x * bent / r, y * bent / r]
            }
        }
    }

    /// The inverse of [`Distortion::distort`], to 1e-9 within the image of any usable lens.
    pub fn undistort(&self, [u, v]: [f64; 2]) -> [f64; 2] {
        if *self == Self::None {
            return [u, v];
        }
        // Newton's method with a numerical Jacobian: fixed-point iteration does not converge at the
        // rim of wide lenses.
        let mut at = [u, v];
        for _ in 0..20 {
            let here = self.distort(at);
            let fault = [u - here[0], v - here[1]];
            if fault[0].hypot(fault[1]) < 1e-12 {
                break;
            }
            const STEP: f64 = 1e-6;
            let right = self.distort([at[0] + STEP, at[1]]);
            let down = self.distort([at[0], at[1] + STEP]);
            let j = [
                [(right[0] - here[0]) / STEP, (down[0] - here[0]) / STEP],
                [(right[1] - here[1]) / STEP, (down[1] - here[1]) / STEP],
            ];
            let determinant = j[0][0] * j[1][1] - j[0][1] * j[1][0];
            if determinant.abs() < 1e-12 {
                break;
            }
            at[0] += (j[1][1] * fault[0] - j[0][1] * fault[1]) / determinant;
            at[1] += (j[0][0] * fault[1] - j[1][0] * fault[0]) / determinant;
        }
        at
    }
}

/// How messages call a camera: `camera 2 (front)`, or `camera 2` if its name is its number.
pub fn called(index: usize, name: &str) -> String {
    if name.is_empty() || name == index.to_string() {
        format!("camera {index}")
    } else {
        format!("camera {index} ({name})")
    }
}

impl Pose {
    /// A camera at the world's origin that looks along z, x to the right and y down.
    pub const IDENTITY: Self = Self {
        rotation: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
        translation: [0.0; 3],
    };

    /// From a quaternion x, y, z, w of any length; not a number if it has none.
    pub(super) fn from_quaternion(quaternion: [f64; 4], translation: [f64; 3]) -> Self {
        let length = quaternion.iter().map(|q| q * q).sum::<f64>().sqrt();
        let [x, y, z, w] = quaternion.map(|q| q / length);
        let rotation = [
            [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - z * w), 2.0 * (x * z + y * w)],
            [2.0 * (x * y + z * w), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - x * w)],
            [2.0 * (x * z - y * w), 2.0 * (y * z + x * w), 1.0 - 2.0 * (x * x + y * y)],
        ];
        Self { rotation, translation }
    }

    /// A share of the way from one pose to another, given as translations and unit quaternions x, y, z, w
    /// of poses near each other: the chord between quaternions stands for the arc.
    pub(super) fn between([from, to]: [&([f64; 3], [f64; 4]); 2], share: f64) -> Self {
        let mix = |a: f64, b: f64| a + share * (b - a);
        // A quaternion and its negative are the same rotation.
        let dot: f64 = from.1.iter().zip(&to.1).map(|(a, b)| a * b).sum();
        let sign = if dot < 0.0 { -1.0 } else { 1.0 };
        let quaternion = std::array::from_fn(|i| mix(from.1[i], sign * to.1[i]));
        let translation = std::array::from_fn(|i| mix(from.0[i], to.0[i]));
        Self::from_quaternion(quaternion, translation)
    }

    /// `true` if no number of it is infinite or not a number.
    pub(super) fn is_finite(&self) -> bool {
        self.rotation.iter().flatten().chain(&self.translation).all(|x| x.is_finite())
    }

    /// The motion that does `first`, then this.
    #[must_use]
    pub fn after(&self, first: &Self) -> Self {
        Self {
            rotation: std::array::from_fn(|i| {
                std::array::from_fn(|j| {
                    (0..3).map(|k| self.rotation[i][k] * first.rotation[k][j]).sum()
                })
            }),
            translation: self.moved(first.translation),
        }
    }

    /// The motion that undoes this.
    #[must_use]
    pub fn inverse(&self) -> Self {
        let r = &self.rotation;
        let rotation: [[f64; 3]; 3] = std::array::from_fn(|i| std::array::from_fn(|j| r[j][i]));
        let back = Self { rotation, translation: [0.0; 3] };
        Self { rotation, translation: back.moved(self.translation).map(|x| -x) }
    }

    /// Where the motion takes a place.
    pub fn moved(&self, p: [f64; 3]) -> [f64; 3] {
        let r = &self.rotation;
        std::array::from_fn(|i| {
            r[i][0] * p[0] + r[i][1] * p[1] + r[i][2] * p[2] + self.translation[i]
        })
    }

    /// From the rows of a matrix of 4 x 4, whose last is 0, 0, 0, 1, or of 3 x 4, which lacks it.
    pub(super) fn from_rows(camera: &str, m: &[[f64; 4]]) -> Result<Self, Error> {
        let fail = |fault: String| Err(Error::Camera { camera: camera.to_owned(), fault });
        let (upper, last) = m.split_at(m.len().min(3));
        let (&[a, b, c], [] | [_]) = (upper, last) else {
            return fail(format!("its pose has {} rows of 4 numbers: 3 or 4 are needed", m.len()));
        };
        if let Some(last) = last.first().filter(|last| **last != [0.0, 0.0, 0.0, 1.0]) {
            return fail(format!(
                "the last row of its pose is {last:?} and not [0, 0, 0, 1]: write camera-to-world, row-major"
            ));
        }
        Ok(Self {
            rotation: [a, b, c].map(|row| [row[0], row[1], row[2]]),
            translation: [a, b, c].map(|row| row[3]),
        })
    }

    /// The camera at the same place after a change of the world's axes and units.
    pub(super) fn turned(&self, frame: &Frame) -> Self {
        let turn = frame.rotation.map(|row| row.map(f64::from));
        let times = |column: [f64; 3]| {
            turn.map(|row| row[0] * column[0] + row[1] * column[1] + row[2] * column[2])
        };
        let columns: [[f64; 3]; 3] =
            std::array::from_fn(|j| times(self.rotation.map(|row| row[j])));
        Self {
            rotation: std::array::from_fn(|i| std::array::from_fn(|j| columns[j][i])),
            translation: times(self.translation).map(|x| x * frame.metres_per_unit()),
        }
    }

    /// From the camera's axes to the world's.
    pub fn to_world(&self, p: [f64; 3]) -> Point {
        let r = &self.rotation;
        std::array::from_fn(|i| {
            (r[i][0] * p[0] + r[i][1] * p[1] + r[i][2] * p[2] + self.translation[i]) as f32
        })
    }

    /// From the world's axes to the camera's.
    pub fn from_world(&self, p: Point) -> [f64; 3] {
        let r = &self.rotation;
        let d: [f64; 3] = std::array::from_fn(|i| f64::from(p[i]) - self.translation[i]);
        std::array::from_fn(|j| r[0][j] * d[0] + r[1][j] * d[1] + r[2][j] * d[2])
    }
}

#[cfg(test)]
mod tests;
