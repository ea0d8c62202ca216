//! A fit from its capture to its twin.

use std::sync::Arc;

use bendtwin_core::{Capture, FitSettings, Progress, Twin};
use bendtwin_engine::{Backend, backend::CancelToken};

use crate::{Error, ObserverError};

/// One fit: what to fit, how, and on which device.
#[derive(Clone)]
pub struct FitJob<'a> {
    /// What was recorded.
    pub capture: &'a Capture,
    /// BLAKE3 digest of the capture's content, hex; kept in the twin's provenance.
    pub capture_digest: String,
    /// How to fit.
    pub settings: FitSettings,
    /// What simulates.
    pub backend: Arc<dyn Backend>,
}

/// Who is told how a fit goes on.
pub trait Observer {
    /// Called after every iteration.
    fn progress(&mut self, progress: Progress);

    /// Called after every iteration with all that is needed to go on from there in another process.
    ///
    /// # Errors
    /// If the fit should end, because the checkpoint cannot be kept.
    fn checkpoint(&mut self, checkpoint: Vec<u8>) -> Result<(), ObserverError>;
}

/// An observer that looks away.
impl Observer for () {
    fn progress(&mut self, _progress: Progress) {}

    fn checkpoint(&mut self, _checkpoint: Vec<u8>) -> Result<(), ObserverError> {
        Ok(())
    }
}

/// What a fit makes.
#[derive(Clone, Debug, PartialEq)]
pub struct Outcome {
    /// The twin with its quality table. The same capture, settings, build and device give the same
    /// twin, however often the fit was interrupted.
    pub twin: Twin,
    /// The axial-only fit of the same nodes, if the settings ask for the comparison.
    pub axial: Option<Twin>,
}

impl FitJob<'_> {
    /// Fits, from the start or from a checkpoint of the same fit.
    ///
    /// # Errors
    /// If settings or capture are wrong, the checkpoint belongs elsewhere, the backend fails, the
    /// observer asks to stop, or `cancel` is set (within a second).
    pub fn run(
        &self,
        checkpoint: Option<&[u8]>,
        observer: &mut dyn Observer,
        cancel: &CancelToken,
    ) -> Result<Outcome, Error> {
        let _ = (checkpoint, observer, cancel);
        Err(Error::Capture("fitting follows".into()))
    }
}
