//! Costs of a request: terms of an engine objective, one group per cost, and what the engine does not
//! measure, soft minima over frames and the motion of the controls. Behind the groups of the costs is one
//! for each condition of success, which is measured after the last frame.

mod conditions;
mod controls;
mod measure;
mod soft_min;

use std::sync::{Arc, OnceLock};

use bendtwin_core::Point;
use bendtwin_engine::{
    Objective, Term,
    backend::{Gradient, Rollout},
    objective::WeightedTerm,
};
use bendtwin_proto::v1::{self, cost::When};

use self::{conditions::Condition, controls::Paths, measure::Measure};
use crate::{error::Error, reply::Span, world::Surroundings};

/// The costs of a checked request.
#[derive(Debug)]
pub(crate) struct Costs {
    /// Names, by group.
    pub(crate) names: Vec<String>,
    /// Costs that are not switched off.
    costs: Vec<Cost>,
    conditions: Vec<Condition>,
    frames: usize,
    fps: f64,
    /// The objectives of every instance, unless there are targets by instance.
    shared: Option<Shared>,
}

/// Objectives of all instances.
#[derive(Debug)]
struct Shared {
    /// With conditions.
    scored: Objective,
    /// The one that gradients are of, once it is asked for; without conditions the same one.
    differentiated: OnceLock<Objective>,
}

/// What costs are read in.
pub(crate) struct Context<'a> {
    pub(crate) frames: usize,
    pub(crate) fps: f64,
    /// Newtons of a force of 1 at unit node mass.
    pub(crate) newtons: f64,
    pub(crate) surroundings: &'a Surroundings,
}

#[derive(Debug)]
struct Cost {
    group: usize,
    /// Factor of the engine's value.
    weight: f32,
    when: When,
    temperature: f64,
    measure: Arc<Measure>,
}

impl Costs {
    /// Reads the costs of a checked request. A cost of weight 0 has a group, in which nothing is summed.
    pub(crate) fn read(wire: Vec<v1::Cost>, context: &Context<'_>) -> Result<Self, Error> {
        let mut names = Vec::with_capacity(wire.len());
        let mut costs = Vec::with_capacity(wire.len());
        let mut conditions = Vec::new();
        for (group, cost) in wire.into_iter().enumerate() {
            let (when, temperature) = (cost.when(), cost.temperature);
            let weight = cost.weight.unwrap_or(1.0);
            names.push(if cost.name.is_empty() { format!("cost{group}") } else { cost.name });
            let is_off = weight as f32 == 0.0;
            if is_off && cost.success_at_most.is_none() {
                continue;
            }
            let field = |part: &str| format!("costs[{group}].{part}");
            let (measure, factor) = Measure::read(cost.kind, context, &field)?;
            let measure = Arc::new(measure);
            if let Some(at_most) = cost.success_at_most {
                conditions.push(Condition { group, at_most, measure: Arc::clone(&measure) });
            }
            if !is_off {
                let weight = (weight * factor) as f32;
                costs.push(Cost { group, weight, when, temperature, measure });
            }
        }
        let Context { frames, fps, .. } = *context;
        let mut costs = Self { names, costs, conditions, frames, fps, shared: None };
        if !costs.are_by_instance() {
            let scored = costs.scored_over(0, Span::whole(frames));
            let differentiated = match costs.conditions[..] {
                [] => OnceLock::from(scored.clone()),
                _ => OnceLock::new(),
            };
            costs.shared = Some(Shared { scored, differentiated });
        }
        Ok(costs)
    }

    /// The objective of an action that gradients are of.
    pub(crate) fn objective(&self, action: usize) -> Objective {
        let make = || self.make(action, self.whole(), |_, _| 1.0);
        match &self.shared {
            Some(shared) => shared.differentiated.get_or_init(make).clone(),
            None => make(),
        }
    }

    /// The objective of the rollouts of an action, which measures conditions as well.
    pub(crate) fn scored(&self, action: usize) -> Objective {
        match &self.shared {
            Some(shared) => shared.scored.clone(),
            None => self.scored_over(action, self.whole()),
        }
    }

    /// True if actions have different objectives.
    pub(crate) fn are_by_instance(&self) -> bool {
        let of_costs = self.costs.iter().map(|cost| &cost.measure);
        let of_conditions = self.conditions.iter().map(|condition| &condition.measure);
        of_costs.chain(of_conditions).any(|measure| measure.is_by_instance())
    }

    /// The objective of rollouts of an action over a span, whose frames count from its start.
    pub(crate) fn scored_over(&self, action: usize, span: Span) -> Objective {
        self.with_conditions(action, span, self.make(action, span, |_, _| 1.0))
    }

    /// True if a cost compares positions with those of earlier frames.
    pub(crate) fn look_back(&self) -> bool {
        self.costs.iter().any(|cost| matches!(*cost.measure, Measure::Fixed(Term::Acceleration)))
    }

    /// True if a cost of the nodes counts in every frame, and not after the last alone.
    pub(crate) fn are_in_every_frame(&self) -> bool {
        let of_nodes = |cost: &&Cost| !matches!(*cost.measure, Measure::Controls(_));
        let in_every = |cost: &Cost| matches!(cost.when, When::EveryFrame | When::SoftMin);
        self.costs.iter().filter(of_nodes).any(in_every)
    }

    /// The objective whose gradient is that of the costs, at a rollout of an action; the plain
    /// objective if it diverged, which the engine finds again.
    pub(crate) fn tangent(&self, action: usize, at: &Rollout) -> Objective {
        if at.diverged.is_some() {
            return self.objective(action);
        }
        let shares: Vec<Vec<f64>> = self.costs.iter().map(|cost| self.shares(cost, at)).collect();
        self.make(action, self.whole(), |cost, frame| {
            shares[cost].get(frame - 1).copied().unwrap_or(1.0)
        })
    }

    fn whole(&self) -> Span {
        Span::whole(self.frames)
    }

    /// Terms of a span, with their weights times a factor by cost and frame.
    fn make(&self, action: usize, span: Span, factor: impl Fn(usize, usize) -> f64) -> Objective {
        let mut terms = Vec::new();
        for (number, cost) in self.costs.iter().enumerate() {
            let first = match cost.when {
                When::Unspecified | When::LastFrame => self.frames,
                When::EveryFrame | When::SoftMin => 1,
            };
            for frame in first.max(span.from + 1)..=span.to {
                let Some(term) = cost.measure.term(action, frame) else { break };
                let weight = (f64::from(cost.weight) * factor(number, frame)) as f32;
                let frame = frame - span.from;
                terms.push(WeightedTerm { frame, weight, group: cost.group, term });
            }
        }
        // Stable: within a frame the request's order stays, so sums are reproducible.
        terms.sort_by_key(|t| t.frame);
        Objective { groups: self.names.clone(), terms: Arc::new(terms) }
    }

    /// True if the engine has nothing to differentiate.
    pub(crate) fn need_no_gradient(&self) -> bool {
        self.costs.iter().all(|cost| matches!(*cost.measure, Measure::Controls(_)))
    }

    /// True if the engine has nothing to measure.
    pub(crate) fn need_no_positions(&self) -> bool {
        self.need_no_gradient() && self.conditions.is_empty()
    }

    /// True if costs by frame are needed to make those of whole rollouts.
    pub(crate) fn have_soft_minima(&self) -> bool {
        self.costs.iter().any(Cost::is_soft)
    }

    /// Completes the costs of a rollout, whose control points have shape [F + 1, C]: soft minima,
    /// for which it has its costs by frame, and the motion of the controls. Where it diverged or was not
    /// simulated they are infinite already.
    pub(crate) fn settle(&self, rollout: &mut Rollout, controls: &[Point]) {
        let is_whole = rollout.diverged.is_none() && rollout.cost != f64::INFINITY;
        let width = self.groups();
        // The engine has added conditions to the sum.
        let mut changed = !self.conditions.is_empty();
        for cost in self.costs.iter().filter(|_| is_whole) {
            let value = match *cost.measure {
                Measure::Controls(motion) => {
                    let values = self.paths(controls).values(motion);
                    let weight = f64::from(cost.weight);
                    for (row, value) in rollout.frame_costs.chunks_mut(width).zip(&values) {
                        row[cost.group] = weight * value;
                    }
                    weight * values.iter().sum::<f64>()
                }
                _ if cost.is_soft() => {
                    let by_frame = self.by_frame(cost, rollout);
                    f64::from(cost.weight) * soft_min::value(&by_frame, cost.temperature)
                }
                _ => continue,
            };
            if let Some(group) = rollout.group_costs.get_mut(cost.group) {
                *group = value;
                changed = true;
            }
        }
        if changed {
            rollout.cost = rollout.group_costs.iter().take(self.names.len()).sum();
        }
    }

    /// Adds d cost / d controls of what the engine does not measure.
    pub(crate) fn add_gradient(&self, controls: &[Point], gradient: &mut Gradient) {
        if gradient.loss.diverged.is_some() {
            return;
        }
        let paths = self.paths(controls);
        for cost in &self.costs {
            let Measure::Controls(motion) = *cost.measure else { continue };
            gradient.controls.resize(controls.len(), [0.0; 3]);
            paths.add_gradient(motion, f64::from(cost.weight), &mut gradient.controls);
        }
    }

    fn paths<'a>(&self, controls: &'a [Point]) -> Paths<'a> {
        Paths { controls, frames: self.frames, fps: self.fps }
    }

    /// Values of a cost by frame from the first on, not weighted.
    fn by_frame(&self, cost: &Cost, rollout: &Rollout) -> Vec<f64> {
        let rows = rollout.frame_costs.chunks_exact(self.groups()).skip(1);
        rows.map(|row| row[cost.group] / f64::from(cost.weight)).collect()
    }

    /// Shares of frames in a soft minimum; none of another cost.
    fn shares(&self, cost: &Cost, rollout: &Rollout) -> Vec<f64> {
        if cost.is_soft() {
            soft_min::shares(&self.by_frame(cost, rollout), cost.temperature)
        } else {
            Vec::new()
        }
    }
}

impl Cost {
    fn is_soft(&self) -> bool {
        self.when == When::SoftMin && !matches!(*self.measure, Measure::Controls(_))
    }
}

#[cfg(test)]
mod tests;
