//! Runs a plan and makes the parts of its reply.

use std::{ops::Range, time::Instant};

use bendtwin_core::CancelToken;
use bendtwin_engine::{
    Backend as _,
    backend::{GradientRequest, Instance, Outputs, Rollout},
};
use bendtwin_proto::v1::{RollOutResponse, roll_out_response::Timing};

use super::{error::Error, initial::Starts, plan::Plan, reply};
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
            let rollouts = self.roll_out(&indices, &outputs)?;
            let mut part = reply::summary(self.plan, range, &rollouts);
            reply::add_recordings(self.plan, &indices, &rollouts, &mut part);
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
            let rollouts = self.roll_out(&indices, &outputs)?;
            costs.extend(rollouts.iter().map(reply::cost));
            let part = reply::summary(self.plan, range, &rollouts);
            if let Some(previous) = held.replace(part) {
                emit(self.signed(previous))?;
            }
        }
        let Some(mut last) = held else { return Ok(()) };
        let chosen = lowest(&costs, best);
        let rollouts = if self.plan.returns.has_recordings() {
            self.roll_out(&chosen, &self.plan.returns.outputs())?
        } else {
            Vec::new()
        };
        reply::add_recordings(self.plan, &chosen, &rollouts, &mut last);
        self.add_gradients(&chosen, &mut last)?;
        emit(self.signed(last))
    }

    fn parts(&self) -> impl Iterator<Item = Range<usize>> + use<> {
        cut::runs(0..self.plan.instances(), self.plan.part)
    }

    fn roll_out(&self, indices: &[usize], outputs: &Outputs) -> Result<Vec<Rollout>, Error> {
        let mut rollouts = Vec::with_capacity(indices.len());
        for run in cut::runs(0..indices.len(), self.plan.prepared) {
            let batch = self.batch(&indices[run]);
            rollouts.extend(self.backend.roll_out(&batch, outputs, self.cancel)?);
        }
        Ok(rollouts)
    }

    fn batch(&self, indices: &[usize]) -> Vec<Instance> {
        indices.iter().map(|i| self.plan.instance(*i, self.starts)).collect()
    }

    fn add_gradients(&self, indices: &[usize], part: &mut RollOutResponse) -> Result<(), Error> {
        if !self.plan.returns.control_gradients {
            return Ok(());
        }
        if self.plan.objective.terms.is_empty() {
            // All costs are switched off: nothing depends on the controls.
            reply::add_gradients(self.plan, &vec![Vec::new(); indices.len()], part);
            return Ok(());
        }
        let request = GradientRequest { controls: true, ..GradientRequest::default() };
        let mut gradients = Vec::with_capacity(indices.len());
        for run in cut::runs(0..indices.len(), self.plan.prepared) {
            let batch = self.batch(&indices[run]);
            let results = self.backend.gradients(&batch, &request, self.cancel)?;
            // Per-spring gradients are not returned: let go of them at once.
            gradients.extend(results.into_iter().map(|g| g.controls));
        }
        reply::add_gradients(self.plan, &gradients, part);
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
