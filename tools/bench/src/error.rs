//! Errors of benchmarks.

use bendtwin_core::Problem;
use bendtwin_engine::backend;

/// An error that ends a benchmark.
#[derive(Debug, thiserror::Error, Problem)]
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
    #[problem(Internal, "SCENE_DIVERGED")]
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
    #[problem(Internal, "SCENE_UNSTABLE")]
    Unstable(&'static str),
}
