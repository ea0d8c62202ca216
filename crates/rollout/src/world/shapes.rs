//! Shapes of a request as the engine knows them: in the coordinates of what carries them, grown by
//! their margin.

use std::sync::Arc;

use bendtwin_core::{
    Point,
    geometry::{add, dot},
};
use bendtwin_engine::world::{Face, Shape};
use bendtwin_proto::v1::{Collider, collider::Shape as Wire};

use super::hull::hull;
use crate::{error::Error, request::quaternion::Quaternion};

/// The shape of the `index`-th collider of a checked request.
pub(super) fn read(wire: &Collider, index: usize) -> Result<Shape, Error> {
    let placed = ShapePose::of(&wire.pose);
    let margin = wire.margin_m;
    Ok(match &wire.shape {
        None => return Err(Error::field(format!("world.colliders[{index}].shape"), "is missing")),
        Some(Wire::Sphere(sphere)) => {
            let center = placed.point(three(&sphere.center));
            Shape::Capsule { from: center, to: center, radius_m: sphere.radius_m + margin }
        }
        Some(Wire::Capsule(capsule)) => Shape::Capsule {
            from: placed.point(three(&capsule.from)),
            to: placed.point(three(&capsule.to)),
            radius_m: capsule.radius_m + margin,
        },
        Some(Wire::Cuboid(cuboid)) => {
            let faces = sides(three(&cuboid.low), three(&cuboid.high));
            placed.convex(&faces, margin)
        }
        Some(Wire::ConvexMesh(mesh)) => {
            let field = format!("world.colliders[{index}].convex_mesh.points");
            let (_, points) = mesh.points.clone().unwrap_or_default().unpack_points(&field)?;
            let faces = hull(&points).map_err(|fault| Error::field(field, fault.to_string()))?;
            placed.convex(&faces, margin)
        }
    })
}

/// Three numbers of a checked request; none are zeros.
pub(crate) fn three(values: &[f32]) -> Point {
    values.try_into().unwrap_or_default()
}

/// Faces of a box along the axes.
pub(crate) fn sides(low: Point, high: Point) -> Vec<Face> {
    let face = |axis: usize, sign: f32, offset_m: f32| {
        let mut normal = [0.0; 3];
        normal[axis] = sign;
        Face { normal, offset_m }
    };
    (0..3).flat_map(|i| [face(i, -1.0, -low[i]), face(i, 1.0, high[i])]).collect()
}

/// Pose of a shape on what carries it.
struct ShapePose {
    position: Point,
    rotation: Quaternion,
}

impl ShapePose {
    fn of(pose: &[f32]) -> Self {
        match *pose {
            [x, y, z, qx, qy, qz, qw] => {
                Self { position: [x, y, z], rotation: Quaternion::of([qx, qy, qz, qw]) }
            }
            _ => Self { position: [0.0; 3], rotation: Quaternion::IDENTITY },
        }
    }

    fn point(&self, p: Point) -> Point {
        add(self.position, self.direction(p))
    }

    fn direction(&self, d: Point) -> Point {
        self.rotation.rotate(d.map(f64::from)).map(|x| x as f32)
    }

    fn convex(&self, faces: &[Face], margin: f32) -> Shape {
        let face = |face: &Face| {
            let normal = self.direction(face.normal);
            Face { normal, offset_m: face.offset_m + dot(normal, self.position) + margin }
        };
        Shape::Convex(Arc::new(faces.iter().map(face).collect()))
    }
}

#[cfg(test)]
mod tests;
