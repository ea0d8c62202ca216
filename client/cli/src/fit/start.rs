//! `bendtwin fit start`.

use bendtwin_client::CaptureId;
use clap::Args;

use super::{ended_well, shown, watch};
use crate::{global::Global, output, settings::SettingsArgs};

#[derive(Debug, Args)]
pub(crate) struct Start {
    /// What to fit: captures/{uuid}
    capture: CaptureId,
    #[command(flatten)]
    settings: SettingsArgs,
    /// Higher runs earlier, -100 to 100
    #[arg(long, default_value_t = 0, allow_hyphen_values = true)]
    priority: i32,
    /// Repeating the command with the same word starts nothing new
    #[arg(long, value_name = "WORD")]
    request_id: Option<String>,
    /// Follow it until it has ended
    #[arg(long)]
    watch: bool,
}

pub(super) async fn run(args: Start, global: &Global) -> anyhow::Result<()> {
    let settings = args.settings.resolve()?;
    let client = global.connect().await?;
    let fits = client.fits();
    let fit = match &args.request_id {
        Some(id) => fits.create_once(args.capture, &settings, args.priority, id).await?,
        None => fits.create(args.capture, &settings, args.priority).await?,
    };
    if !args.watch {
        return output::print(global, &fit, || {
            format!("{}\nnext: bendtwin fit watch {}", fit.name, fit.name)
        });
    }
    let fit = watch(&client, fit.name, global.json).await?;
    output::print(global, &fit, || shown(&fit))?;
    ended_well(&fit)
}
