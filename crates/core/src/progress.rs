//! Progress of a fit.

mod preview;

use std::sync::Arc;

use serde::{Deserialize, Serialize};

pub use preview::{Preview, PreviewErrors};

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
    /// Training Gaussians on the images of a raw recording.
    Appearance,
}

impl Stage {
    /// Name in documents and logs, for example `search`.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Ingest => "ingest",
            Self::Search => "search",
            Self::Refine => "refine",
            Self::Evaluate => "evaluate",
            Self::Appearance => "appearance",
        }
    }

    /// The stage of a name.
    pub fn parse(name: &str) -> Option<Self> {
        [Self::Ingest, Self::Search, Self::Refine, Self::Evaluate, Self::Appearance]
            .into_iter()
            .find(|stage| stage.as_str() == name)
    }
}

/// Loss of a model after an iteration.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ModelLoss {
    /// Stage of the iteration.
    pub stage: Stage,
    /// Model, as in [`Progress::variant`].
    pub variant: String,
    /// Iterations of the stage that were done.
    pub iteration: u32,
    /// Loss of that iteration, in the fit's own units; none if it was not finite.
    pub loss: Option<f64>,
    /// Lowest loss up to it.
    pub best_loss: Option<f64>,
    /// Error over the training frames with the best parameters up to it [m], as [`PreviewErrors`] has
    /// it; none of an iteration without a preview.
    #[serde(default)]
    pub error_m: Option<f64>,
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
    /// The last loss of each model that is fitted side by side with others.
    #[serde(default)]
    pub models: Vec<ModelLoss>,
    /// Error over the training frames of the newest preview [m].
    #[serde(default)]
    pub error_m: Option<f64>,
    /// The preview that was made in this iteration, if one was. It goes its own way, not into documents.
    #[serde(skip)]
    pub preview: Option<Arc<Preview>>,
}

impl Progress {
    /// Loss in this report; `None` for a stage without losses.
    pub fn model_loss(&self) -> Option<ModelLoss> {
        let has_losses = matches!(self.stage, Stage::Search | Stage::Refine | Stage::Appearance);
        has_losses.then(|| ModelLoss {
            stage: self.stage,
            variant: self.variant.clone(),
            iteration: self.iteration,
            loss: self.loss,
            best_loss: self.best_loss,
            error_m: self.preview.as_ref().map(|preview| preview.errors.error_m),
        })
    }
}
