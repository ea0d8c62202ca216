//! `bendtwin capture report`: the report of a capture as a page and as a document, measured on this
//! machine or fetched from the server.

use std::path::{Path, PathBuf};

use anyhow::Context as _;
use bendtwin_capture::{Limits, Opened};
use bendtwin_client::CaptureId;
use bendtwin_core::{CancelToken, settings::ingest::IngestSettings};
use bendtwin_inspect::{Report, inspect, inspect_observed};
use clap::Args;

use super::{
    check::text,
    reading::{self, Files},
};
use crate::{
    failure::{self, Usage},
    global::Global,
    output,
};

#[derive(Debug, Args)]
pub(crate) struct Arguments {
    /// A raw recording or a capture: a folder, a ZIP or tar archive, or motion capture as .npz
    /// with its .json, C3D, CSV or TRC; or a capture on the server: captures/{uuid}
    path: PathBuf,
    /// Write the page: HTML with pictures, in one file
    #[arg(long, value_name = "FILE")]
    html: Option<PathBuf>,
    /// Write the document: JSON
    #[arg(long, value_name = "FILE")]
    document: Option<PathBuf>,
    /// Write the observation of a capture on the server: tracked points as a bundle, the input of
    /// fits
    #[arg(long, value_name = "FILE")]
    observation: Option<PathBuf>,
}

pub(super) async fn run(args: Arguments, global: &Global) -> anyhow::Result<()> {
    if let Some(name) = stored(&args.path) {
        let (html, document) = (args.html.as_deref(), args.document.as_deref());
        let files = Files { html, document, observation: args.observation.as_deref() };
        return reading::report(name, files, global).await;
    }
    if args.observation.is_some() {
        let what = "--observation is what a server made of a capture: name one, captures/{uuid}";
        return Err(Usage::error(what));
    }
    let path = args.path.clone();
    let report = tokio::task::spawn_blocking(move || open_and_inspect(&path)).await??;
    if let Some(path) = &args.html {
        write(path, &report.to_html())?;
    }
    let document = report.to_json();
    if let Some(path) = &args.document {
        write(path, &document)?;
    }
    let value: serde_json::Value = serde_json::from_str(&document)?;
    output::print(global, &value, || {
        let files: String = [&args.html, &args.document]
            .into_iter()
            .flatten()
            .map(|path| format!("\nwrote {}", path.display()))
            .collect();
        text(&report.inspection().check_report()) + &files
    })
}

/// The capture on the server, if the argument names one.
fn stored(path: &Path) -> Option<CaptureId> {
    let name = path.to_str().filter(|name| name.starts_with("captures/"))?;
    name.parse().ok()
}

/// Inspects a capture of any kind on this machine.
fn open_and_inspect(path: &Path) -> anyhow::Result<Report> {
    look(bendtwin_capture::open(path, &Limits::default()).map_err(failure::failed)?)
}

/// The report of the reference, with the findings of all recordings.
fn look(opened: Opened) -> anyhow::Result<Report> {
    let inspection = match opened {
        Opened::Observed(capture, remarks) => {
            let mut seen = inspect_observed(&capture);
            seen.sources = remarks.sources.clone();
            seen.add(remarks);
            seen
        }
        Opened::Raw(recording) => {
            let settings = IngestSettings::default();
            let cancel = CancelToken::default();
            inspect(&recording, &settings, &cancel, &mut |_| {}).map_err(failure::failed)?
        }
        Opened::Several(parts) => {
            let mut parts = parts.into_iter();
            let first = parts.next().context("there is no recording")?;
            let mut report = look(first.opened)?;
            for part in parts {
                report.add_recording(&part.name, &look(part.opened)?);
            }
            return Ok(report);
        }
    };
    Ok(Report::new(inspection, None))
}

fn write(path: &Path, text: &str) -> anyhow::Result<()> {
    std::fs::write(path, text).with_context(|| format!("cannot write {}", path.display()))
}
