//! What computes: the options that all commands with physics in them share.

use std::{path::PathBuf, sync::Arc};

use bendtwin_engine::Backend;
use bendtwin_worker::{BackendChoice, BackendOptions, open_backend};
use clap::Args;

use crate::failure;

/// Which backend, and what of it may be used.
#[derive(Clone, Debug, Args)]
pub(crate) struct BackendArgs {
    /// What computes: auto (CUDA if this machine has it), cpu or cuda
    #[arg(long, env = "BENDTWIN_BACKEND", value_name = "BACKEND", default_value = "auto")]
    backend: BackendChoice,
    /// Which CUDA device, counted from 0
    #[arg(long, env = "BENDTWIN_DEVICE", value_name = "N", default_value_t = 0)]
    device: usize,
    /// CUDA memory that may be used [MiB] [default: nine tenths of what is free]
    #[arg(long, env = "BENDTWIN_DEVICE_MEMORY_MIB", value_name = "MIB")]
    device_memory_mib: Option<u64>,
}

impl BackendArgs {
    /// As options; compiled kernels are kept in `kernel_dir`.
    pub(crate) fn options(&self, kernel_dir: Option<PathBuf>) -> BackendOptions {
        BackendOptions {
            choice: self.backend,
            device: self.device,
            device_memory: self.device_memory_mib.map(|mib| mib.saturating_mul(1 << 20)),
            kernel_dir,
        }
    }

    /// Opens it in this process.
    pub(crate) fn open(&self) -> anyhow::Result<Arc<dyn Backend>> {
        open_backend(&self.options(None)).map_err(failure::failed)
    }

    /// The same choice as environment variables, for a server's workers.
    pub(crate) fn variables(&self) -> Vec<(&'static str, String)> {
        let mut variables = vec![
            ("BENDTWIN_BACKEND", self.backend.to_string()),
            ("BENDTWIN_DEVICE", self.device.to_string()),
        ];
        variables
            .extend(self.device_memory_mib.map(|m| ("BENDTWIN_DEVICE_MEMORY_MIB", m.to_string())));
        variables
    }
}
