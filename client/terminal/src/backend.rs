//! Options of the backend, shared by all commands that simulate.

use std::{path::PathBuf, sync::Arc};

use bendtwin_backends as backends;
use bendtwin_engine::Backend;
use bendtwin_fit::OpenRasteriser;
use clap::Args;

use crate::failure;

/// Default number of jobs side by side on a GPU, because one alone seldom fills it.
const GPU_JOBS: usize = 4;

/// Choice of the backend and of its resources.
#[derive(Clone, Debug, Args)]
pub(crate) struct BackendArgs {
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
    pub(crate) fn options(&self, kernel_dir: Option<PathBuf>) -> backends::Options {
        backends::Options {
            choice: self.backend,
            device: self.device,
            device_memory: self.device_memory_mib.map(|mib| mib.saturating_mul(1 << 20)),
            kernel_dir,
        }
    }

    /// Opens it in this process.
    pub(crate) fn open(&self) -> anyhow::Result<Arc<dyn Backend>> {
        backends::open(&self.options(None)).map_err(failure::failed)
    }

    /// Opens one backend for each job side by side: `jobs` of them, or as many as suit the device,
    /// at most `work`. On the CPU they share the cores. On a GPU each has its own queues and share
    /// of the memory.
    pub(crate) fn open_several(
        &self,
        jobs: Option<usize>,
        work: usize,
    ) -> anyhow::Result<Vec<Arc<dyn Backend>>> {
        let first = self.open()?;
        let is_cpu = first.device().kind == "cpu";
        let cores = std::thread::available_parallelism().map_or(1, std::num::NonZero::get);
        let usual = if is_cpu { cores } else { GPU_JOBS };
        let jobs = jobs.unwrap_or(usual).min(work).max(1);
        if jobs == 1 {
            return Ok(vec![first]);
        }
        if is_cpu {
            let threads = (cores / jobs).max(1);
            return Ok((0..jobs).map(|_| bendtwin_engine::cpu_with_threads(threads)).collect());
        }
        let mut options = self.options(None);
        let free = first.memory().map(|m| m.total.saturating_sub(m.used) / 10 * 9);
        options.device_memory = options.device_memory.or(free).map(|bytes| bytes / jobs as u64);
        // What was found once must not be something else the second time.
        options.choice = backends::Choice::Cuda;
        // The first one holds the device open meanwhile, and goes.
        (0..jobs).map(|_| backends::open(&options).map_err(failure::failed)).collect()
    }

    /// Opens rasterisers on the same device.
    pub(crate) fn rasteriser(&self) -> OpenRasteriser {
        let options = self.options(None);
        Arc::new(move || backends::rasteriser(&options).map_err(|e| e.to_string()))
    }

    /// The choice as environment variables, for a server's workers.
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
