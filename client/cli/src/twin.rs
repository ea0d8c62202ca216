//! `bendtwin twin`: list, inspect, edit, export, import, dress, make ready for plans, share.

mod dress;
pub(crate) mod exchange;
mod export;
mod import;
mod planner;
mod share;
mod source;

use std::path::Path;

use bendtwin_client::{CaptureId, ListQuery, TwinId};
use bendtwin_core::quality::{ErrorSummary, Level};
use bendtwin_eval::{TableStyle, format_table};
use clap::{Args, Subcommand};
use serde_json::json;

use crate::{
    global::Global,
    labels::{self, Changes, Choice},
    output,
    quality::{self, identifiability},
    table::Table,
};

#[derive(Debug, Args)]
pub(crate) struct Twin {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// List twins
    List {
        /// List only twins of this capture
        #[arg(long, value_name = "NAME")]
        capture: Option<CaptureId>,
        /// List only twins with this level of trust: good, fair, poor or unknown
        #[arg(long, value_parser = level)]
        level: Option<Level>,
        #[command(flatten)]
        choice: Choice,
    },
    /// Change name, note and tags of a twin
    Edit {
        /// twins/{uuid}
        name: TwinId,
        #[command(flatten)]
        changes: Changes,
    },
    /// Show a twin and its quality
    Show {
        /// twins/{uuid}
        name: TwinId,
    },
    /// Score a twin on a capture: on another recording of its object it is registered to the first
    /// frame
    Evaluate {
        /// twins/{uuid}
        name: TwinId,
        /// captures/{uuid}
        capture: CaptureId,
    },
    /// Write a twin to a file, in the twin format or that of another program
    Export(export::Export),
    /// Let a twin carry the Gaussians of a file, from a phone scan or another training program
    Dress(dress::Dress),
    /// Make the planner's twin of a twin: a small twin, distilled from its motion, which makes
    /// plans much faster
    Planner(planner::Planner),
    /// Store a twin file, or a fit by PhysTwin, on the server
    Import(import::Import),
    /// Make a link by which people without a token look at a twin and play with it, and print it
    Share(share::Share),
    /// List the links of a twin, with revoked and expired ones
    Shares(share::Shares),
    /// Revoke links: no server accepts them 30 s later, and plays through them end
    Unshare(share::Unshare),
    /// Move twins to the trash
    Delete {
        /// twins/{uuid}
        #[arg(required = true)]
        names: Vec<TwinId>,
        /// Delete them for good: nothing can restore them
        #[arg(long)]
        purge: bool,
    },
}

fn level(word: &str) -> Result<Level, String> {
    let found = Level::ALL.into_iter().find(|level| level.as_str() == word);
    found.ok_or_else(|| format!("must be one of {}", Level::ALL.map(Level::as_str).join(", ")))
}

pub(crate) async fn run(args: Twin, global: &Global) -> anyhow::Result<()> {
    match args.command {
        Command::List { capture, level, choice } => {
            let query = ListQuery { capture, level, ..choice.query() };
            let list = global.connect().await?.twins().all(&query).await?;
            output::print(global, &list, || {
                let header = ["NAME", "CREATED", "NODES", "TRACK", "CD", "OWNER", "WHAT"];
                let mut table = Table::new(header);
                for t in &list {
                    table.row([
                        t.name.to_string(),
                        format!("{:.0}", t.create_time),
                        t.node_count.to_string(),
                        labels::millimetres(future(t).track_m),
                        labels::millimetres(future(t).chamfer_l1_m),
                        t.owner.clone(),
                        labels::what(&t.display_name, &t.tags),
                    ]);
                }
                table.text()
            })
        }
        Command::Show { name } => {
            let client = global.connect().await?;
            let twin = client.twins().get(name).await?;
            let assessment = quality::of_stored(&client, name).await?;
            output::print(global, &twin, || {
                let text = format!("{}\n{assessment}", shown(&twin));
                match identifiability::details(&twin.quality) {
                    Some(details) => format!("{text}\n\n{details}"),
                    None => text,
                }
            })
        }
        Command::Evaluate { name, capture } => {
            let client = global.connect().await?;
            let quality = client.evaluations().run(name, capture).await?;
            let document = json!({ "twin": name, "capture": capture, "quality": quality });
            output::print(global, &document, || {
                let table = format_table(&quality, TableStyle::Plain);
                match &quality.assessment {
                    Some(assessment) => format!("{table}\n{assessment}"),
                    None => table,
                }
            })
        }
        Command::Export(args) => export::run(args, global).await,
        Command::Dress(args) => dress::run(args, global).await,
        Command::Planner(args) => planner::run(args, global).await,
        Command::Import(args) => import::run(args, global).await,
        Command::Share(args) => share::share(args, global).await,
        Command::Shares(args) => share::list(args, global).await,
        Command::Unshare(args) => share::revoke(args, global).await,
        Command::Edit { name, changes } => {
            let update = labels::update(changes)?;
            let twin = global.connect().await?.twins().update(name, &update).await?;
            output::print(global, &twin, || shown(&twin))
        }
        Command::Delete { names, purge } => {
            let client = global.connect().await?;
            for name in &names {
                match purge {
                    true => client.twins().purge(*name).await?,
                    false => client.twins().delete(*name).await?,
                }
            }
            output::print(global, &names, || format!("deleted {}", names.len()))
        }
    }
}

/// Errors over frames that the twin was not fitted to.
fn future(twin: &bendtwin_client::Twin) -> ErrorSummary {
    twin.quality.scores.first().map(|own| own.future).unwrap_or_default()
}

fn stem(path: &Path) -> String {
    path.file_stem().unwrap_or(path.as_os_str()).to_string_lossy().into_owned()
}

fn shown(twin: &bendtwin_client::Twin) -> String {
    let origin = |name: Option<String>| name.unwrap_or_else(|| "imported".to_owned());
    format!(
        "{}\n  what      {}{}\n  capture   {}\n  fit       {}\n  graph     {} nodes, {} springs, {} triplets, {} control points\n  time      {} frames a second, {} substeps a frame\n  fast      {}\n  planner   {}\n  size      {}\n\n{}",
        twin.name,
        twin.display_name,
        labels::lines(&twin.note, &twin.tags, 10),
        origin(twin.capture.map(|c| c.to_string())),
        origin(twin.fit.map(|f| f.to_string())),
        twin.node_count,
        twin.spring_count,
        twin.triplet_count,
        twin.control_count,
        twin.fps,
        twin.substeps,
        quality::fast(&twin.quality, twin.substeps).unwrap_or_else(|| "not known".to_owned()),
        quality::planner(&twin.quality).unwrap_or_else(|| "none".to_owned()),
        output::bytes(twin.size_bytes),
        format_table(&twin.quality, TableStyle::Plain),
    )
}
