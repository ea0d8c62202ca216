//! The CUDA backend. Whole batches are simulated by persistent kernels, compiled for the device at
//! run time; nothing of CUDA is needed to build or to start this crate.
//!
//! `kernels/` has the physics, file by file as the CPU backend: a kernel advances all substeps of
//! many frames without returning, and another goes backward along a tape. `device` is what talks to
//! CUDA: memory, streams, compiled kernels and their launches. `plan` decides what to launch:
//! graphs cut for teams of blocks, the team for a batch, room for tapes. `run` runs it: frames
//! forward, gradients backward, objectives, the optimiser, and the backend over them. `splat` draws
//! Gaussians. A folder uses those before it only, and `splat` only `device`.

// The one crate that talks to a C interface. Every `unsafe` says why it is sound.
#![allow(unsafe_code)]

mod device;
mod plan;
mod preparation;
mod run;
mod splat;

use std::{path::PathBuf, sync::Arc};

use bendtwin_engine::{Backend, Error};

pub use self::{
    preparation::{Chip, Prepared, prepare},
    splat::CudaRasteriser,
};

/// Settings of a device.
#[derive(Clone, Debug, Default)]
pub struct Options {
    /// The device's index, as CUDA counts them.
    pub ordinal: usize,
    /// Folder that keeps compiled kernels between runs; the user's cache directory if `None`.
    pub cache_dir: Option<PathBuf>,
    /// Device memory that may be used [bytes]; nine tenths of what is free if `None`.
    pub memory_limit: Option<u64>,
    /// Use only this kind of team of blocks, for comparisons: `block`, `block4` (instances in it),
    /// `cluster16`, `grid66` (blocks); the best for each batch if `None`.
    pub team: Option<String>,
}

/// A backend on a CUDA device.
///
/// # Errors
/// [`Error::Device`] with one line that says what is missing: a driver, NVRTC, or a device.
pub fn cuda(options: &Options) -> Result<Arc<dyn Backend>, Error> {
    let device = device::Device::open(options)?;
    Ok(Arc::new(run::backend::CudaBackend::new(&device)))
}
