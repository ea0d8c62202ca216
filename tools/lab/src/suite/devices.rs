//! Backends for runs side by side.

use std::sync::Arc;

use bendtwin_backends as backends;
use bendtwin_engine::Backend;
use bendtwin_terminal::{backend::BackendArgs, failure};

/// Default number of jobs side by side on a GPU, because one alone seldom fills it.
const GPU_JOBS: usize = 4;

/// Opens one backend for each job side by side: `jobs` of them, or as many as suit the device, at most
/// `work`. On the CPU they share the cores. On a GPU each has its own queues and share of the memory.
pub(super) fn open(
    args: &BackendArgs,
    jobs: Option<usize>,
    work: usize,
) -> anyhow::Result<Vec<Arc<dyn Backend>>> {
    let first = args.open()?;
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
    let mut options = args.options(None);
    let free = first.memory().map(|m| m.total.saturating_sub(m.used) / 10 * 9);
    options.device_memory = options.device_memory.or(free).map(|bytes| bytes / jobs as u64);
    // What was found once must not be something else the second time.
    options.choice = backends::Choice::Cuda;
    // The first one holds the device open meanwhile, and goes.
    (0..jobs).map(|_| backends::open(&options).map_err(failure::failed)).collect()
}
