//! Runs a plan and makes the parts of its reply.

use std::{ops::Range, time::Instant};

use bendtwin_core::{CancelToken, Params, Point};
use bendtwin_engine::{
    Backend as _,
    backend::{self, Gradient, GradientRequest, Instance, Outputs, Rollout},
};
use bendtwin_proto::v1::{RollOutResponse, roll_out_response::Timing};

use super::{
    error::Error,
    initial::Starts,
    plan::Plan,
    plausible::Extremes,
    reply::{self, Gradients},
    returns::Returns,
};
use crate::cut;
use crate::device::QueuedBackend;

/// A plan being carried out.
pub(super) struct Execution<'a> {
    pub(super) plan: &'a Plan,
    pub(super) starts: &'a Starts,
    pub(super) backend: &'a QueuedBackend,
    pub(super) cancel: &'a CancelToken,
    /// When the request arrived.
    pub(super) arrived: Instant,
    /// Name of this worker.
    pub(super) worker: &'a str,
}

/// Instances that were simulated.
#[derive(Default)]
struct Simulated {
    rollouts: Vec<Rollout>,
    /// Extremes of what was prescribed to them.
    extremes: Vec<Extremes>,
    /// With their final states, the control points there [m], shape [instances, C, 3].
    controls: Vec<Point>,
}

impl Execution<'_> {
    /// Simulates everything and hands out the parts in order. `emit` says whether anyone listens
    /// still.
    pub(super) fn run(
        &self,
        mut emit: impl FnMut(RollOutResponse) -> Result<(), Error>,
    ) -> Result<(), Error> {
        self.refuse_implausible()?;
        match self.plan.returns.best {
            None => self.each_part(&mut emit),
            Some(best) => self.best_last(best, &mut emit),
        }
    }

    /// Every part has the arrays of its own instances.
    fn each_part(
        &self,
        emit: &mut impl FnMut(RollOutResponse) -> Result<(), Error>,
    ) -> Result<(), Error> {
        let outputs = self.plan.returns.outputs();
        for range in self.parts() {
            let indices = self.plan.instances(range);
            let Simulated { rollouts, extremes, controls } = self.roll_out(&indices, &outputs)?;
            let mut part = self.summary(&indices, &rollouts, &extremes)?;
            reply::add_recordings(self.plan, &indices, &rollouts, &controls, &mut part);
            self.add_gradients(&indices, &mut part)?;
            emit(self.signed(part))?;
        }
        Ok(())
    }

    /// All costs first; then the best instances once more, recorded. Runs are bit-identical, so
    /// this costs k simulations and saves the memory of all others' arrays. The last part has them.
    fn best_last(
        &self,
        best: usize,
        emit: &mut impl FnMut(RollOutResponse) -> Result<(), Error>,
    ) -> Result<(), Error> {
        let outputs = Returns::summary();
        let mut costs = Vec::with_capacity(self.plan.actions());
        let mut held: Option<RollOutResponse> = None;
        for range in self.parts() {
            let indices = self.plan.instances(range);
            let Simulated { rollouts, extremes, .. } = self.roll_out(&indices, &outputs)?;
            let part = self.summary(&indices, &rollouts, &extremes)?;
            costs.extend(reply::costs(&part));
            if let Some(previous) = held.replace(part) {
                emit(self.signed(previous))?;
            }
        }
        let Some(mut last) = held else { return Ok(()) };
        let chosen = self.plan.instances(lowest(&costs, best).into_iter());
        let Simulated { rollouts, controls, .. } = if self.plan.returns.has_recordings() {
            self.roll_out(&chosen, &self.plan.returns.outputs())?
        } else {
            Simulated::default()
        };
        reply::add_recordings(self.plan, &chosen, &rollouts, &controls, &mut last);
        self.add_gradients(&chosen, &mut last)?;
        emit(self.signed(last))
    }

    fn parts(&self) -> impl Iterator<Item = Range<usize>> + use<> {
        cut::runs(0..self.plan.actions(), self.plan.part)
    }

    /// Costs and all else that is reported of every instance of a range.
    fn summary(
        &self,
        indices: &[usize],
        rollouts: &[Rollout],
        extremes: &[Extremes],
    ) -> Result<RollOutResponse, Error> {
        let mut part = reply::summary(self.plan, indices, rollouts, extremes);
        self.plan.plausibility.refuse(&part.implausible)?;
        self.plan.ensemble.fold(&mut part);
        Ok(part)
    }

    /// Refuses what the actions alone show to be implausible, if the request says so.
    fn refuse_implausible(&self) -> Result<(), Error> {
        let plan = self.plan;
        if !plan.plausibility.is_refused {
            return Ok(());
        }
        for action in 0..plan.actions() {
            if self.cancel.is_cancelled() {
                return Err(backend::Error::Cancelled.into());
            }
            let index = action * plan.ensemble.members;
            let instance = plan.instance(index, self.starts);
            let extremes = plan.extremes(index, &instance, self.starts);
            plan.plausibility.refuse(&plan.plausibility.judge(index, &extremes, None))?;
        }
        Ok(())
    }

    fn roll_out(&self, indices: &[usize], outputs: &Outputs) -> Result<Simulated, Error> {
        let mut simulated = Simulated::default();
        let width = self.plan.twin().graph.control_count();
        for run in cut::runs(0..indices.len(), self.plan.prepared) {
            let indices = &indices[run];
            let batch = self.batch(indices);
            simulated.rollouts.extend(self.backend.roll_out(&batch, outputs, self.cancel)?);
            for (index, instance) in indices.iter().zip(&batch) {
                simulated.extremes.push(self.plan.extremes(*index, instance, self.starts));
                if outputs.final_state {
                    let last = &instance.controls[self.plan.frames * width..];
                    simulated.controls.extend_from_slice(last);
                }
            }
        }
        Ok(simulated)
    }

    fn batch(&self, indices: &[usize]) -> Vec<Instance> {
        indices.iter().map(|i| self.plan.instance(*i, self.starts)).collect()
    }

    fn add_gradients(&self, indices: &[usize], part: &mut RollOutResponse) -> Result<(), Error> {
        let (plan, returns) = (self.plan, &self.plan.returns);
        if !returns.has_gradients() {
            return Ok(());
        }
        let mut gradients = Gradients::default();
        // Those of the members of an action, until all of them are there.
        let mut members = Vec::new();
        for run in cut::runs(0..indices.len(), plan.prepared) {
            let indices = &indices[run];
            // Without terms all costs are switched off: nothing depends on the controls.
            let results = if plan.objective.terms.is_empty() {
                vec![Gradient::default(); indices.len()]
            } else {
                let batch = self.batch(indices);
                let request = GradientRequest {
                    cut_every: plan.reach,
                    controls: true,
                    motion: returns.action_gradients && batch.iter().any(is_moved),
                    ..GradientRequest::default()
                };
                self.backend.gradients(&batch, &request, self.cancel)?
            };
            for (index, result) in indices.iter().zip(results) {
                // Per-spring gradients are not returned: let go of them at once.
                members.push(Gradient { params: Params::default(), ..result });
                if members.len() < plan.ensemble.members {
                    continue;
                }
                let result = plan.ensemble.gradient(std::mem::take(&mut members));
                if returns.action_gradients {
                    let action = plan.action(*index);
                    let start = &self.starts.of(action).controls;
                    gradients.actions.extend(plan.actions.gradient(action, start, &result));
                }
                gradients.controls.push(result.controls);
            }
        }
        reply::add_gradients(plan, &gradients, part);
        Ok(())
    }

    fn signed(&self, mut part: RollOutResponse) -> RollOutResponse {
        let compute = self.backend.compute();
        let queue = self.arrived.elapsed().saturating_sub(compute);
        part.timing =
            Some(Timing { queue_s: queue.as_secs_f64(), compute_s: compute.as_secs_f64() });
        part.worker = self.worker.to_owned();
        part
    }
}

/// True if bodies or rolls move with the actions.
fn is_moved(instance: &Instance) -> bool {
    instance.world.bodies > 0 || !instance.motion.rolls.is_empty()
}

/// The `count` actions of lowest cost, lowest first; equal ones in their order.
fn lowest(costs: &[f64], count: usize) -> Vec<usize> {
    let mut order: Vec<usize> = (0..costs.len()).collect();
    order.sort_by(|a, b| costs[*a].total_cmp(&costs[*b]));
    order.truncate(count);
    order
}
