//! What reading a capture on the server gave: followed while it goes on, and fetched.

use std::path::Path;

use anyhow::Context as _;
use bendtwin_client::{Capture, CaptureId, Client, JobState};
use bendtwin_core::{Category, Fault, Finding};
use futures::StreamExt as _;
use serde::Deserialize;
use serde_json::Value;

use super::check;
use crate::{args::Global, failure::Failed, output, progress::FitBar};

/// What is shown of a report without its page.
#[derive(Deserialize)]
struct Summary {
    verdict: String,
    findings: Vec<Finding>,
}

/// Where to put what is fetched.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Files<'a> {
    /// The report as a page.
    pub(super) html: Option<&'a Path>,
    /// The report as a document.
    pub(super) document: Option<&'a Path>,
    /// What fits work on.
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
        // Of a newer server: better as it is than not at all.
        Err(_) => report.to_string(),
    }
}

fn sentence(verdict: &str) -> String {
    match verdict {
        "good" => "This capture is fit for fitting.".to_owned(),
        "usable" => "This capture can be fitted; the warnings say what holds it back.".to_owned(),
        "unusable" => "This capture cannot be fitted as it is.".to_owned(),
        other => format!("Verdict: {other}."),
    }
}

/// How far reading a capture is, and what came of it.
pub(super) fn in_a_word(capture: &Capture) -> String {
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
            bar.say("waiting for a worker");
        }
        if let Some(progress) = &capture.ingest.progress {
            bar.show(progress);
        }
        last = Some(capture);
    }
    bar.finish();
    last.context("the server said nothing about the capture")
}

/// Follows the ingest of a capture and tells what came of it. One that cannot be fitted is a failure of the
/// command that waited for it.
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
            Err(Failed(fault).into())
        }
    }
}
