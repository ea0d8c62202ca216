//! `bendtwin capture check`.

use std::path::Path;

use bendtwin_capture::{CheckReport, Limits, Severity, check_path};

use crate::{args::Global, failure, output};

pub(super) async fn run(path: &Path, global: &Global) -> anyhow::Result<()> {
    let report = check_locally(path).await?;
    output::print(global, &report, || text(&report))?;
    report.require().map_err(failure::failed)
}

/// Checks a capture on this machine.
pub(super) async fn check_locally(path: &Path) -> anyhow::Result<CheckReport> {
    let path = path.to_owned();
    Ok(tokio::task::spawn_blocking(move || check_path(&path, &Limits::default())).await?)
}

/// The findings, a line each.
pub(super) fn text(report: &CheckReport) -> String {
    let lines = report.findings.iter().map(|f| {
        let severity = match f.severity {
            Severity::Error => "error",
            Severity::Warning => "warning",
            Severity::Info => "info",
        };
        format!("{severity:<8} {} [{}]\n", f.message, f.code)
    });
    let findings: String = lines.collect();
    let verdict = match (report.is_usable(), report.of(Severity::Warning).count()) {
        (false, _) => "This capture cannot be fitted as it is.",
        (true, 0) => "This capture is fit for fitting.",
        (true, _) => "This capture can be fitted; the warnings say what holds it back.",
    };
    findings + verdict
}
