//! `bendtwin capture check`.

use std::path::Path;

use bendtwin_capture::{CheckReport, Limits, Opened, Part, check_path, raw::Recording};
use bendtwin_core::{
    CancelToken, Finding, Problem as _, Severity, settings::ingest::IngestSettings,
};

use crate::{failure, global::Global, output};

/// Code of the finding about a raw recording that has not been processed.
const RAW_CAPTURE: &str = "RAW_CAPTURE";

pub(super) async fn run(path: &Path, global: &Global) -> anyhow::Result<()> {
    let report = check_locally(path).await?;
    output::print(global, &report, || text(&report))?;
    report.require().map_err(failure::shown)
}

/// Checks a capture on this machine.
pub(super) async fn check_locally(path: &Path) -> anyhow::Result<CheckReport> {
    let path = path.to_owned();
    let checked = tokio::task::spawn_blocking(move || {
        let mut report = check_path(&path, &Limits::default());
        // A raw recording has no points to check yet: its images are checked.
        if report.has(RAW_CAPTURE) {
            report.findings = match bendtwin_capture::open(&path, &Limits::default()) {
                Ok(Opened::Raw(recording)) => {
                    report.sources = recording.sources.clone();
                    look(&recording)
                }
                Ok(Opened::Several(parts)) => parts.into_iter().flat_map(look_at).collect(),
                Ok(Opened::Observed(..)) => return report,
                Err(error) => vec![finding(Severity::Error, error.reason(), error.to_string())],
            };
        }
        report
    });
    Ok(checked.await?)
}

/// Findings about one of several recordings, under its name.
fn look_at(part: Part) -> Vec<Finding> {
    let found = match part.opened {
        Opened::Raw(recording) => look(&recording),
        Opened::Observed(capture, notes) => {
            bendtwin_capture::check(&capture).findings.into_iter().chain(notes).collect()
        }
        Opened::Several(parts) => parts.into_iter().flat_map(look_at).collect(),
    };
    let name = part.name;
    let named = |f: Finding| Finding { message: format!("recording `{name}`: {}", f.message), ..f };
    found.into_iter().map(named).collect()
}

/// Findings about a raw recording.
fn look(recording: &Recording) -> Vec<Finding> {
    let (cameras, frames) = (recording.cameras.len(), recording.frame_count);
    let message = format!("a raw recording of {cameras} cameras over {frames} frames");
    let what = finding(Severity::Info, RAW_CAPTURE, message);
    let settings = IngestSettings::default();
    match bendtwin_inspect::inspect(recording, &settings, &CancelToken::default(), &mut |_| {}) {
        Ok(seen) => seen.check_report().findings.into_iter().chain([what]).collect(),
        Err(error) => vec![finding(Severity::Error, error.reason(), error.to_string()), what],
    }
}

fn finding(severity: Severity, code: &str, message: String) -> Finding {
    Finding::from_sentence(severity, code, message)
}

/// The findings and the conclusion.
pub(super) fn text(report: &CheckReport) -> String {
    let verdict = match (report.is_usable(), report.of(Severity::Warning).count()) {
        (false, _) => "This capture cannot be fitted.",
        (true, 0) => "This capture can be fitted.",
        (true, _) => "This capture can be fitted; the warnings name what limits the result.",
    };
    let sources: String = report.sources.lines().map(|line| format!("read     {line}\n")).collect();
    sources + &lines(&report.findings) + verdict
}

/// Findings, a line each.
pub(super) fn lines(findings: &[Finding]) -> String {
    let line = |f: &Finding| {
        let severity = match f.severity {
            Severity::Error => "error",
            Severity::Warning => "warning",
            Severity::Info => "info",
        };
        format!("{severity:<8} {} [{}]\n", f.sentence(), f.code)
    };
    findings.iter().map(line).collect()
}
