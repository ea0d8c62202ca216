//! `bendtwin capture ingest`.

use std::path::PathBuf;

use anyhow::Context as _;
use bendtwin_client::{CaptureId, IngestSettings};
use clap::Args;

use super::reading::follow;
use crate::{failure::Usage, global::Global, output, requirements::RequirementArgs};

#[derive(Debug, Args)]
pub(crate) struct IngestArgs {
    /// captures/{uuid}
    name: CaptureId,
    /// Settings that differ from the defaults, as a JSON file
    #[arg(long, value_name = "FILE")]
    settings: Option<PathBuf>,
    #[command(flatten)]
    requirements: RequirementArgs,
    /// Stop the running ingest instead
    #[arg(long, conflicts_with_all = ["settings", "watch"])]
    cancel: bool,
    /// Follow the job until it has ended
    #[arg(long)]
    watch: bool,
}

pub(super) async fn run(args: IngestArgs, global: &Global) -> anyhow::Result<()> {
    let settings = match &args.settings {
        None => IngestSettings::default(),
        Some(path) => {
            let text = std::fs::read_to_string(path)
                .with_context(|| format!("cannot read the settings {}", path.display()))?;
            serde_json::from_str(&text)
                .map_err(|e| Usage::error(format!("{}: {e}", path.display())))?
        }
    };
    let client = global.connect().await?;
    let capture = if args.cancel {
        client.captures().cancel_ingest(args.name).await?
    } else {
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
