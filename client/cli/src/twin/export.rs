//! `bendtwin twin export`: a twin, of the server or of a file, in the format of another program.

use std::path::PathBuf;

use anyhow::Context as _;
use bendtwin_core::Twin;
use bendtwin_exchange::{Error, ExportFormat, Format, web_page};
use clap::Args;
use serde_json::json;

use super::exchange::{self, Points};
use super::source::Source;
use crate::{
    failure::{self, Usage},
    global::Global,
    output,
};

#[derive(Debug, Args)]
pub(super) struct Export {
    /// twins/{uuid}, or a twin file on this machine, which needs no server
    twin: Source,
    /// The file to write; its extension sets the format: .safetensors or .twin
    /// (docs/formats/twin.md), .splat.ply (Gaussians), .ply, .zip (PLY), .obj, .glb, .npz, .usda, .usdz,
    /// .xml (MuJoCo), .mcap, .html (web page) (docs/formats/exchange.md)
    file: PathBuf,
    /// Write this format, regardless of the file's name: twin, splats, ply, ply-sequence, obj, glb,
    /// npz, usda, usdz, mujoco, mcap or html
    #[arg(long)]
    format: Option<ExportFormat>,
    #[command(flatten)]
    points: Points,
}

pub(super) async fn run(args: Export, global: &Global) -> anyhow::Result<()> {
    let Export { twin: source, file, format, points } = args;
    let format =
        format.map_or_else(|| ExportFormat::of_path(&file).map_err(failure::failed), Ok)?;
    let (name, content) = source.read(global).await?;
    let save = |content: &[u8]| {
        std::fs::write(&file, content).with_context(|| format!("cannot write {}", file.display()))
    };
    match format {
        ExportFormat::Html if points != Points::default() => {
            let fault = "html shows the surface: omit --nodes, --skin, --surface and --mesh";
            return Err(Usage::error(fault));
        }
        ExportFormat::Html => {
            let title = source.title(global).await?;
            let template = bendtwin_server::twin_page_template()?;
            save(&web_page(&template, &title, &content).map_err(failure::failed)?)?;
        }
        ExportFormat::Of(format @ Format::Twin) if points.are_others() => {
            return Err(failure::failed(Error::NodesOnly { format }));
        }
        // Unread: a twin of a newer version than this build reads can be fetched nevertheless.
        ExportFormat::Of(Format::Twin) if matches!(source, Source::Server(_)) => save(&content)?,
        ExportFormat::Of(format) => {
            let twin = Twin::decode(&content).map_err(failure::failed)?;
            points.write(&name, &twin, None, format, &file)?;
        }
    }
    let size_bytes = exchange::size_of(&file)?;
    let format_name = format.to_string();
    let written =
        json!({ "twin": name, "path": file, "format": format_name, "size_bytes": size_bytes });
    output::print(global, &written, || {
        format!("{} ({format}, {})", file.display(), output::bytes(size_bytes))
    })
}
