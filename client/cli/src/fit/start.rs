//! `bendtwin fit start`.

use bendtwin_client::{CaptureId, FitOrder, Requirements, TwinId};
use clap::Args;

use super::{ended_well, print_ended, watch_here};
use crate::{global::Global, output, settings::SettingsArgs};

#[derive(Debug, Args)]
pub(crate) struct Start {
    /// Capture to fit: captures/{uuid}
    capture: CaptureId,
    #[command(flatten)]
    settings: SettingsArgs,
    /// Refine this twin without a search instead of fitting one anew: twins/{uuid}
    #[arg(long, value_name = "TWIN", conflicts_with_all = ["axial", "phystwin"])]
    from: Option<TwinId>,
    /// Priority, -100 to 100; higher ones run earlier
    #[arg(long, default_value_t = 0, allow_hyphen_values = true)]
    priority: i32,
    /// Idempotency key: repeating the command with the same one starts no second fit
    #[arg(long, value_name = "WORD")]
    request_id: Option<String>,
    /// Display name [default: the capture's]
    #[arg(long, value_name = "NAME", default_value = "", hide_default_value = true)]
    name: String,
    #[command(flatten)]
    requirements: RequirementArgs,
    /// Follow it until it has ended
    #[arg(long)]
    watch: bool,
}

/// Worker that the fit asks for; it waits until there is one.
#[derive(Debug, Args)]
#[command(next_help_heading = "Worker")]
struct RequirementArgs {
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

pub(super) async fn run(args: Start, global: &Global) -> anyhow::Result<()> {
    let mut settings = args.settings.resolve()?;
    settings.start_from = args.from.map(|twin| twin.to_string()).or(settings.start_from);
    let client = global.connect().await?;
    let fits = client.fits();
    let order = FitOrder {
        priority: args.priority,
        request_id: args.request_id,
        display_name: args.name,
        requirements: args.requirements.into(),
    };
    let fit = fits.create_as(args.capture, &settings, order).await?;
    if !args.watch {
        return output::print(global, &fit, || {
            format!("{}\nnext: bendtwin fit watch {}", fit.name, fit.name)
        });
    }
    if !global.json {
        eprintln!("{}", fit.name);
    }
    let fit = watch_here(&client, fit.name, global.json).await?;
    print_ended(&client, &fit, global).await?;
    ended_well(&fit)
}
