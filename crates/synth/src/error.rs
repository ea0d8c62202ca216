//! Errors of making captures.

use bendtwin_core::Problem;

/// Reason for which a capture cannot be made.
#[derive(Debug, thiserror::Error, Problem)]
pub enum Error {
    /// A scene that cameras do not film.
    #[error("the scene `{0}` is motion capture, not filmed: take rope or toy for a raw recording")]
    #[problem(InvalidArgument, "SCENE_NOT_FILMED")]
    NotFilmed(&'static str),
    /// The simulation failed.
    #[error("the generator's simulation failed: {0}")]
    #[problem(Internal, "SIMULATION_FAILED")]
    Simulation(String),
    /// The result contradicts itself.
    #[error(transparent)]
    Capture(#[from] bendtwin_capture::Error),
}
