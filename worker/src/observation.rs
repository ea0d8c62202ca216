//! Observations, which ingests make of captures, as fits and rollouts read them. They are bundles
//! that a process of this project wrote, so they are trusted.

use std::path::Path;

use bendtwin_capture as capture;
use bendtwin_core::{Capture, Views};

use crate::Limits;

/// Resource name of the observation of a capture.
pub(crate) fn name(capture: &str) -> String {
    format!("{capture}/observation")
}

/// Reads an observation, structurally sound.
pub(crate) fn read(path: &Path, limits: &Limits) -> Result<Capture, capture::Error> {
    capture::read(path, &bounds(limits))
}

/// Reads the views of an observation, if it has any.
pub(crate) fn read_views(path: &Path, limits: &Limits) -> Result<Option<Views>, capture::Error> {
    capture::read_views(path, &bounds(limits))
}

fn bounds(limits: &Limits) -> capture::Limits {
    let standard = capture::Limits::default();
    capture::Limits {
        total_bytes: limits.capture_bytes,
        file_bytes: standard.file_bytes.min(limits.capture_bytes),
        ..standard
    }
}
