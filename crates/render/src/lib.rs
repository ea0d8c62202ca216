//! Pictures of objects: a surface in its colours, points, or Gaussians.
//!
//! - [`draw`] draws a [`Scene`] as a pinhole camera sees it: a [`Posed`] surface or an image of Gaussians, rigid
//!   [`Prop`]s and a background, with depths and labels.
//! - [`thumbnail`] draws small pictures for lists, seen obliquely from above.
//!
//! Both share one raster: four samples a pixel, the nearest wins, and a pixel is the mean of its samples' light.
//! The same input gives the same bits on every machine: nothing is random, and no sum depends on the number of threads.

mod light;
mod mesh;
mod picture;
mod raster;
mod solid;
pub mod thumbnail;

pub use self::{
    light::Light,
    mesh::{Mesh, Posed},
    picture::{Background, Object, Picture, Scene, Wanted, draw, scratch_bytes},
    solid::{Face, Pose, Prop, Solid},
};
