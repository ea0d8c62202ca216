//! Errors of benchmarks.

use bendtwin_core::{Category, Problem};
use bendtwin_engine::backend;

/// An error that ends a benchmark.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The scene's points could not be joined.
    #[error(transparent)]
    Graph(#[from] bendtwin_graph::Error),
    /// The simulation failed.
    #[error(transparent)]
    Backend(#[from] backend::Error),
    /// The fit failed.
    #[error(transparent)]
    Fit(#[from] bendtwin_fit::Error),
    /// A scene diverged, so that its times mean nothing.
    #[error(
        "scene {scene} diverged in frame {frame} at node {node}: the backend computes something else"
    )]
    Diverged {
        /// Name of the scene.
        scene: &'static str,
        /// Frame in which it happened, 1-based.
        frame: usize,
        /// First node concerned.
        node: usize,
    },
    /// Even the softest material needs more substeps than a scene has.
    #[error("scene {0} is unstable with every stiffness on the list")]
    Unstable(&'static str),
}

impl Problem for Error {
    fn category(&self) -> Category {
        match self {
            Self::Graph(e) => e.category(),
            Self::Backend(e) => e.category(),
            Self::Fit(e) => e.category(),
            Self::Diverged { .. } | Self::Unstable(_) => Category::Internal,
        }
    }

    fn reason(&self) -> &'static str {
        match self {
            Self::Graph(e) => e.reason(),
            Self::Backend(e) => e.reason(),
            Self::Fit(e) => e.reason(),
            Self::Diverged { .. } => "SCENE_DIVERGED",
            Self::Unstable(_) => "SCENE_UNSTABLE",
        }
    }
}
