//! Twin files on this machine.

use std::path::Path;

use anyhow::Context as _;
use bendtwin_core::Twin;

use crate::failure;

/// Reads a twin file.
///
/// # Errors
/// If it cannot be read or is not a twin file; the message names it.
pub fn read(path: &Path) -> anyhow::Result<Twin> {
    let bytes = std::fs::read(path).with_context(|| format!("cannot read {}", path.display()))?;
    Twin::decode(&bytes).map_err(failure::failed).with_context(|| path.display().to_string())
}
