//! Errors of making captures.

use bendtwin_core::{Category, Problem};

/// Reason for which a capture cannot be made.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// A scene that cameras do not film.
    #[error("the scene `{0}` is motion capture, not filmed: take rope or toy for a raw recording")]
    NotFilmed(&'static str),
    /// The simulation failed.
    #[error("the generator's simulation failed: {0}")]
    Simulation(String),
    /// The result contradicts itself.
    #[error(transparent)]
    Capture(#[from] bendtwin_capture::Error),
}

impl Problem for Error {
    fn category(&self) -> Category {
        match self {
            Self::NotFilmed(_) => Category::InvalidArgument,
            Self::Simulation(_) => Category::Internal,
            Self::Capture(e) => e.category(),
        }
    }

    fn reason(&self) -> &'static str {
        match self {
            Self::NotFilmed(_) => "SCENE_NOT_FILMED",
            Self::Simulation(_) => "SIMULATION_FAILED",
            Self::Capture(e) => e.reason(),
        }
    }
}
