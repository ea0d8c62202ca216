//! What a request wants back, and how large that is.

use std::sync::Arc;

use bendtwin_core::Graph;
use bendtwin_engine::backend::Outputs;
use bendtwin_proto::v1::{Returns as Wire, returns::Encoding};

use super::{costs, error::Error};

/// What is wanted back, checked against the twin.
#[derive(Clone, Debug, Default)]
pub(super) struct Returns {
    /// Record every k-th frame; 0 records none.
    pub(super) every: usize,
    /// Nodes to record; none means all.
    pub(super) nodes: Option<Arc<Vec<u32>>>,
    /// Positions as scaled 16-bit integers.
    pub(super) int16: bool,
    /// Arrays of only so many instances, the best by cost.
    pub(super) best: Option<usize>,
    pub(super) final_state: bool,
    pub(super) diagnostics: bool,
    pub(super) control_gradients: bool,
}

impl Returns {
    pub(super) fn read(
        wire: Option<Wire>,
        graph: &Graph,
        instances: usize,
        has_costs: bool,
    ) -> Result<Self, Error> {
        let Some(wire) = wire else { return Ok(Self::default()) };
        let int16 = match Encoding::try_from(wire.encoding) {
            Ok(Encoding::Unspecified | Encoding::Float32) => false,
            Ok(Encoding::Int16) => true,
            Err(_) => {
                let fault =
                    format!("has the unknown value {}: use FLOAT32 or INT16", wire.encoding);
                return Err(Error::field("returns.encoding", fault));
            }
        };
        let nodes = wire
            .nodes
            .filter(|t| !t.is_absent())
            .map(|t| costs::nodes(t, "returns.nodes", graph.node_count()).map(Arc::new))
            .transpose()?;
        if wire.control_gradients && !has_costs {
            let fault = "needs at least one cost to differentiate: add one to `costs`";
            return Err(Error::field("returns.control_gradients", fault));
        }
        Ok(Self {
            every: wire.every_frames as usize,
            nodes,
            int16,
            best: (wire.best > 0).then(|| (wire.best as usize).min(instances)),
            final_state: wire.final_state,
            diagnostics: wire.diagnostics,
            control_gradients: wire.control_gradients,
        })
    }

    /// Recorded frames T' of a rollout of `frames` frames.
    pub(super) fn recorded_frames(&self, frames: usize) -> usize {
        frames.checked_div(self.every).unwrap_or(0)
    }

    /// Recorded nodes K.
    pub(super) fn recorded_nodes(&self, graph: &Graph) -> usize {
        self.nodes.as_ref().map_or(graph.node_count(), |n| n.len())
    }

    /// Bytes of the arrays that one instance adds to a reply.
    pub(super) fn instance_bytes(&self, graph: &Graph, frames: usize) -> u64 {
        let points = self.recorded_frames(frames) as u64 * self.recorded_nodes(graph) as u64;
        // Positions pass through memory as f32 whatever the encoding.
        let states = if self.final_state { 2 * graph.node_count() as u64 } else { 0 };
        let gradients = if self.control_gradients {
            (frames as u64 + 1) * graph.control_count() as u64
        } else {
            0
        };
        12 * (points + states + gradients)
    }

    /// Whether arrays beside the costs are wanted.
    pub(super) fn has_arrays(&self) -> bool {
        self.every > 0 || self.final_state || self.control_gradients
    }

    /// Whether a simulation beside that of the costs is needed for the arrays.
    pub(super) fn has_recordings(&self) -> bool {
        self.every > 0 || self.final_state
    }

    /// What the engine should record where arrays are wanted.
    pub(super) fn outputs(&self) -> Outputs {
        Outputs {
            every: self.every,
            initial: false,
            nodes: self.nodes.clone(),
            final_state: self.final_state,
            diagnostics: self.diagnostics,
        }
    }

    /// What the engine should record where only costs count.
    pub(super) fn summary(&self) -> Outputs {
        Outputs { diagnostics: self.diagnostics, ..Outputs::default() }
    }
}
