//! Preparation of a recording of cameras: what was added to it, its calibration, and masks made of
//! strokes.

use bendtwin_capture::raw::Recording;
use bendtwin_core::{Fault, Finding, Observer};

use crate::{Progress, Work};

/// A recording ready to be inspected.
pub(crate) struct Prepared {
    /// With the poses and masks in use.
    pub(crate) recording: Recording,
    /// What was found on the way.
    pub(crate) findings: Vec<Finding>,
}

/// Prepares a recording.
pub(crate) fn prepare(
    _work: &Work<'_>,
    recording: Recording,
    _observer: &mut dyn Observer<Progress>,
) -> Result<Prepared, Fault> {
    Ok(Prepared { recording, findings: Vec::new() })
}
