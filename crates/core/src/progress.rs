//! Progress of a fit.

use serde::{Deserialize, Serialize};

/// The stages of a fit job, in order.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Stage {
    /// Reading and checking the capture.
    Ingest,
    /// Zeroth-order search over global variables (CMA-ES).
    Search,
    /// First-order refinement of every spring and triplet (Adam).
    Refine,
    /// Scoring the twin on training and future frames.
    Evaluate,
}

impl Stage {
    /// Its name in documents and lines, for example `search`.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Ingest => "ingest",
            Self::Search => "search",
            Self::Refine => "refine",
            Self::Evaluate => "evaluate",
        }
    }
}

/// A progress report of a running fit.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Progress {
    /// The stage under way.
    pub stage: Stage,
    /// Model that is being fitted, where a job fits more than one: `bending` or `axial`.
    pub variant: String,
    /// Iterations of the stage that are done.
    pub iteration: u32,
    /// Iterations that the stage will have.
    pub iterations: u32,
    /// Share of the whole job that is done, 0..=1.
    pub fraction: f64,
    /// Loss of the last iteration, in the fit's own units.
    pub loss: Option<f64>,
    /// Best loss so far.
    pub best_loss: Option<f64>,
    /// Estimated seconds until the job ends.
    pub eta_s: Option<f64>,
    /// A message for people (a rollback, a raised number of substeps).
    pub note: Option<String>,
}
