//! Gaussian splats: images of sets of Gaussians, and gradients of losses of images.
//!
//! [`Rasteriser`] is one coarse interface with two implementations: [`Cpu`] here, which defines the
//! correct result, and the one of `crates/cuda`. `tests/kits/splat` holds both to a plain second
//! implementation in f64. [`Carrier`] moves Gaussians with the nodes of a twin. Training, losses and
//! files belong to others.

mod camera;
mod carry;
pub mod constants;
mod cpu;
mod error;
mod gaussians;
mod image;
mod rasteriser;
mod scan;

pub use self::{
    camera::Camera,
    carry::{Carried, Carrier},
    cpu::Cpu,
    error::Error,
    gaussians::{Gaussians, GaussiansBar},
    image::{Image, ImageBar},
    rasteriser::{OpenRasteriser, Rasteriser, check_input},
};
