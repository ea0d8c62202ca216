//! Plan of a request: the instances to be simulated, and the arrays to
//! return.

use std::sync::Arc;

use bendtwin_core::{Point, Twin};
use bendtwin_engine::{Objective, backend::Instance};
use bendtwin_proto::rollout::TwinShape;

use super::{
    actions::{Actions, Horizon},
    checked::Checked,
    costs,
    error::Error,
    initial::{Starts, Wanted},
    returns::Returns,
    serve::Served,
};

/// A checked request.
pub(super) struct Plan {
    pub(super) served: Served,
    pub(super) actions: Actions,
    pub(super) frames: usize,
    pub(super) objective: Objective,
    pub(super) returns: Returns,
    /// Number of grasps.
    pub(super) grasps: usize,
    /// Instances of one part of the reply.
    pub(super) part: usize,
    /// Instances that are prepared at once.
    pub(super) prepared: usize,
}

impl Plan {
    /// Reads a request, whose memory has been taken; also returns the initial state that it asks
    /// for.
    pub(super) fn new(
        checked: Checked,
        part_instances: u32,
        served: Served,
    ) -> Result<(Self, Wanted), Error> {
        let Checked { request, batch, prepared, .. } = checked;
        let graph = &served.warm.twin.graph;
        let (instances, frames) = (batch.instances as usize, batch.frames as usize);
        let fps = served.warm.twin.timing.fps;
        let horizon = Horizon { frames, fps, times: request.knot_times };
        let actions = Actions::read(request.actions, graph.control_count(), horizon)?;
        let objective = costs::read(request.costs, frames)?;
        let returns = Returns::read(request.returns, instances)?;
        let wanted = Wanted::read(request.initial, graph, instances)?;

        let grasps = request.grasps.len();
        let part = if part_instances == 0 { instances } else { part_instances as usize };
        let part = part.min(instances);
        Ok((Self { actions, frames, objective, returns, grasps, part, prepared, served }, wanted))
    }

    /// The twin.
    pub(super) fn twin(&self) -> &Twin {
        &self.served.warm.twin
    }

    /// Number of instances B.
    pub(super) fn instances(&self) -> usize {
        self.actions.shape().instances
    }

    /// An instance, ready for the engine.
    pub(super) fn instance(&self, index: usize, starts: &Starts) -> Instance {
        let start = starts.of(index);
        let controls: Vec<Point> = self.actions.controls(index, &start.controls);
        Instance {
            model: self.served.loaded.clone(),
            initial: Arc::clone(&start.state),
            controls: Arc::new(controls),
            frames: self.frames,
            objective: self.objective.clone(),
            world: Arc::default(),
            motion: Arc::default(),
        }
    }
}

/// Facts of a twin that requests are checked against.
pub(super) fn shape(twin: &Twin, has_capture: bool) -> TwinShape {
    let graph = &twin.graph;
    TwinShape {
        nodes: graph.node_count() as u64,
        springs: graph.springs.len() as u64,
        triplets: graph.triplets.len() as u64,
        controls: graph.control_count() as u64,
        rods: Some(graph.rods.len() as u64),
        substeps: twin.timing.substeps,
        fast_substeps: twin.quality.fast.map(|fast| fast.substeps),
        has_capture,
    }
}
