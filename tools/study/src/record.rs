//! Record of a run: its identity, the software and device that ran it, and its outcome.

use bendtwin_core::{Category, Fault, FitSettings, Graph, Quality};
use serde::{Deserialize, Serialize};

use crate::{digest, suite::RunId};

/// Raised by every change of [`Record`] that makes older ones unreadable.
pub(crate) const VERSION: u32 = 1;

/// A run's result, as its file has it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Record {
    /// Version of this format.
    pub version: u32,
    /// Id of the run.
    pub run: RunId,
    /// BLAKE3 digest of capture, settings and build, hex: a run that still has it need not be
    /// repeated.
    pub digest: String,
    /// BLAKE3 digest of the capture's content, hex; empty if it could not be read.
    pub capture_digest: String,
    /// The settings in force.
    pub settings: FitSettings,
    /// The software that ran.
    pub build: String,
    /// Kind of backend: `cpu` or `cuda`.
    pub backend: String,
    /// Name of the device for people.
    pub device: String,
    /// The command that makes this run again, without the suite.
    pub command: String,
    /// Outcome of the run.
    pub outcome: Outcome,
}

/// The outcome of a run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Outcome {
    /// A twin and its errors.
    Finished(Box<Finished>),
    /// The reason why there is no twin.
    Failed(Fault),
}

/// The results of a finished run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Finished {
    /// The twin's graph.
    pub graph: GraphCounts,
    /// Losses of the fit.
    pub losses: Losses,
    /// Substeps per frame of the twin.
    pub substeps: u32,
    /// Fewest substeps per frame that the stability estimate finds enough for it.
    pub stable_substeps: u32,
    /// Errors of the twin and of the free baselines, warnings, and the fast variant with its
    /// fidelity.
    pub quality: Quality,
    /// Time that fit and evaluation took [s], over all attempts; what was lost by an interruption
    /// does not count.
    pub fit_s: f64,
}

/// The size of a graph, and a digest of its nodes.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct GraphCounts {
    /// Nodes.
    pub nodes: usize,
    /// Nodes of the surface.
    pub surface_nodes: usize,
    /// Axial springs, those to control points among them.
    pub springs: usize,
    /// Springs between nodes; `None` in records of earlier versions.
    #[serde(default)]
    pub node_springs: Option<usize>,
    /// Bending triplets.
    pub triplets: usize,
    /// Control points.
    pub controls: usize,
    /// BLAKE3 digest of the nodes' rest positions, hex: equal where two twins have the same nodes.
    pub nodes_digest: String,
}

/// Best losses of a fit, in its own units; none for a stage that was left out.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Losses {
    /// After the search.
    pub search: Option<f64>,
    /// After the refinement.
    pub refine: Option<f64>,
}

impl Record {
    /// True if the run would end the same way again: it finished, or its capture or settings were
    /// refused. Other causes of failure, such as a device or a disk, may have passed.
    pub fn is_final(&self) -> bool {
        match &self.outcome {
            Outcome::Finished(_) => true,
            Outcome::Failed(fault) => fault.category == Category::InvalidArgument,
        }
    }

    /// The results, unless the run failed.
    pub fn finished(&self) -> Option<&Finished> {
        match &self.outcome {
            Outcome::Finished(finished) => Some(finished),
            Outcome::Failed(_) => None,
        }
    }
}

impl GraphCounts {
    /// Springs that meet at a node, on average, those to control points apart.
    pub fn mean_degree(&self) -> Option<f64> {
        let springs = self.node_springs.filter(|_| self.nodes > 0)?;
        Some(2.0 * springs as f64 / self.nodes as f64)
    }
}

fn between_nodes(graph: &Graph) -> usize {
    let n = graph.node_count() as u32;
    graph.springs.iter().filter(|[a, b]| a.max(b) < &n).count()
}

impl From<&Graph> for GraphCounts {
    fn from(graph: &Graph) -> Self {
        Self {
            nodes: graph.node_count(),
            surface_nodes: graph.surface_count(),
            springs: graph.springs.len(),
            node_springs: Some(between_nodes(graph)),
            triplets: graph.triplets.len(),
            controls: graph.control_count(),
            nodes_digest: digest::of_nodes(&graph.rest_positions),
        }
    }
}
