//! Captures on the server: following their ingest, and fetching its results.

use std::path::Path;

use anyhow::Context as _;
use bendtwin_client::{Capture, CaptureId, Client, JobState};
use bendtwin_core::{Category, Fault, Finding};
use futures::StreamExt as _;
use serde::Deserialize;
use serde_json::Value;

use super::check;
use crate::{
    failure::{Failed, Shown},
    global::Global,
    output,
    progress::FitBar,
};

/// The part of a report that is shown without its page.
#[derive(Deserialize)]
struct Summary {
    verdict: String,
    findings: Vec<Finding>,
}

/// Files to write.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Files<'a> {
    /// The report as a page.
    pub(super) html: Option<&'a Path>,
    /// The report as a document.
    pub(super) document: Option<&'a Path>,
    /// The observation, the input of fits.
    pub(super) observation: Option<&'a Path>,
}

/// Fetches the report of a capture from the server.
pub(super) async fn report(
    name: CaptureId,
    files: Files<'_>,
    global: &Global,
) -> anyhow::Result<()> {
    let client = global.connect().await?;
    if let Some(path) = files.observation {
        client.captures().export_observation(name, path).await?;
    }
    if let Some(path) = files.html {
        write(path, &client.captures().report_page(name).await?)?;
    }
    let report = client.captures().report(name).await?;
    if let Some(path) = files.document {
        write(path, &serde_json::to_vec_pretty(&report)?)?;
    }
    output::print(global, &report, || text(&report))
}

fn write(path: &Path, content: &[u8]) -> anyhow::Result<()> {
    std::fs::write(path, content).with_context(|| format!("cannot write {}", path.display()))
}

/// Findings and verdict for people.
fn text(report: &Value) -> String {
    match Summary::deserialize(report) {
        Ok(Summary { verdict, findings }) => check::lines(&findings) + &sentence(&verdict),
        // From a newer server: unformatted is better than nothing.
        Err(_) => report.to_string(),
    }
}

fn sentence(verdict: &str) -> String {
    match verdict {
        "good" => "This capture can be fitted.".to_owned(),
        "usable" => {
            "This capture can be fitted; the warnings name what limits the result.".to_owned()
        }
        "unusable" => "This capture cannot be fitted.".to_owned(),
        other => format!("Verdict: {other}."),
    }
}

/// State and verdict of a capture's ingest in a word.
pub(super) fn status(capture: &Capture) -> String {
    let state = capture.ingest.state;
    match (&capture.verdict, state, &capture.ingest.progress) {
        (_, JobState::Running, Some(p)) => format!("running {:.0} %", 100.0 * p.fraction),
        (Some(verdict), state, _) if state.has_ended() => verdict.clone(),
        _ => state.as_str().to_owned(),
    }
}

/// Follows the ingest of a capture until it has ended.
pub(super) async fn watch(
    client: &Client,
    name: CaptureId,
    quiet: bool,
) -> anyhow::Result<Capture> {
    let mut bar = FitBar::new(quiet);
    let mut states = client.captures().watch(name);
    let mut last: Option<Capture> = None;
    while let Some(capture) = states.next().await {
        let capture = capture?;
        if capture.ingest.state == JobState::Queued && last.is_none() {
            bar.print("waiting for a worker");
        }
        if let Some(progress) = &capture.ingest.progress {
            bar.show(progress);
        }
        last = Some(capture);
    }
    bar.finish();
    last.context("the server sent no state of the capture")
}

/// Follows the ingest of a capture and prints its result. The command fails if the capture cannot
/// be fitted.
pub(super) async fn follow(
    client: &Client,
    name: CaptureId,
    global: &Global,
) -> anyhow::Result<()> {
    let capture = watch(client, name, global.json).await?;
    // One that was cancelled has none.
    let report = client.captures().report(name).await.ok();
    output::print(global, &capture, || {
        let next = match capture.ingest.state {
            JobState::Succeeded if capture.ingest.settings["until"] == "masks" => format!(
                "\nnext: bendtwin capture masks {name}, or bendtwin capture ingest {name} --keep --until \
                 points --watch"
            ),
            JobState::Succeeded => format!("\nnext: bendtwin fit start {name} --watch"),
            _ => String::new(),
        };
        let said = report.as_ref().map(text).unwrap_or_default();
        format!("{name}\n{said}{next}")
    })?;
    match capture.ingest.state {
        JobState::Succeeded => Ok(()),
        state => {
            let fault = capture.ingest.fault.unwrap_or_else(|| Fault {
                category: Category::Cancelled,
                reason: "INGEST_DID_NOT_SUCCEED".to_owned(),
                message: format!("the ingest is {}", state.as_str()),
            });
            // The report has already named the fault among its findings.
            Err(if report.is_some() { Shown(fault).into() } else { Failed(fault).into() })
        }
    }
}
