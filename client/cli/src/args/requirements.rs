//! Options that ask for a worker.

use bendtwin_client::Requirements;
use clap::Args;

/// Worker that a fit or an ingest asks for; it waits until there is one.
#[derive(Debug, Args)]
#[command(next_help_heading = "Worker")]
pub(crate) struct RequirementArgs {
    /// Backend of the worker: cpu or cuda [default: either]
    #[arg(long, value_name = "BACKEND", default_value = "", hide_default_value = true)]
    worker_backend: String,
    /// Memory of the worker's device at least [MiB]; on a CPU, that which a fit may take
    #[arg(long, value_name = "MIB", default_value_t = 0, hide_default_value = true)]
    worker_memory_mib: u64,
    /// Label of the worker (`bendtwin worker --label`); may be given several times
    #[arg(long = "worker-label", value_name = "WORD", value_delimiter = ',')]
    worker_labels: Vec<String>,
}

impl From<RequirementArgs> for Requirements {
    fn from(args: RequirementArgs) -> Self {
        Self {
            backend: args.worker_backend,
            memory_bytes: args.worker_memory_mib.saturating_mul(1 << 20),
            labels: args.worker_labels,
        }
    }
}
