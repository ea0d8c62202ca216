//! The CUDA backend. Whole batches are simulated by persistent kernels, compiled for the device at
//! run time; nothing of CUDA is needed to build or to start this crate.
//!
//! `kernels/` has the physics, file by file as the CPU backend: a kernel advances all substeps of many frames
//! without returning, and another goes backward along a tape. `team.rs` says how many blocks simulate an
//! instance and how they meet, `layout.rs` cuts a graph for them, `simulation.rs` runs frames forward,
//! `backward.rs` gradients, `descent.rs` the optimiser, `scoring.rs` objectives.

// The one crate that talks to a C interface. Every `unsafe` says why it is sound.
#![allow(unsafe_code)]

mod backend;
mod backward;
mod cache;
mod compile;
mod descent;
mod device;
mod graph;
mod graphs;
mod group;
mod job;
mod kernel;
mod launch;
mod layout;
mod memo;
mod memory;
mod objective;
mod pace;
mod partition;
mod queue;
mod recording;
mod resident;
mod scoring;
mod simulation;
mod staging;
mod tape;
mod team;

use std::{path::PathBuf, sync::Arc};

use bendtwin_engine::{Backend, Error};
use cudarc::driver::{CudaStream, DriverError};

/// How to use a device.
#[derive(Clone, Debug, Default)]
pub struct Options {
    /// Which device, as CUDA counts them.
    pub ordinal: usize,
    /// Where compiled kernels are kept between runs; the user's cache directory if `None`.
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
    Ok(Arc::new(backend::CudaBackend::new(&device)))
}

/// An error of the driver, with what was being done.
fn fault(what: &str, error: DriverError) -> Error {
    Error::Device(format!("{what}: {error}"))
}

/// Waits for a stream's work.
fn synchronize(stream: &CudaStream) -> Result<(), Error> {
    stream.synchronize().map_err(|e| fault("the device's work", e))
}
