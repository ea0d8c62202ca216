//! Options of the backend, shared by all commands that simulate.

use std::{path::PathBuf, sync::Arc};

use bendtwin_backends as backends;
use bendtwin_engine::Backend;
use bendtwin_fit::OpenRasteriser;
use clap::Args;

use crate::failure;

/// Choice of the backend and of its resources.
#[derive(Clone, Debug, Args)]
pub struct BackendArgs {
    /// Backend: auto (CUDA if this machine has it), cpu or cuda
    #[arg(long, env = "BENDTWIN_BACKEND", value_name = "BACKEND", default_value = "auto")]
    backend: backends::Choice,
    /// CUDA device, counted from 0
    #[arg(long, env = "BENDTWIN_DEVICE", value_name = "N", default_value_t = 0)]
    device: usize,
    /// Most CUDA memory to use [MiB] [default: 90 % of the free memory]
    #[arg(long, env = "BENDTWIN_DEVICE_MEMORY_MIB", value_name = "MIB")]
    device_memory_mib: Option<u64>,
}

impl BackendArgs {
    /// Options for opening a backend; compiled kernels are kept in `kernel_dir`.
    pub fn options(&self, kernel_dir: Option<PathBuf>) -> backends::Options {
        backends::Options {
            choice: self.backend,
            device: self.device,
            device_memory: self.device_memory_mib.map(|mib| mib.saturating_mul(1 << 20)),
            kernel_dir,
        }
    }

    /// Opens it in this process.
    pub fn open(&self) -> anyhow::Result<Arc<dyn Backend>> {
        backends::open(&self.options(None)).map_err(failure::failed)
    }

    /// Opens rasterisers on the same device.
    pub fn rasteriser(&self) -> OpenRasteriser {
        let options = self.options(None);
        Arc::new(move || backends::rasteriser(&options).map_err(|e| e.to_string()))
    }

    /// The choice as environment variables, for a server's workers.
    pub fn variables(&self) -> Vec<(&'static str, String)> {
        let mut variables = vec![
            ("BENDTWIN_BACKEND", self.backend.to_string()),
            ("BENDTWIN_DEVICE", self.device.to_string()),
        ];
        variables
            .extend(self.device_memory_mib.map(|m| ("BENDTWIN_DEVICE_MEMORY_MIB", m.to_string())));
        variables
    }
}
