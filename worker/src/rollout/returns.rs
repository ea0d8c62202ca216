//! Arrays that a request wants back.

use std::sync::Arc;

use bendtwin_core::Graph;
use bendtwin_engine::backend::{Diagnose, Outputs};
use bendtwin_proto::v1::{Returns as Wire, returns::Encoding};

use super::error::Error;

/// Arrays that are wanted back, of a checked request.
#[derive(Clone, Debug, Default)]
pub(super) struct Returns {
    /// Record every k-th frame; 0 records none.
    pub(super) every: usize,
    /// Nodes to record; none means all.
    pub(super) nodes: Option<Arc<Vec<u32>>>,
    /// Positions as scaled 16-bit integers.
    pub(super) int16: bool,
    /// Frames of a part of the reply, if it is divided in time.
    pub(super) part_frames: Option<usize>,
    /// Arrays of only so many instances, the best by cost.
    pub(super) best: Option<usize>,
    pub(super) final_state: bool,
    pub(super) diagnostics: bool,
    pub(super) control_gradients: bool,
    pub(super) action_gradients: bool,
    pub(super) forces: bool,
    pub(super) initial_gradients: bool,
    pub(super) gradient_norms: bool,
    pub(super) velocities: bool,
    pub(super) frame_costs: bool,
    pub(super) controls: bool,
}

impl Returns {
    /// Reads the returns of a checked request of `instances` instances.
    pub(super) fn read(wire: Option<Wire>, instances: usize) -> Result<Self, Error> {
        let Some(wire) = wire else { return Ok(Self::default()) };
        let int16 = wire.encoding() == Encoding::Int16;
        let nodes = wire
            .nodes
            .filter(|t| !t.is_absent())
            .map(|t| t.unpack("returns.nodes").map(|(_, nodes)| Arc::new(nodes)))
            .transpose()?;
        Ok(Self {
            every: wire.every_frames as usize,
            nodes,
            int16,
            part_frames: (wire.part_frames > 0).then_some(wire.part_frames as usize),
            best: (wire.best > 0).then(|| (wire.best as usize).min(instances)),
            final_state: wire.final_state,
            diagnostics: wire.diagnostics,
            control_gradients: wire.control_gradients,
            action_gradients: wire.action_gradients,
            forces: wire.forces,
            initial_gradients: wire.initial_gradients,
            gradient_norms: wire.gradient_norms,
            velocities: wire.velocities,
            frame_costs: wire.frame_costs,
            controls: wire.controls,
        })
    }

    /// Number of recorded frames T' among so many.
    pub(super) fn recorded_frames(&self, frames: usize) -> usize {
        frames.checked_div(self.every).unwrap_or(0)
    }

    /// Recorded nodes K.
    pub(super) fn recorded_nodes(&self, graph: &Graph) -> usize {
        self.nodes.as_ref().map_or(graph.node_count(), |n| n.len())
    }

    /// True if arrays beside the costs are wanted.
    pub(super) fn has_arrays(&self) -> bool {
        self.has_recordings() || self.has_gradients()
    }

    /// True if the arrays need a simulation beside that of the costs.
    pub(super) fn has_recordings(&self) -> bool {
        self.every > 0 || self.final_state || self.forces || self.frame_costs || self.controls
    }

    /// True if the arrays need a run backward.
    pub(super) fn has_gradients(&self) -> bool {
        self.control_gradients
            || self.action_gradients
            || self.initial_gradients
            || self.gradient_norms
    }

    /// Outputs of the engine where arrays are wanted.
    pub(super) fn outputs(&self) -> Outputs {
        Outputs {
            every: self.every,
            initial: false,
            nodes: self.nodes.clone(),
            final_state: self.final_state,
            diagnose: self.diagnose(),
            forces: self.forces,
            velocities: self.velocities,
            frame_costs: self.frame_costs,
        }
    }

    /// Outputs of the engine where only costs count.
    pub(super) fn summary(&self) -> Outputs {
        Outputs { diagnose: self.diagnose(), ..Outputs::default() }
    }

    /// Extremes, which tell how plausible a rollout is, in any case.
    fn diagnose(&self) -> Diagnose {
        if self.diagnostics { Diagnose::All } else { Diagnose::Extremes }
    }
}
