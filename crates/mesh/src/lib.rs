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

use bendtwin_core::geometry::{point, vector3 as vec3};

type Vec3 = nalgebra::Vector3<f64>;
