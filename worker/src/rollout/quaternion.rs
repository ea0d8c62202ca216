//! Rotations as unit quaternions x, y, z, w.

use bendtwin_core::{Point, geometry::cross};

/// Below this length nothing can be said about the rotation that was meant.
const SHORTEST: f32 = 1e-6;
/// Above this cosine the arc is so short that its chord serves.
const NEARLY_EQUAL: f32 = 0.9995;

/// A rotation; of unit length by construction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Quaternion([f32; 4]);

impl Quaternion {
    /// Normalises; none if there is no direction to normalise.
    pub(super) fn new(xyzw: [f32; 4]) -> Option<Self> {
        // The largest component first, so that squares neither overflow nor vanish.
        let largest = xyzw.iter().fold(0.0f32, |m, c| m.max(c.abs()));
        if !xyzw.iter().all(|c| c.is_finite()) || largest < SHORTEST {
            return None;
        }
        let scaled = xyzw.map(|c| c / largest);
        let length = dot(scaled, scaled).sqrt();
        Some(Self(scaled.map(|c| c / length)))
    }

    /// The opposite rotation.
    pub(super) fn inverse(self) -> Self {
        let [x, y, z, w] = self.0;
        Self([-x, -y, -z, w])
    }

    /// v + 2 w (q x v) + 2 q x (q x v), with q the vector part.
    pub(super) fn rotate(self, v: Point) -> Point {
        let [x, y, z, w] = self.0;
        let q = [x, y, z];
        let t = cross(q, v).map(|c| 2.0 * c);
        let u = cross(q, t);
        [v[0] + w * t[0] + u[0], v[1] + w * t[1] + u[1], v[2] + w * t[2] + u[2]]
    }

    /// Spherical linear interpolation along the shorter arc: `self` at 0, `other` at 1.
    pub(super) fn slerp(self, other: Self, share: f32) -> Self {
        let cosine = dot(self.0, other.0);
        // q and -q are the same rotation: go to the nearer one.
        let (cosine, other) =
            if cosine < 0.0 { (-cosine, other.0.map(|c| -c)) } else { (cosine, other.0) };
        let (a, b) = if cosine > NEARLY_EQUAL {
            (1.0 - share, share)
        } else {
            let angle = cosine.acos();
            let sine = angle.sin();
            (((1.0 - share) * angle).sin() / sine, (share * angle).sin() / sine)
        };
        let mixed = std::array::from_fn(|i| a * self.0[i] + b * other[i]);
        Self::new(mixed).unwrap_or(self)
    }
}

fn dot(a: [f32; 4], b: [f32; 4]) -> f32 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

#[cfg(test)]
mod tests;
