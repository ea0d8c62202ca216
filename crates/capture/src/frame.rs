//! Coordinate frames: every capture is turned so that z points up and scaled to
//! metres when it is read.

use bendtwin_core::{Point, geometry::IDENTITY};

use crate::Error;

/// A rotation and a scale from a source's frame to the world's.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Frame {
    /// Row-major.
    pub(crate) rotation: [[f32; 3]; 3],
    /// Metres per unit of the source.
    pub(crate) metres: f32,
}

impl Frame {
    /// The rotation that turns an axis such as `+y` up, by the shortest way.
    pub(crate) fn from_up(axis: &str) -> Option<Self> {
        let rotation = match axis {
            "+z" | "z" => IDENTITY,
            // About x by pi, as PhysTwin's world needs: y and z change sign.
            "-z" => [[1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, -1.0]],
            "+y" | "y" => [[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]],
            "-y" => [[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]],
            "+x" | "x" => [[0.0, 0.0, -1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]],
            "-x" => [[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]],
            _ => return None,
        };
        Some(Self { rotation, metres: 1.0 })
    }

    /// The frame of a document's `up_axis`, see [`Frame::from_up`].
    ///
    /// # Errors
    /// If it is no axis.
    pub(crate) fn of_up_axis(axis: &str) -> Result<Self, Error> {
        Self::from_up(axis).ok_or_else(|| {
            Error::Axes(format!("`up_axis` is `{axis}`: it must be one of +x, -x, +y, -y, +z, -z"))
        })
    }

    /// Metres per unit.
    pub(crate) fn metres_per(units: &str) -> Result<f32, Error> {
        match units {
            "m" => Ok(1.0),
            "cm" => Ok(0.01),
            "mm" => Ok(0.001),
            other => Err(Error::Units(other.chars().take(40).collect())),
        }
    }

    /// Metres per unit in double precision: 0.001, not the f32 next to it.
    pub(crate) fn metres_per_unit(&self) -> f64 {
        (f64::from(self.metres) * 1e6).round() / 1e6
    }

    /// Turns a direction.
    pub(crate) fn turn(&self, v: Point) -> Point {
        self.rotation.map(|row| row[0] * v[0] + row[1] * v[1] + row[2] * v[2])
    }

    /// Turns and scales points in place.
    pub(crate) fn apply(&self, points: &mut [Point]) {
        if self.metres == 1.0 && self.rotation == IDENTITY {
            return;
        }
        for p in points {
            *p = self.turn(*p).map(|x| x * self.metres);
        }
    }
}

/// The product of two rotations: `b` first.
pub(crate) fn compose(a: &[[f32; 3]; 3], b: &[[f32; 3]; 3]) -> [[f32; 3]; 3] {
    std::array::from_fn(|i| std::array::from_fn(|j| (0..3).map(|k| a[i][k] * b[k][j]).sum()))
}

/// `true` for a rotation, `false` for a reflection (left-handed frame).
pub(crate) fn is_rotation(m: &[[f32; 3]; 3]) -> bool {
    let dot = |a: &Point, b: &Point| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    let near = |x: f32, y: f32| (x - y).abs() < 1e-3;
    let orthonormal =
        (0..3).all(|i| (0..3).all(|j| near(dot(&m[i], &m[j]), if i == j { 1.0 } else { 0.0 })));
    orthonormal && near(determinant(m), 1.0)
}

/// +1 for a rotation, -1 for a reflection.
pub(crate) fn determinant(m: &[[f32; 3]; 3]) -> f32 {
    m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1])
        - m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0])
        + m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0])
}

#[cfg(test)]
mod tests;
