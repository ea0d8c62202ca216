//! Captures are parsed here, in the worker, under its memory limit: never in the server.

use std::path::Path;

use bendtwin_capture as capture;
use bendtwin_core::Capture;

use crate::Limits;

/// Reads a capture archive, structurally sound.
pub(crate) fn read(path: &Path, limits: &Limits) -> Result<Capture, capture::Error> {
    capture::read(path, &bounds(limits))
}

/// Reads a capture archive and refuses one that cannot be fitted. Errors call it by `name`: its path
/// here is a temporary file's, which tells nobody anything.
pub(crate) fn read_checked(
    path: &Path,
    name: &str,
    limits: &Limits,
) -> Result<Capture, capture::Error> {
    use capture::Error::{RawOnly, UnknownKind};
    let read = capture::read_checked(path, &bounds(limits)).map_err(|e| match e {
        UnknownKind(_) => UnknownKind(name.to_owned()),
        RawOnly(_) => RawOnly(name.to_owned()),
        other => other,
    });
    let (capture, report) = read?;
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
