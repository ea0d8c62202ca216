//! Runs a plan and makes the parts of its reply.

use std::{ops::Range, time::Instant};

use bendtwin_core::{CancelToken, Point};
use bendtwin_engine::{
    Backend as _,
    backend::{Gradient, GradientRequest, Instance, Outputs, Rollout},
};
use bendtwin_proto::v1::{RollOutResponse, roll_out_response::Timing};

use super::{
    error::Error,
    initial::Starts,
    plan::Plan,
    reply::{self, Gradients},
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

impl Execution<'_> {
    /// Simulates everything and hands out the parts in order. `emit` says whether anyone listens
    /// still.
    pub(super) fn run(
        &self,
        mut emit: impl FnMut(RollOutResponse) -> Result<(), Error>,
    ) -> Result<(), Error> {
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
            let indices: Vec<usize> = range.clone().collect();
            let (rollouts, controls) = self.roll_out(&indices, &outputs)?;
            let mut part = reply::summary(self.plan, range, &rollouts);
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
        let outputs = self.plan.returns.summary();
        let mut costs = Vec::with_capacity(self.plan.instances());
        let mut held: Option<RollOutResponse> = None;
        for range in self.parts() {
            let indices: Vec<usize> = range.clone().collect();
            let (rollouts, _) = self.roll_out(&indices, &outputs)?;
            costs.extend(rollouts.iter().map(reply::cost));
            let part = reply::summary(self.plan, range, &rollouts);
            if let Some(previous) = held.replace(part) {
                emit(self.signed(previous))?;
            }
        }
        let Some(mut last) = held else { return Ok(()) };
        let chosen = lowest(&costs, best);
        let (rollouts, controls) = if self.plan.returns.has_recordings() {
            self.roll_out(&chosen, &self.plan.returns.outputs())?
        } else {
            (Vec::new(), Vec::new())
        };
        reply::add_recordings(self.plan, &chosen, &rollouts, &controls, &mut last);
        self.add_gradients(&chosen, &mut last)?;
        emit(self.signed(last))
    }

    fn parts(&self) -> impl Iterator<Item = Range<usize>> + use<> {
        cut::runs(0..self.plan.instances(), self.plan.part)
    }

    /// Rollouts of instances and, with their final states, the control points there [m], shape
    /// [instances, C, 3].
    fn roll_out(
        &self,
        indices: &[usize],
        outputs: &Outputs,
    ) -> Result<(Vec<Rollout>, Vec<Point>), Error> {
        let mut rollouts = Vec::with_capacity(indices.len());
        let mut controls = Vec::new();
        let width = self.plan.twin().graph.control_count();
        for run in cut::runs(0..indices.len(), self.plan.prepared) {
            let batch = self.batch(&indices[run]);
            rollouts.extend(self.backend.roll_out(&batch, outputs, self.cancel)?);
            for instance in batch.iter().filter(|_| outputs.final_state) {
                controls.extend_from_slice(&instance.controls[self.plan.frames * width..]);
            }
        }
        Ok((rollouts, controls))
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
        for run in cut::runs(0..indices.len(), plan.prepared) {
            let indices = &indices[run];
            // Without terms all costs are switched off: nothing depends on the controls.
            let results = if plan.objective.terms.is_empty() {
                vec![Gradient::default(); indices.len()]
            } else {
                let batch = self.batch(indices);
                let motion = returns.action_gradients && batch.iter().any(|i| i.world.bodies > 0);
                let request =
                    GradientRequest { controls: true, motion, ..GradientRequest::default() };
                self.backend.gradients(&batch, &request, self.cancel)?
            };
            for (index, result) in indices.iter().zip(results) {
                if returns.action_gradients {
                    let start = &self.starts.of(*index).controls;
                    gradients.actions.extend(plan.actions.gradient(*index, start, &result));
                }
                // Per-spring gradients are not returned: let go of them at once.
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

/// The `count` instances of lowest cost, lowest first; equal ones in their order.
fn lowest(costs: &[f64], count: usize) -> Vec<usize> {
    let mut order: Vec<usize> = (0..costs.len()).collect();
    order.sort_by(|a, b| costs[*a].total_cmp(&costs[*b]));
    order.truncate(count);
    order
}
