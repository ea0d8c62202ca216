//! A request after every check: what will be simulated, and that it fits.

use std::sync::Arc;

use bendtwin_core::{Point, Twin};
use bendtwin_engine::{Objective, backend::Instance};
use bendtwin_proto::v1::RollOutRequest;

use super::{
    actions::Actions,
    costs,
    error::Error,
    initial::{Starts, Wanted},
    returns::Returns,
    serve::Served,
};
use crate::Limits;

/// What a lookup of one target point costs, in element substeps.
const TARGET_WORK: u128 = 20;

/// A checked request.
pub(super) struct Plan {
    pub(super) served: Served,
    pub(super) actions: Actions,
    pub(super) frames: usize,
    pub(super) objective: Objective,
    pub(super) returns: Returns,
    /// Instances of one part of the reply.
    pub(super) part: usize,
    /// Instances that are prepared at once.
    pub(super) chunk: usize,
}

impl Plan {
    /// Checks a request to a twin; also says where it wants to start.
    pub(super) fn new(
        request: RollOutRequest,
        own_capture: &str,
        part_instances: u32,
        served: Served,
        limits: &Limits,
    ) -> Result<(Self, Wanted), Error> {
        let graph = &served.warm.twin.graph;
        let actions = Actions::read(request.actions, graph.control_count(), limits.instances)?;
        let frames = actions.horizon(request.frames)?;
        let instances = actions.shape().instances;
        let objective = costs::read(request.costs, graph, frames)?;
        let has_costs = !objective.groups.is_empty();
        let returns = Returns::read(request.returns, graph, instances, has_costs)?;
        let wanted = Wanted::read(request.initial, graph, instances, own_capture)?;

        let part = if part_instances == 0 { instances } else { part_instances as usize };
        let part = part.min(instances);
        let control_bytes = 12 * (frames as u64 + 1) * graph.control_count().max(1) as u64;
        let chunk = (limits.reply_bytes / control_bytes).clamp(1, part as u64) as usize;
        let plan = Self { actions, frames, objective, returns, part, chunk, served };
        plan.check_work(limits)?;
        plan.check_reply(limits)?;
        Ok((plan, wanted))
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
        let controls: Vec<Point> = self.actions.controls(index, self.frames, &start.controls);
        Instance {
            model: self.served.loaded.clone(),
            initial: Arc::clone(&start.state),
            controls: Arc::new(controls),
            frames: self.frames,
            objective: self.objective.clone(),
        }
    }

    fn check_work(&self, limits: &Limits) -> Result<(), Error> {
        let graph = &self.twin().graph;
        let elements = graph.node_count() + graph.springs.len() + graph.triplets.len();
        let steps = self.frames as u128 * u128::from(self.served.loaded.model().timing.substeps);
        let targets: u128 = self.objective.terms.iter().map(|t| target_count(&t.term)).sum();
        let each = steps * elements as u128 + targets * TARGET_WORK;
        let work = each * self.instances() as u128;
        if work > u128::from(limits.rollout_work) {
            return Err(Error::TooLarge {
                what: "the work (instances x frames x substeps x (nodes + springs + triplets))",
                asked: work,
                limit: u128::from(limits.rollout_work),
                advice: "send fewer instances or a shorter horizon, or use a coarser twin",
            });
        }
        Ok(())
    }

    fn check_reply(&self, limits: &Limits) -> Result<(), Error> {
        let holders = self.returns.best.unwrap_or(self.part) as u128;
        let each = u128::from(self.returns.instance_bytes(&self.twin().graph, self.frames));
        // Costs per term and instance come on top, in f64.
        let terms = self.instances() as u128 * (self.objective.groups.len() as u128 + 1) * 8;
        let bytes = holders * each + terms;
        if bytes > u128::from(limits.reply_bytes) {
            return Err(Error::TooLarge {
                what: "the size of the reply in bytes",
                asked: bytes,
                limit: u128::from(limits.reply_bytes),
                advice: "ask for fewer nodes (returns.nodes), every k-th frame (returns.every_frames) or the best few (returns.best), or stream it",
            });
        }
        Ok(())
    }
}

fn target_count(term: &bendtwin_engine::Term) -> u128 {
    match term {
        bendtwin_engine::Term::Chamfer { targets }
        | bendtwin_engine::Term::Track { targets, .. } => targets.len() as u128,
        bendtwin_engine::Term::Acceleration => 1,
    }
}
