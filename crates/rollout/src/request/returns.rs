//! Arrays that a request wants back.

use bendtwin_core::Twin;
use bendtwin_engine::backend::{Diagnose, Outputs, Rollout};
use bendtwin_proto::v1::{Returns as Wire, returns::Encoding};

use crate::{error::Error, request::recorded::Recorded};

/// Arrays that are wanted back, of a checked request.
#[derive(Clone, Debug, Default)]
pub(crate) struct Returns {
    /// Record every k-th frame; 0 records none.
    pub(crate) every: usize,
    /// Points to record.
    pub(crate) recorded: Recorded,
    /// Positions as scaled 16-bit integers.
    pub(crate) int16: bool,
    /// Frames of a part of the reply, if it is divided in time.
    pub(crate) part_frames: Option<usize>,
    /// Number of instances whose arrays are returned, the best by cost.
    pub(crate) best: Option<usize>,
    pub(crate) final_state: bool,
    pub(crate) diagnostics: bool,
    pub(crate) control_gradients: bool,
    pub(crate) action_gradients: bool,
    pub(crate) forces: bool,
    pub(crate) initial_gradients: bool,
    pub(crate) gradient_norms: bool,
    pub(crate) velocities: bool,
    pub(crate) frame_costs: bool,
    pub(crate) controls: bool,
    /// The spread of an ensemble, and arrays of its first member alone.
    pub(crate) spread: bool,
}

impl Returns {
    /// Reads the returns of a checked request of `instances` instances.
    pub(crate) fn read(wire: Option<Wire>, twin: &Twin, instances: usize) -> Result<Self, Error> {
        let Some(mut wire) = wire else { return Ok(Self::default()) };
        let int16 = wire.encoding() == Encoding::Int16;
        let recorded = Recorded::read(&mut wire, &twin.skin, twin.graph.node_count())?;
        Ok(Self {
            every: wire.every_frames as usize,
            recorded,
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
            spread: wire.spread,
        })
    }

    /// Number of recorded frames T' among `frames`.
    pub(crate) fn recorded_frames(&self, frames: usize) -> usize {
        frames.checked_div(self.every).unwrap_or(0)
    }

    /// True if arrays beside the costs are wanted.
    pub(crate) fn has_arrays(&self) -> bool {
        self.has_recordings() || self.has_gradients()
    }

    /// True if the arrays need a simulation beside that of the costs.
    pub(crate) fn has_recordings(&self) -> bool {
        self.every > 0 || self.final_state || self.forces || self.frame_costs || self.controls
    }

    /// True if the arrays need a run backward.
    pub(crate) fn has_gradients(&self) -> bool {
        self.control_gradients
            || self.action_gradients
            || self.initial_gradients
            || self.gradient_norms
    }

    /// Outputs of the engine where arrays are wanted.
    pub(crate) fn outputs(&self) -> Outputs {
        Outputs {
            every: self.every,
            initial: false,
            nodes: self.recorded.nodes().cloned(),
            final_state: self.final_state,
            diagnose: self.diagnose(),
            forces: self.forces,
            velocities: self.velocities,
            frame_costs: self.frame_costs,
        }
    }

    /// Outputs of the engine where only costs count.
    pub(crate) fn summary(&self) -> Outputs {
        Outputs { diagnose: self.diagnose(), ..Outputs::default() }
    }

    /// Keeps the frames and nodes that are asked for of a recording of all nodes in all frames, with
    /// frame 0 or without it.
    pub(crate) fn thin_out(&self, recording: &mut Rollout) {
        let nodes = recording.positions.len() / recording.frames.len().max(1);
        let start = usize::from(recording.frames.first() == Some(&0));
        let most = if self.every > 0 { usize::MAX } else { 0 };
        for values in [&mut recording.positions, &mut recording.velocities] {
            let frames = values.chunks_exact(nodes.max(1)).skip(start + self.every.max(1) - 1);
            let frames = frames.step_by(self.every.max(1)).take(most);
            *values = match self.recorded.nodes() {
                None => frames.flatten().copied().collect(),
                Some(some) => {
                    frames.flat_map(|row| some.iter().map(|&i| row[i as usize])).collect()
                }
            };
        }
    }

    /// Extremes, which are always computed to judge the plausibility of a rollout.
    fn diagnose(&self) -> Diagnose {
        if self.diagnostics { Diagnose::All } else { Diagnose::Extremes }
    }
}
