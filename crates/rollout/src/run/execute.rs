//! Runs a plan and makes the parts of its reply.

use std::{collections::HashSet, ops::Range, sync::Arc, time::Instant};

use bendtwin_core::{CancelToken, Params, Point};
use bendtwin_engine::backend::{
    self, Diagnostics, Gradient, GradientRequest, Instance, Outputs, Rollout,
};
use bendtwin_proto::v1::{RollOutResponse, Tensor, roll_out_response::Timing};

use crate::{
    backend::RolloutBackend,
    cut,
    error::Error,
    reply::{self, Gradients, Span},
    request::{
        actions::Stopped,
        initial::{Start, Starts},
        plausible::Extremes,
    },
    run::{mean::MeanMotions, plan::Plan},
};

/// A plan being carried out.
pub struct Execution<'a> {
    /// The plan.
    pub plan: &'a Plan,
    /// States that its actions begin in.
    pub starts: &'a Starts,
    /// Backend that simulates it.
    pub backend: &'a dyn RolloutBackend,
    /// Token that ends it.
    pub cancel: &'a CancelToken,
    /// End of the time limit of the request, if it has one.
    pub until: Option<Instant>,
    /// When the request arrived.
    pub arrived: Instant,
    /// Name of this worker.
    pub worker: &'a str,
    /// True if the final states are wanted here.
    pub keeps_states: bool,
}

/// Instances that were simulated.
#[derive(Default)]
pub(crate) struct BatchResult {
    rollouts: Vec<Rollout>,
    /// Extremes of their prescribed motion.
    extremes: Vec<Extremes>,
    /// Mean motions of the members of each action, if these are asked for.
    means: Vec<Rollout>,
    /// With their final states, the control points there [m], shape [instances, C, 3].
    controls: Vec<Point>,
    /// Control points at all frame boundaries [m] if asked for, shape [instances, F + 1, C, 3].
    paths: Vec<Point>,
    /// Instances that were not simulated within the time limit.
    unfinished: Vec<u32>,
}

impl BatchResult {
    /// Instances whose other results are not kept.
    pub(crate) fn of(rollouts: Vec<Rollout>, extremes: Vec<Extremes>) -> Self {
        Self { rollouts, extremes, ..Self::default() }
    }
}

/// Results of a simulation that are kept.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kept {
    Costs,
    Arrays,
}

impl Execution<'_> {
    /// Simulates everything and hands out the parts in order. `emit` says whether anyone listens
    /// still. Returns the final states of the instances if they are to be kept, none for one that
    /// diverged.
    ///
    /// # Errors
    /// If the motion is to be refused, the backend fails, or `emit` says that nobody listens.
    pub fn run(
        &self,
        mut emit: impl FnMut(RollOutResponse) -> Result<(), Error>,
    ) -> Result<Vec<Option<Start>>, Error> {
        self.refuse_implausible()?;
        let returns = &self.plan.returns;
        match (returns.best, returns.part_frames) {
            (Some(best), _) => self.best_last(best, &mut emit).map(|()| Vec::new()),
            (None, Some(frames)) => self.each_span(frames, &mut emit).map(|()| Vec::new()),
            (None, None) => self.each_part(&mut emit),
        }
    }

    /// Splits arrays so that every part has those of its instances.
    fn each_part(
        &self,
        emit: &mut impl FnMut(RollOutResponse) -> Result<(), Error>,
    ) -> Result<Vec<Option<Start>>, Error> {
        let mut kept = Vec::new();
        for range in self.parts() {
            let indices = self.plan.instances(range);
            let simulated = self.roll_out(&indices, Kept::Arrays)?;
            let mut part = self.summary(&indices, &simulated)?;
            self.add_unfinished(&simulated.unfinished, &mut part);
            if self.keeps_states {
                kept.extend(self.ends(&indices, &simulated));
            }
            self.add_arrays(&indices, simulated, &mut part)?;
            emit(self.signed(part))?;
        }
        Ok(kept)
    }

    /// States in which instances end, with their control points, rest shapes and surroundings.
    fn ends(&self, indices: &[usize], simulated: &BatchResult) -> Vec<Option<Start>> {
        let width = self.plan.twin().graph.control_count();
        let (rollouts, members) = match &self.plan.ensemble.weights {
            None => (&simulated.rollouts, 1),
            Some(_) => (&simulated.means, self.plan.ensemble.members),
        };
        let each = (0..).step_by(members).zip(rollouts).map(|(i, rollout): (usize, _)| {
            let state = Arc::new(self.plan.carried(rollout.final_state.as_ref()?));
            let controls = Arc::new(simulated.controls.get(i * width..(i + 1) * width)?.to_vec());
            let index = *indices.get(i)?;
            let begun = self.starts.of(self.plan.action(index));
            let around = Some(Arc::new(self.plan.ended(index, self.starts)));
            let commanded = self.plan.commanded(index, self.starts);
            let commanded = commanded.filter(|other| *other != *controls).map(Arc::new);
            let rest = begun.rest.clone();
            Some(Start { commanded, rest, around, ..Start::new(state, controls) })
        });
        each.collect()
    }

    /// All costs first; then the best instances once more, recorded. Runs are bit-identical, so
    /// this costs k simulations and saves the memory of all others' arrays. The last part has them.
    fn best_last(
        &self,
        best: usize,
        emit: &mut impl FnMut(RollOutResponse) -> Result<(), Error>,
    ) -> Result<(), Error> {
        let mut costs = Vec::with_capacity(self.plan.actions());
        let mut held: Option<RollOutResponse> = None;
        let mut late = HashSet::new();
        for range in self.parts() {
            let indices = self.plan.instances(range);
            let simulated = self.roll_out(&indices, Kept::Costs)?;
            let mut part = self.summary(&indices, &simulated)?;
            self.add_unfinished(&simulated.unfinished, &mut part);
            late.extend(simulated.unfinished.iter().map(|i| self.plan.action(*i as usize)));
            costs.extend(reply::costs(&part));
            if let Some(previous) = held.replace(part) {
                emit(self.signed(previous))?;
            }
        }
        let Some(mut last) = held else { return Ok(()) };
        let chosen = lowest(&costs, best).into_iter().filter(|action| !late.contains(action));
        let chosen = self.plan.instances(chosen);
        let returns = &self.plan.returns;
        // Gradients of soft minima begin with costs by frame.
        let weighs_frames = returns.has_gradients() && self.plan.costs.have_soft_minima();
        let simulated = if returns.has_recordings() || weighs_frames {
            Execution { until: None, ..*self }.roll_out(&chosen, Kept::Arrays)?
        } else {
            BatchResult::default()
        };
        self.add_arrays(&chosen, simulated, &mut last)?;
        emit(self.signed(last))
    }

    /// Recordings and gradients of instances.
    fn add_arrays(
        &self,
        indices: &[usize],
        simulated: BatchResult,
        part: &mut RollOutResponse,
    ) -> Result<(), Error> {
        let BatchResult { rollouts, means, controls, paths, .. } = simulated;
        let arrays = reply::Arrays {
            indices,
            rollouts: &rollouts,
            means: &means,
            starts: self.starts,
            ends: &controls,
            paths: &paths,
        };
        reply::add_arrays(self.plan, Span::whole(self.plan.frames), &arrays, part);
        if !self.plan.returns.has_gradients() {
            return Ok(());
        }
        let gradients = match &self.plan.ensemble.weights {
            None => self.gradients(indices, &rollouts)?,
            Some(weights) => self.mean_gradients(indices, &means, weights)?,
        };
        reply::add_gradients(self.plan, &gradients, part);
        Ok(())
    }

    pub(crate) fn parts(&self) -> impl Iterator<Item = Range<usize>> + use<> {
        cut::runs(0..self.plan.actions(), self.plan.part)
    }

    /// Costs and all else that is reported of every instance of a range.
    pub(crate) fn summary(
        &self,
        indices: &[usize],
        simulated: &BatchResult,
    ) -> Result<RollOutResponse, Error> {
        let BatchResult { rollouts, extremes, means, .. } = simulated;
        let mut part = reply::summary(self.plan, indices, rollouts, extremes);
        self.plan.plausibility.refuse(&part.implausible)?;
        self.plan.ensemble.fold(&mut part);
        if self.plan.ensemble.weights.is_some() {
            reply::set_costs(self.plan, means, &mut part);
        }
        Ok(part)
    }

    /// Says which instances are missing, if there is a time limit.
    fn add_unfinished(&self, unfinished: &[u32], part: &mut RollOutResponse) {
        if self.until.is_some() {
            part.unfinished = Some(Tensor::pack(&[unfinished.len()], unfinished));
        }
    }

    /// Refuses what the actions alone show to be implausible, if the request says so.
    fn refuse_implausible(&self) -> Result<(), Error> {
        let plan = self.plan;
        if !plan.plausibility.is_refused() {
            return Ok(());
        }
        for action in 0..plan.actions() {
            if self.cancel.is_cancelled() {
                return Err(backend::Error::Cancelled.into());
            }
            let index = action * plan.ensemble.members;
            let (instance, stops) = plan.stopped_instance(index, self.starts);
            let of = (&instance, stops.most());
            let extremes = plan.extremes(index, of, self.starts, None);
            plan.plausibility.refuse(&plan.plausibility.judge(index, &extremes, None))?;
        }
        Ok(())
    }

    fn roll_out(&self, indices: &[usize], kept: Kept) -> Result<BatchResult, Error> {
        let (returns, costs) = (&self.plan.returns, &self.plan.costs);
        let arrays = kept == Kept::Arrays;
        let asked = if arrays { returns.outputs() } else { returns.summary() };
        let frame_costs = asked.frame_costs || costs.have_soft_minima();
        let keeps_states = asked.final_state || arrays && self.keeps_states;
        // Which nodes grasps have taken on the way is known from what they hold at the end.
        let final_state = keeps_states || self.plan.surroundings.has_pins();
        let forces = asked.forces || self.plan.limits_grasp_force();
        let keeps_forces = asked.forces;
        let outputs = Outputs { frame_costs, final_state, forces, ..asked };
        let mut means = MeanMotions::new(self.plan);
        let outputs = means.as_ref().map_or(outputs.clone(), |means| means.outputs(outputs));
        let keeps_frames = arrays && (returns.frame_costs || returns.has_gradients());
        let mut simulated = BatchResult::default();
        let width = self.plan.twin().graph.control_count();
        let cancel = self.until.map_or_else(|| self.cancel.clone(), |t| self.cancel.until(t));
        for run in cut::runs(0..indices.len(), self.plan.prepared) {
            let indices = &indices[run];
            let stopped_instance = |i: &usize| {
                let (instance, stops) = self.plan.stopped_instance(*i, self.starts);
                (instance, stops.most())
            };
            let (batch, stopped): (Vec<Instance>, Vec<Stopped>) =
                indices.iter().map(stopped_instance).unzip();
            let rollouts = self.backend.roll_out_in_time(&batch, &outputs, &cancel)?;
            let prescribed = batch.iter().zip(stopped);
            for ((index, of), rollout) in indices.iter().zip(prescribed).zip(rollouts) {
                let instance = of.0;
                let mean = means.as_mut().and_then(|m| m.add(instance, rollout.as_ref()));
                let mut rollout = rollout.unwrap_or_else(|| {
                    simulated.unfinished.push(*index as u32);
                    self.unfinished()
                });
                costs.settle(&mut rollout, &instance.controls);
                let end = rollout.final_state.as_ref();
                let mut extremes = self.plan.extremes(*index, of, self.starts, end);
                self.plan.see_forces(*index, &rollout, 0, &mut extremes);
                simulated.extremes.push(extremes);
                let kept = |mut rollout: Rollout| {
                    if !keeps_states {
                        rollout.final_state = None;
                    }
                    if !keeps_forces {
                        rollout.forces = None;
                    }
                    if arrays {
                        returns.recorded.place(&self.plan.twin().skin, &mut rollout);
                    } else {
                        (rollout.positions, rollout.velocities) = Default::default();
                    }
                    if !keeps_frames {
                        rollout.frame_costs = Vec::new();
                    }
                    rollout
                };
                if let Some(means) = &means {
                    means.strip(&mut rollout);
                }
                simulated.means.extend(mean.map(kept));
                simulated.rollouts.push(kept(rollout));
                if arrays && returns.controls {
                    simulated.paths.extend_from_slice(&instance.controls);
                }
                if keeps_states {
                    let last = &instance.controls[self.plan.frames * width..];
                    simulated.controls.extend_from_slice(last);
                }
            }
        }
        Ok(simulated)
    }

    /// Placeholder for a rollout that was not simulated.
    fn unfinished(&self) -> Rollout {
        let groups = self.plan.costs.groups();
        let unknown = Diagnostics {
            max_strain: f32::NAN,
            max_control_strain: f32::NAN,
            max_speed_m_s: f32::NAN,
            kinetic_energy: f32::NAN,
            elastic_energy: f32::NAN,
            ground_contacts: 0,
        };
        Rollout {
            cost: f64::INFINITY,
            group_costs: vec![f64::INFINITY; groups],
            frame_costs: vec![f64::INFINITY; groups * (self.plan.frames + 1)],
            diagnostics: Some(unknown),
            ..Rollout::default()
        }
    }

    pub(crate) fn batch(&self, indices: &[usize]) -> Vec<Instance> {
        indices.iter().map(|i| self.plan.instance(*i, self.starts)).collect()
    }

    /// Gradients of instances, of which rollouts are needed where costs have soft minima.
    fn gradients(&self, indices: &[usize], rollouts: &[Rollout]) -> Result<Gradients, Error> {
        let plan = self.plan;
        let soft = plan.costs.have_soft_minima();
        let mut gradients = Gradients::default();
        // Gradients of the members of an action, until all of them are known.
        let mut members = Vec::new();
        for run in cut::runs(0..indices.len(), plan.prepared) {
            let indices = &indices[run.clone()];
            let batch: Vec<Instance> = if soft {
                let pairs = indices.iter().zip(&rollouts[run.clone()]);
                pairs.map(|(i, rollout)| plan.tangent(*i, self.starts, rollout)).collect()
            } else {
                self.batch(indices)
            };
            // Without terms all costs are switched off or of the controls alone: nothing else
            // depends on anything.
            let results = if plan.costs.need_no_gradient() {
                vec![Gradient::default(); indices.len()]
            } else {
                self.backend.gradients(&batch, &self.gradient_request(&batch), self.cancel)?
            };
            let pairs = run.zip(indices).zip(&batch).zip(results);
            for (((row, index), instance), mut result) in pairs {
                plan.costs.add_gradient(&instance.controls, &mut result);
                if let Some(rollout) = rollouts.get(row) {
                    // What the engine has is that of its terms alone.
                    result.loss.total = reply::cost(rollout);
                }
                // Per-spring gradients are not returned: drop them immediately.
                members.push(Gradient { params: Params::default(), ..result });
                if members.len() < plan.ensemble.members {
                    continue;
                }
                let result = plan.ensemble.gradient(std::mem::take(&mut members));
                self.push_gradient(*index, result, &mut gradients);
            }
        }
        Ok(gradients)
    }

    /// The gradients of a batch that the engine is asked for.
    pub(crate) fn gradient_request(&self, batch: &[Instance]) -> GradientRequest {
        let returns = &self.plan.returns;
        GradientRequest {
            cut_every: self.plan.reach,
            controls: true,
            initial: returns.initial_gradients,
            norms: true,
            motion: returns.action_gradients && batch.iter().any(is_moved),
            ..GradientRequest::default()
        }
    }

    /// Adds the gradient of the cost of an action, one of whose instances is named, with that by what the
    /// request gave as actions.
    pub(crate) fn push_gradient(
        &self,
        index: usize,
        mut result: Gradient,
        gradients: &mut Gradients,
    ) {
        let plan = self.plan;
        if plan.returns.action_gradients {
            let action = plan.action(index);
            let start = self.starts.of(action).commanded();
            let stops = plan.stopped_instance(index, self.starts).1;
            let simulated = (result.controls.clone(), result.poses.clone());
            stops.back(&plan.actions, &mut result);
            gradients.actions.extend(plan.actions.gradient(action, start, &result));
            (result.controls, result.poses) = simulated;
        }
        gradients.push(result);
    }

    pub(crate) fn signed(&self, mut part: RollOutResponse) -> RollOutResponse {
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
