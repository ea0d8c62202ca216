//! Errors of a fit.

use bendtwin_core::{ObserverError, Problem, checkpoint::Refusal};
use bendtwin_engine::backend;

/// An error that ends a fit.
#[derive(Debug, thiserror::Error, Problem)]
pub enum Error {
    /// Settings out of range.
    #[error("the fit's settings are wrong: {}", .0.join("; "))]
    #[problem(InvalidArgument, "INVALID_FIT_SETTINGS")]
    Settings(Vec<String>),
    /// The capture has nothing to fit to.
    #[error("the capture cannot be fitted: {0}")]
    #[problem(InvalidArgument, "CAPTURE_CANNOT_BE_FITTED")]
    Capture(String),
    /// The capture cannot become a graph.
    #[error(transparent)]
    Graph(#[from] bendtwin_graph::Error),
    /// The simulation failed.
    #[error(transparent)]
    Backend(#[from] backend::Error),
    /// The finished twin could not be evaluated.
    #[error(transparent)]
    Evaluation(#[from] bendtwin_eval::Error),
    /// The twin to be refined cannot be one.
    #[error("the twin to start from cannot be used ({0}): export it again, or fit without it")]
    #[problem(InvalidArgument, "TWIN_TO_START_FROM_UNUSABLE")]
    Twin(String),
    /// The twin can have no planner's twin.
    #[error("the planner's twin cannot be made: {0}; plan with FAST or EXACT")]
    #[problem(InvalidArgument, "PLANNERS_TWIN_IMPOSSIBLE")]
    Planner(String),
    /// Another recording of the object cannot be brought to the reference.
    #[error(
        "the twin cannot be brought to recording `{name}`: {error}; leave this recording out, or make \
         another one the reference"
    )]
    #[problem(transparent)]
    Recording {
        /// Name of the recording.
        name: String,
        /// The reason.
        error: Box<bendtwin_eval::Error>,
    },
    /// The look of a twin cannot be measured.
    #[error(transparent)]
    Look(#[from] bendtwin_appearance::Error),
    /// No candidate could be simulated to its end.
    #[error(
        "no candidate of the search could be simulated ({0}): raise substeps.auto.max, or narrow the graph"
    )]
    #[problem(InvalidArgument, "NO_STABLE_CANDIDATE")]
    NothingStable(String),
    /// The checkpoint is damaged or of another version.
    #[error("the checkpoint cannot be read ({0}): start the fit again without it")]
    #[problem(FailedPrecondition, "CHECKPOINT_UNREADABLE")]
    Checkpoint(String),
    /// The checkpoint belongs to another fit.
    #[error(
        "the checkpoint belongs to another capture or other settings: start the fit again without it"
    )]
    #[problem(FailedPrecondition, "CHECKPOINT_OF_ANOTHER_FIT")]
    OtherCheckpoint,
    /// The observer could not keep a checkpoint (for example, a lease is lost).
    #[error("the fit's checkpoint could not be kept: {0}")]
    #[problem(Aborted, "CHECKPOINT_NOT_KEPT")]
    Observer(#[source] ObserverError),
}

impl From<Refusal> for Error {
    fn from(refusal: Refusal) -> Self {
        match refusal {
            Refusal::OtherWork => Self::OtherCheckpoint,
            other => Self::Checkpoint(other.to_string()),
        }
    }
}
