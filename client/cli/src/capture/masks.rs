//! `bendtwin capture masks`: the masks that an ingest on the server made of strokes.

use std::path::PathBuf;

use bendtwin_client::CaptureId;
use clap::Args;
use serde_json::json;

use crate::{global::Global, output};

#[derive(Debug, Args)]
pub(super) struct Masks {
    /// captures/{uuid}
    name: CaptureId,
    /// Archive to be written: the folder `mask` of a recording
    #[arg(long, value_name = "FILE", default_value = "masks.zip")]
    out: PathBuf,
}

pub(super) async fn run(args: Masks, global: &Global) -> anyhow::Result<()> {
    let Masks { name, out } = args;
    global.connect().await?.captures().export_masks(name, &out).await?;
    output::print(global, &json!({ "path": out }), || format!("wrote {}", out.display()))
}
