//! `bendtwin capture`: make, check, upload, complete, list, edit and read captures.

mod add;
mod archive;
mod calibrate;
mod check;
mod export;
mod ingest;
pub(crate) mod make;
mod mask;
mod masks;
pub(crate) mod push;
mod reading;
mod report;
mod strokes;

use std::path::PathBuf;

use bendtwin_client::{CaptureId, ListQuery, Update};
use clap::{Args, Subcommand};

use crate::{
    global::Global,
    labels::{self, Changes, Choice},
    output,
    table::Table,
};

#[derive(Debug, Args)]
pub(crate) struct Capture {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Make a small capture of a simulated object, to try things out
    Make(make::Make),
    /// Check a capture and explain its faults, without a server
    Check {
        /// A folder, a ZIP or tar archive, an MCAP file, or motion capture as .npz with its .json
        path: PathBuf,
    },
    /// Measure a capture or raw recording and write the report as a page with pictures or as JSON
    Report(report::Arguments),
    /// Find the cameras' poses with a board that all of them see, or take them from another program,
    /// and write calibration.json, without a server
    Calibrate(calibrate::Calibrate),
    /// Make the masks of object and hands in a raw recording from a few clicks, without a server
    Mask(Box<mask::Mask>),
    /// Write the images of the object in one frame as a nerfstudio folder, for trainers of Gaussian
    /// splatting, without a server
    Export(export::Export),
    /// Check a capture and upload it
    Push(Box<push::Push>),
    /// List the captures of the server
    List {
        #[command(flatten)]
        choice: Choice,
        /// List only those recorded by this person
        #[arg(long, value_name = "NAME", default_value = "", hide_default_value = true)]
        recorded_by: String,
    },
    /// Change name, note, tags and recorder of a capture
    Edit {
        /// captures/{uuid}
        name: CaptureId,
        #[command(flatten)]
        changes: Changes,
        /// New name of who recorded it; an empty one removes it
        #[arg(long, value_name = "NAME")]
        recorded_by: Option<String>,
    },
    /// Show one capture
    Show {
        /// captures/{uuid}
        name: CaptureId,
    },
    /// Let the server read a capture again, for example with other settings
    Ingest(ingest::IngestArgs),
    /// Add masks or a calibration to a capture on the server, for its next ingest
    Add(add::Add),
    /// Remove files that were added to a capture
    Remove(add::Remove),
    /// Download the masks that the server made of clicks
    Masks(masks::Masks),
    /// Move captures to the trash; their twins are kept
    Delete {
        /// captures/{uuid}
        #[arg(required = true)]
        names: Vec<CaptureId>,
        /// Delete them for good: nothing can restore them
        #[arg(long)]
        purge: bool,
    },
}

pub(crate) async fn run(args: Capture, global: &Global) -> anyhow::Result<()> {
    match args.command {
        Command::Make(args) => make::run(args, global).await,
        Command::Check { path } => check::run(&path, global).await,
        Command::Report(args) => report::run(args, global).await,
        Command::Calibrate(args) => calibrate::run(args, global).await,
        Command::Mask(args) => mask::run(*args, global).await,
        Command::Export(args) => export::run(args, global).await,
        Command::Push(args) => push::run(*args, global).await,
        Command::List { choice, recorded_by } => {
            let query = ListQuery { recorded_by, ..choice.query() };
            let captures = global.connect().await?.captures().all(&query).await?;
            output::print(global, &captures, || {
                let mut table = Table::new(["NAME", "CREATED", "SIZE", "READ", "OWNER", "WHAT"]);
                for c in &captures {
                    let size = output::bytes(c.size_bytes);
                    let created = format!("{:.0}", c.create_time);
                    let read = reading::status(c);
                    let what = labels::what(&c.display_name, &c.tags);
                    table.row([c.name.to_string(), created, size, read, c.owner.clone(), what]);
                }
                table.text()
            })
        }
        Command::Show { name } => {
            let capture = global.connect().await?.captures().get(name).await?;
            output::print(global, &capture, || shown(&capture))
        }
        Command::Edit { name, changes, recorded_by } => {
            let update = labels::update(Update { recorded_by, ..changes.into() })?;
            let capture = global.connect().await?.captures().update(name, &update).await?;
            output::print(global, &capture, || shown(&capture))
        }
        Command::Ingest(args) => ingest::run(args, global).await,
        Command::Add(args) => add::run(args, global).await,
        Command::Remove(args) => add::remove(args, global).await,
        Command::Masks(args) => masks::run(args, global).await,
        Command::Delete { names, purge } => {
            let client = global.connect().await?;
            for name in &names {
                match purge {
                    true => client.captures().purge(*name).await?,
                    false => client.captures().delete(*name).await?,
                }
            }
            output::print(global, &names, || format!("deleted {}", names.len()))
        }
    }
}

fn shown(capture: &bendtwin_client::Capture) -> String {
    let fault = capture.ingest.fault.as_ref();
    let recorder = Some(&capture.recorded_by).filter(|name| !name.is_empty());
    let added: Vec<_> = capture
        .supplements
        .iter()
        .map(|added| format!("{} ({})", added.kind, output::bytes(added.size_bytes)))
        .collect();
    let added = Some(added.join(", ")).filter(|added| !added.is_empty());
    format!(
        "{}\n  what     {}{}{}\n  created  {:.0}\n  size     {}\n  digest   {}{}\n  read     {}{}{}",
        capture.name,
        capture.display_name,
        recorder.map(|name| format!("\n  recorded by {name}")).unwrap_or_default(),
        labels::lines(&capture.note, &capture.tags, 9),
        capture.create_time,
        output::bytes(capture.size_bytes),
        capture.digest,
        added.map(|added| format!("\n  added    {added}")).unwrap_or_default(),
        reading::status(capture),
        if capture.masks { "\n  masks    made of clicks" } else { "" },
        fault.map(|f| format!("\n  because  {f}")).unwrap_or_default()
    )
}
