//! Rotation, uniform scale and translation.

use bendtwin_core::Point;
use nalgebra::Matrix3;

use crate::{Vec3, point, vec3};

/// A similarity: `x` becomes `scale · rotation · x + translation`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Similarity {
    /// Rotation, row-major.
    pub rotation: [[f64; 3]; 3],
    /// Metres per unit.
    pub scale: f64,
    /// Translation [m].
    pub translation: [f64; 3],
}

impl Similarity {
    /// The identity.
    pub const IDENTITY: Self = Self {
        rotation: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
        scale: 1.0,
        translation: [0.0; 3],
    };

    /// The image of a point.
    pub fn apply(&self, p: Point) -> Point {
        point(self.map(vec3(p)))
    }

    pub(crate) fn new(rotation: Matrix3<f64>, scale: f64, translation: Vec3) -> Self {
        Self {
            rotation: std::array::from_fn(|i| std::array::from_fn(|j| rotation[(i, j)])),
            scale,
            translation: translation.into(),
        }
    }

    pub(crate) fn matrix(&self) -> Matrix3<f64> {
        Matrix3::from_fn(|i, j| self.rotation[i][j])
    }

    pub(crate) fn map(&self, x: Vec3) -> Vec3 {
        self.matrix() * x * self.scale + Vec3::from(self.translation)
    }

    /// The point that is mapped to `y`.
    pub(crate) fn apply_inverse(&self, y: Vec3) -> Vec3 {
        self.matrix().tr_mul(&(y - Vec3::from(self.translation))) / self.scale
    }
}
