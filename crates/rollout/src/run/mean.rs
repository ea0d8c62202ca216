//! The mean motion of the members of an ensemble, which costs and arrays are of with the statistic
//! `MEAN_PREDICTION`: each node is at the weighted mean of where the members have it. Devices simulate
//! the members; their mean is made and its costs are measured here.

mod gradients;
mod seeds;

use std::{collections::HashMap, sync::Arc};

use bendtwin_core::twin::Mean;
use bendtwin_engine::{
    Gauge, Model,
    backend::{Instance, Outputs, Rollout},
    model::State,
};

use crate::run::plan::Plan;

/// Makes the mean motions of actions from the motions of their members, which are added one after
/// another.
pub(crate) struct MeanMotions<'a> {
    plan: &'a Plan,
    weights: &'a [f64],
    gauges: Gauges,
    members: Members,
}

/// Gauges of costs along means, by the model whose skin and rest lengths count.
#[derive(Default)]
struct Gauges(HashMap<*const Model, Gauge>);

/// The members of an action that were added.
#[derive(Default)]
struct Members {
    /// The first, whose surroundings and objective are those of the mean.
    first: Option<Instance>,
    count: usize,
    /// Number of those that came through all frames.
    whole: usize,
    is_unfinished: bool,
    /// Frames that are recorded.
    frames: Vec<usize>,
    positions: Mean,
    velocities: Mean,
    end: Option<End>,
}

/// Sum of the final states.
#[derive(Default)]
struct End {
    positions: Mean,
    velocities: Mean,
    twists: Vec<f64>,
    weight: f64,
    /// The first, whose holds are those of the mean.
    first: State,
}

impl<'a> MeanMotions<'a> {
    /// Means of a plan, if it asks for them.
    pub(crate) fn new(plan: &'a Plan) -> Option<Self> {
        let weights = plan.ensemble.weights.as_deref()?;
        let (gauges, members) = Default::default();
        Some(Self { plan, weights, gauges, members })
    }

    /// Outputs of the engine for members: all nodes in all frames, if costs are measured there.
    pub(crate) fn outputs(&self, asked: Outputs) -> Outputs {
        if self.plan.costs.need_no_positions() {
            return asked;
        }
        Outputs { every: 1, initial: true, nodes: None, ..asked }
    }

    /// Removes from the rollout of a member what its mean is made of, and leaves what its spread needs.
    pub(crate) fn strip(&self, rollout: &mut Rollout) {
        if !self.plan.returns.spread {
            (rollout.positions, rollout.velocities) = Default::default();
        } else if !self.plan.costs.need_no_positions() {
            self.plan.returns.thin_out(rollout);
        }
    }

    /// Adds the next member, none if it was not simulated in time. Returns the mean motion with the last
    /// one of an action.
    pub(crate) fn add(
        &mut self,
        instance: &Instance,
        rollout: Option<&Rollout>,
    ) -> Option<Rollout> {
        let weight = self.weights.get(self.members.count).copied().unwrap_or_default();
        self.members.add(instance, rollout, weight);
        if self.members.count < self.plan.ensemble.members {
            return None;
        }
        let members = std::mem::take(&mut self.members);
        let first = members.first.clone()?;
        Some(match members.mean() {
            Some(mean) => self.measured(&first, mean),
            None => self.lost(),
        })
    }

    /// The rollout that stands for a mean of no members.
    fn lost(&self) -> Rollout {
        let (groups, frames) = (self.plan.costs.groups(), self.plan.frames);
        Rollout {
            cost: f64::INFINITY,
            group_costs: vec![f64::INFINITY; groups],
            frame_costs: vec![f64::INFINITY; groups * (frames + 1)],
            ..Rollout::default()
        }
    }

    /// The mean with its costs, and without unrequested arrays.
    fn measured(&mut self, first: &Instance, mut mean: Rollout) -> Rollout {
        let (costs, returns) = (&self.plan.costs, &self.plan.returns);
        let groups = costs.groups();
        mean.group_costs = vec![0.0; groups];
        if costs.need_no_positions() {
            mean.frame_costs = vec![0.0; groups * (self.plan.frames + 1)];
        } else {
            mean.frame_costs = self.gauges.of(first).frame_costs(first, &mean.positions);
            returns.thin_out(&mut mean);
        }
        for row in mean.frame_costs.chunks_exact(groups.max(1)) {
            mean.group_costs.iter_mut().zip(row).for_each(|(sum, value)| *sum += value);
        }
        mean.cost = mean.group_costs.iter().sum();
        costs.settle(&mut mean, &first.controls);
        mean
    }
}

impl Gauges {
    /// Gauge of an instance's model.
    fn of(&mut self, instance: &Instance) -> &Gauge {
        let model = instance.model.model();
        self.0.entry(Arc::as_ptr(model)).or_insert_with(|| Gauge::new(model))
    }
}

impl Members {
    fn add(&mut self, instance: &Instance, rollout: Option<&Rollout>, weight: f64) {
        self.first.get_or_insert_with(|| instance.clone());
        self.count += 1;
        self.is_unfinished |= rollout.is_none();
        // One that diverged has no part, at no frame: its node would jump there.
        let Some(rollout) = rollout.filter(|rollout| rollout.diverged.is_none()) else { return };
        self.whole += 1;
        self.frames.clone_from(&rollout.frames);
        self.positions.add(weight, &rollout.positions);
        self.velocities.add(weight, &rollout.velocities);
        if let Some(state) = &rollout.final_state {
            self.end
                .get_or_insert_with(|| End { first: state.clone(), ..End::default() })
                .add(weight, state);
        }
    }

    /// The mean of the instances that came through, without costs; `None` without any, or if it is
    /// unknown which they are.
    fn mean(self) -> Option<Rollout> {
        (self.whole > 0 && !self.is_unfinished).then(|| Rollout {
            frames: self.frames,
            positions: self.positions.points(),
            velocities: self.velocities.points(),
            final_state: self.end.map(End::mean),
            ..Rollout::default()
        })
    }
}

impl End {
    fn add(&mut self, weight: f64, state: &State) {
        self.positions.add(weight, &state.positions);
        self.velocities.add(weight, &state.velocities);
        self.twists.resize(state.twists.len(), 0.0);
        for (sum, twist) in self.twists.iter_mut().zip(&state.twists) {
            *sum += weight * f64::from(*twist);
        }
        self.weight += weight;
    }

    fn mean(self) -> State {
        State {
            positions: self.positions.points(),
            velocities: self.velocities.points(),
            twists: self.twists.iter().map(|sum| (sum / self.weight) as f32).collect(),
            ..self.first
        }
    }
}
