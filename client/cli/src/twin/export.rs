//! `bendtwin twin export`: a twin, of the server or of a file, in the format of another program.

use std::path::PathBuf;

use anyhow::Context as _;
use bendtwin_core::Twin;
use bendtwin_exchange::{Error, Format};
use clap::Args;
use serde_json::json;

use super::exchange::{self, Points};
use super::source::Source;
use crate::{failure, global::Global, output};

#[derive(Debug, Args)]
pub(super) struct Export {
    /// twins/{uuid}, or a twin file on this machine, which needs no server
    twin: Source,
    /// The file to write; its extension sets the format: .safetensors or .twin
    /// (docs/formats/twin.md), .splat.ply (Gaussians), .ply, .zip (PLY), .obj, .glb, .npz, .usda, .usdz,
    /// .xml (MuJoCo), .mcap (docs/formats/exchange.md)
    file: PathBuf,
    /// Write this format, regardless of the file's name: twin, splats, ply, ply-sequence, obj, glb,
    /// npz, usda, usdz, mujoco or mcap
    #[arg(long)]
    format: Option<Format>,
    #[command(flatten)]
    points: Points,
}

pub(super) async fn run(args: Export, global: &Global) -> anyhow::Result<()> {
    let Export { twin: source, file, format, points } = args;
    let format = exchange::format_of(&file, format)?;
    let (name, content) = source.read(global).await?;
    match format {
        Format::Twin if points.are_others() => {
            return Err(failure::failed(Error::NodesOnly { format }));
        }
        // Unread: a twin of a newer version than this build reads can be fetched nevertheless.
        Format::Twin if matches!(source, Source::Server(_)) => std::fs::write(&file, &content)
            .with_context(|| format!("cannot write {}", file.display()))?,
        _ => {
            let twin = Twin::decode(&content).map_err(failure::failed)?;
            points.write(&name, &twin, None, format, &file)?;
        }
    }
    let size_bytes = exchange::size_of(&file)?;
    let written =
        json!({ "twin": name, "path": file, "format": format.name(), "size_bytes": size_bytes });
    output::print(global, &written, || {
        format!("{} ({format}, {})", file.display(), output::bytes(size_bytes))
    })
}
