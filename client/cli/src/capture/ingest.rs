//! `bendtwin capture ingest`.

use std::path::PathBuf;

use anyhow::Context as _;
use bendtwin_client::{CaptureId, Client, IngestSettings};
use bendtwin_core::settings::ingest::Stage;
use clap::{Args, ValueEnum};

use super::{reading::follow, strokes::StrokeArgs};
use crate::{args::requirements::RequirementArgs, failure::Usage, global::Global, output};

#[derive(Debug, Args)]
pub(crate) struct IngestArgs {
    /// captures/{uuid}
    name: CaptureId,
    /// Settings that differ from the defaults, as a JSON file
    #[arg(long, value_name = "FILE")]
    settings: Option<PathBuf>,
    /// Begin with the settings of the last ingest, its clicks among them, and not with the defaults
    #[arg(long, conflicts_with = "settings")]
    keep: bool,
    /// Stage after which the ingest ends: masks, to look at them first, or points
    #[arg(long, value_enum, value_name = "STAGE")]
    until: Option<Until>,
    #[command(flatten)]
    strokes: StrokeArgs,
    #[command(flatten)]
    requirements: RequirementArgs,
    /// Stop the running ingest instead
    #[arg(
        long,
        conflicts_with_all = ["settings", "keep", "until", "object", "hand", "background", "watch"]
    )]
    cancel: bool,
    /// Follow the job until it has ended
    #[arg(long)]
    watch: bool,
}

/// Stage of an ingest, as an argument.
#[derive(Clone, Copy, Debug, ValueEnum)]
enum Until {
    Masks,
    Points,
}

pub(super) async fn run(args: IngestArgs, global: &Global) -> anyhow::Result<()> {
    let client = global.connect().await?;
    let capture = if args.cancel {
        client.captures().cancel_ingest(args.name).await?
    } else {
        let settings = settings(&args, &client).await?;
        client.captures().ingest(args.name, &settings, &args.requirements.into()).await?
    };
    if args.watch {
        return follow(&client, args.name, global).await;
    }
    output::print(global, &capture, || {
        let state = capture.ingest.state.as_str();
        format!("{}: {state}\nnext: bendtwin capture report {}", args.name, args.name)
    })
}

/// The settings that the arguments ask for.
async fn settings(args: &IngestArgs, client: &Client) -> anyhow::Result<IngestSettings> {
    let mut settings = match &args.settings {
        Some(path) => {
            let text = std::fs::read_to_string(path)
                .with_context(|| format!("cannot read the settings {}", path.display()))?;
            serde_json::from_str(&text)
                .map_err(|e| Usage::error(format!("{}: {e}", path.display())))?
        }
        None if args.keep => {
            let before = client.captures().get(args.name).await?.ingest.settings;
            serde_json::from_value(before)
                .context("the settings of the last ingest are of another version: use --settings")?
        }
        None => IngestSettings::default(),
    };
    settings.strokes.extend(args.strokes.strokes());
    if let Some(until) = args.until {
        settings.until = match until {
            Until::Masks => Stage::Masks,
            Until::Points => Stage::Points,
        };
    }
    Ok(settings)
}
