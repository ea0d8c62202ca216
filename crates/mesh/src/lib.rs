//! Triangle meshes of soft objects: what a completion network or CAD gives beside a recording.
//!
//! [`parse()`] reads GLB, OBJ and PLY from hostile bytes under [`Limits`]. A [`Mesh`] gives points
//! on its surface ([`Mesh::sample_surface`]) and inside ([`Mesh::sample_interior`]); [`align()`]
//! brings it onto what cameras observed; [`convex_interior`] fills a cloud without a
//! mesh. Lengths are in the mesh's own unit, which is metres once it is aligned. This crate knows
//! nothing of captures and of files.

mod align;
mod bvh;
mod cloud;
mod convex;
mod error;
mod interior;
mod limits;
mod mesh;
mod orient;
mod parse;
#[cfg(test)]
mod shapes;
mod similarity;
mod surface;
mod winding;
mod write;

pub use align::{Aligned, align};
pub use bvh::{Bvh, Closest};
pub use convex::convex_interior;
pub use error::Error;
pub use limits::Limits;
pub use mesh::Mesh;
pub use parse::parse;
pub use similarity::Similarity;
pub use winding::Solid;
pub use write::write_glb;

type Vec3 = nalgebra::Vector3<f64>;

fn vec3(p: bendtwin_core::Point) -> Vec3 {
    Vec3::new(f64::from(p[0]), f64::from(p[1]), f64::from(p[2]))
}

fn point(v: Vec3) -> bendtwin_core::Point {
    [v.x as f32, v.y as f32, v.z as f32]
}
