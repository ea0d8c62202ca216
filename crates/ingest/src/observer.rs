//! Who is told how an ingest goes on.

use serde::{Deserialize, Serialize};

use crate::ObserverError;

/// What an ingest is doing.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Step {
    /// Tracking points through the colour images, where the recording has no tracks.
    Track,
    /// Reading frames, cleaning masks, lifting tracks.
    Lift,
    /// Filtering motion, thinning, control points.
    Assemble,
    /// Aligning and sampling the mesh.
    Complete,
}

/// How far an ingest is.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Progress {
    /// The step under way.
    pub step: Step,
    /// Share of the whole ingest that is done, 0..=1.
    pub fraction: f64,
}

/// Who is told how an ingest goes on.
pub trait Observer {
    /// Called after every unit of work.
    fn progress(&mut self, progress: Progress);

    /// Called after every unit of work with all that is needed to go on from there in another process.
    ///
    /// # Errors
    /// If the ingest should end, because the checkpoint cannot be kept.
    fn checkpoint(&mut self, checkpoint: Vec<u8>) -> Result<(), ObserverError>;
}

/// An observer that looks away.
impl Observer for () {
    fn progress(&mut self, _progress: Progress) {}

    fn checkpoint(&mut self, _checkpoint: Vec<u8>) -> Result<(), ObserverError> {
        Ok(())
    }
}
