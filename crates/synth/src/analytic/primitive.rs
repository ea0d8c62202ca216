//! Shapes that a ray meets in closed form.

use bendtwin_core::geometry::{Vector, dot, sub, turn_back};

use super::Ray;

/// A shape at its place in the world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Primitive {
    /// A flat rectangle across its own z axis, seen from both sides.
    Rectangle {
        /// Centre [m].
        center: Vector,
        /// Rotation from its own axes to the world's, row-major.
        rotation: [[f64; 3]; 3],
        /// Half the sides along its own x and y [m].
        half_sides_m: [f64; 2],
    },
    /// A sphere, seen from outside.
    Sphere {
        /// Centre [m].
        center: Vector,
        /// Radius [m].
        radius_m: f64,
    },
    /// An ellipsoid, seen from outside.
    Ellipsoid {
        /// Centre [m].
        center: Vector,
        /// Rotation from its own axes to the world's, row-major.
        rotation: [[f64; 3]; 3],
        /// Half the lengths along its own axes [m].
        half_axes_m: Vector,
    },
    /// The plane z = 0, seen from above.
    Ground,
}

impl Primitive {
    /// Depth [m] at which a ray meets the shape first; `None` if the ray misses.
    pub fn depth_m(&self, ray: &Ray) -> Option<f64> {
        match *self {
            Self::Rectangle { center, rotation, half_sides_m: [width, height] } => {
                let normal = rotation.map(|row| row[2]);
                let depth = dot(normal, sub(center, ray.origin)) / dot(normal, ray.direction);
                let [x, y, _] = self.local(ray.at(depth));
                (depth > 0.0 && x.abs() < width && y.abs() < height).then_some(depth)
            }
            Self::Sphere { center, radius_m } => {
                sphere(sub(ray.origin, center), ray.direction, radius_m)
            }
            Self::Ellipsoid { rotation, half_axes_m, .. } => {
                // In axes in which the ellipsoid is a unit sphere; the parameter stays the depth.
                let turned = turn_back(&rotation, ray.direction);
                let direction = std::array::from_fn(|a| turned[a] / half_axes_m[a]);
                sphere(self.local(ray.origin), direction, 1.0)
            }
            Self::Ground => {
                let downwards = ray.direction[2] < -1e-9;
                downwards.then(|| -ray.origin[2] / ray.direction[2]).filter(|t| *t > 0.0)
            }
        }
    }

    /// Coordinates of a point of the world in the shape's own axes, from its centre, for textures
    /// [m]; as shares of the half axes of an ellipsoid. Spheres and the ground have the world's
    /// axes.
    pub fn local(&self, at: Vector) -> Vector {
        match *self {
            Self::Rectangle { center, rotation, .. } => turn_back(&rotation, sub(at, center)),
            Self::Sphere { center, .. } => sub(at, center),
            Self::Ellipsoid { center, rotation, half_axes_m } => {
                let turned = turn_back(&rotation, sub(at, center));
                std::array::from_fn(|a| turned[a] / half_axes_m[a])
            }
            Self::Ground => at,
        }
    }
}

/// Parameter at which a ray enters a sphere around the origin.
fn sphere(origin: Vector, direction: Vector, radius: f64) -> Option<f64> {
    let (a, b) = (dot(direction, direction), dot(origin, direction));
    let c = dot(origin, origin) - radius * radius;
    let root = b * b - a * c;
    (root > 0.0).then(|| (-b - root.sqrt()) / a).filter(|t| *t > 0.0)
}
