//! Captures are parsed here, in the worker, under its memory limit: never in the server.

use std::path::Path;

use bendtwin_capture as capture;
use bendtwin_core::Capture;

use crate::Limits;

/// Reads a capture archive, structurally sound.
pub(crate) fn read(path: &Path, limits: &Limits) -> Result<Capture, capture::Error> {
    capture::read(path, &bounds(limits))
}

/// Reads a capture archive and refuses one that cannot be fitted.
pub(crate) fn read_checked(path: &Path, limits: &Limits) -> Result<Capture, capture::Error> {
    let (capture, report) = capture::read_checked(path, &bounds(limits))?;
    for finding in &report.findings {
        tracing::info!(code = finding.code, "capture: {}", finding.message);
    }
    Ok(capture)
}

fn bounds(limits: &Limits) -> capture::Limits {
    let standard = capture::Limits::default();
    capture::Limits {
        total_bytes: limits.capture_bytes,
        file_bytes: standard.file_bytes.min(limits.capture_bytes),
        ..standard
    }
}
