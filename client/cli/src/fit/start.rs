//! `bendtwin fit start`.

use bendtwin_client::{CaptureId, FitOrder, TwinId};
use clap::Args;

use super::{ended_well, print_ended, watch_here};
use crate::{args::requirements::RequirementArgs, global::Global, output, settings::SettingsArgs};

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
    /// Idempotency key: repeating the command with the same key starts no second fit
    #[arg(long, value_name = "WORD")]
    request_id: Option<String>,
    /// Display name [default: the capture's]
    #[arg(long, value_name = "NAME", default_value = "", hide_default_value = true)]
    name: String,
    #[command(flatten)]
    requirements: RequirementArgs,
    /// Follow the job until it has ended
    #[arg(long)]
    watch: bool,
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
