//! An instance on its way through the spans of a rollout.

use std::{ops::Range, sync::Arc};

use bendtwin_core::Point;
use bendtwin_engine::{
    Motion, Objective, Term,
    backend::{Diagnostics, Divergence, Instance, Rollout},
    model::State,
    objective::acceleration,
};

use crate::{
    reply::Span,
    request::{actions::Stopped, costs::Costs, initial::Starts, plausible::Extremes},
    run::plan::Plan,
};

/// An instance and where it is.
pub(super) struct Track {
    pub(super) index: usize,
    /// Over the whole horizon.
    whole: Instance,
    now: Arc<State>,
    /// Positions one frame earlier, shape [N], if a cost looks back.
    before: Option<Vec<Point>>,
    pub(super) extremes: Extremes,
    stopped: Stopped,
    /// Reported values of whole rollouts, up to the current frame.
    pub(super) so_far: Rollout,
}

impl Track {
    pub(super) fn new(plan: &Plan, starts: &Starts, index: usize) -> Self {
        let (whole, stops) = plan.stopped_instance(index, starts);
        let stopped = stops.most();
        let extremes = plan.extremes(index, (&whole, stopped), starts, None);
        let groups = plan.costs.groups();
        let mut so_far = Rollout {
            frame_costs: vec![0.0; (plan.frames + 1) * groups],
            group_costs: vec![0.0; groups],
            diagnostics: Some(Diagnostics::default()),
            ..Rollout::default()
        };
        // Those of the controls, which are known; sums come at the end.
        plan.costs.settle(&mut so_far, &whole.controls);
        so_far.group_costs.fill(0.0);
        let now = Arc::clone(&whole.initial);
        Self { index, now, before: None, extremes, stopped, so_far, whole }
    }

    /// Extremes of what is prescribed, once it is known where the instance ends.
    pub(super) fn extremes_at_end(&self, plan: &Plan, starts: &Starts) -> Extremes {
        let end = self.runs().then_some(&*self.now);
        let mut extremes = plan.extremes(self.index, (&self.whole, self.stopped), starts, end);
        extremes.grasp_forces.clone_from(&self.extremes.grasp_forces);
        extremes
    }

    /// False once it has diverged.
    pub(super) fn runs(&self) -> bool {
        self.so_far.diverged.is_none()
    }

    /// Control points at frame boundaries.
    pub(super) fn controls(&self, boundaries: Range<usize>) -> &[Point] {
        let width = self.whole.controls.len() / (self.whole.frames + 1);
        &self.whole.controls[boundaries.start * width..boundaries.end * width]
    }

    /// Control points at the end of the horizon.
    pub(super) fn end(&self) -> &[Point] {
        self.controls(self.whole.frames..self.whole.frames + 1)
    }

    /// The instance over a span, from where it is.
    pub(super) fn instance(&self, span: Span, objective: Objective) -> Instance {
        let frames = span.frames();
        let (motion, bodies) = (&self.whole.motion, self.whole.world.bodies);
        let rods = self.whole.model.model().graph.rods.len();
        let grasps = self.whole.world.grasps.len();
        let (from, to) = (span.from, span.to);
        Instance {
            model: self.whole.model.clone(),
            initial: Arc::clone(&self.now),
            controls: Arc::new(self.controls(from..to + 1).to_vec()),
            frames,
            objective,
            world: Arc::clone(&self.whole.world),
            motion: Arc::new(Motion {
                poses: rows(&motion.poses, bodies, from..to + 1),
                closed: rows(&motion.closed, grasps, from..to),
                rolls: rows(&motion.rolls, 2 * rods, from..to + 1),
            }),
        }
    }

    /// The result of a span that it does not come through.
    pub(super) fn stopped(&self, span: Span) -> Rollout {
        let count = span.rows().len() * self.so_far.group_costs.len();
        Rollout { frame_costs: vec![f64::INFINITY; count], ..Rollout::default() }
    }

    /// Takes over the result of a span; what is left of it are the recordings that are asked for.
    pub(super) fn advance(
        &mut self,
        plan: &Plan,
        span: Span,
        instance: &Instance,
        mut result: Rollout,
    ) -> Rollout {
        if plan.costs.look_back() {
            self.look_back(instance, &mut result);
            plan.returns.thin_out(&mut result);
        }
        plan.returns.recorded.place(&plan.twin().skin, &mut result);
        plan.see_forces(self.index, &result, span.from, &mut self.extremes);
        if !plan.returns.forces {
            result.forces = None;
        }
        self.add_costs(span, &mut result);
        self.measure(span, &result);
        if let Some(state) = &result.final_state {
            self.now = Arc::new(state.clone());
        }
        result
    }

    /// Adds the terms of the span's first frame that compare it with the last but one before, and
    /// keeps the positions that the next span needs.
    fn look_back(&mut self, instance: &Instance, result: &mut Rollout) {
        let nodes = self.now.positions.len();
        let groups = instance.objective.groups.len();
        if let (Some(before), Some(now)) = (&self.before, result.positions.get(..nodes)) {
            let value = acceleration(now, &self.now.positions, before);
            let terms = instance.objective.terms.iter();
            for term in terms.filter(|t| t.frame == 1 && t.term == Term::Acceleration) {
                result.frame_costs[groups + term.group] += f64::from(term.weight) * value;
            }
        }
        let recorded = result.positions.len() / nodes.max(1);
        self.before = Some(match recorded {
            0 | 1 => self.now.positions.clone(),
            rows => result.positions[(rows - 2) * nodes..(rows - 1) * nodes].to_vec(),
        });
    }

    /// Adds the costs of a span to those so far, and leaves the rows that its part is to have.
    fn add_costs(&mut self, span: Span, result: &mut Rollout) {
        let groups = self.so_far.group_costs.len();
        // The first row is the end of the span before.
        let skipped = span.rows().start - span.from;
        let rows = span.rows().start * groups..span.rows().end * groups;
        let own = &mut self.so_far.frame_costs[rows];
        for (sum, value) in own.iter_mut().zip(&result.frame_costs[skipped * groups..]) {
            *sum += value;
        }
        result.frame_costs = own.to_vec();
    }

    fn measure(&mut self, span: Span, result: &Rollout) {
        let (sums, now) = (&mut self.so_far.diagnostics, result.diagnostics.unwrap_or_default());
        let sums = sums.get_or_insert_default();
        let diverged_at = result.diverged.map(|d| d.frame);
        *sums = Diagnostics {
            max_strain: sums.max_strain.max(now.max_strain),
            max_control_strain: sums.max_control_strain.max(now.max_control_strain),
            max_speed_m_s: sums.max_speed_m_s.max(now.max_speed_m_s),
            kinetic_energy: now.kinetic_energy,
            elastic_energy: now.elastic_energy,
            // Of the last frame that it came through.
            ground_contacts: if diverged_at == Some(1) {
                sums.ground_contacts
            } else {
                now.ground_contacts
            },
        };
        let later = |d: Divergence| Divergence { frame: span.from + d.frame, ..d };
        self.so_far.diverged = result.diverged.map(later);
    }

    /// The rollout as if it had not been divided, without its arrays.
    pub(super) fn whole(&self, costs: &Costs) -> Rollout {
        let mut whole = self.so_far.clone();
        let groups = whole.group_costs.len();
        for row in whole.frame_costs.chunks_exact(groups.max(1)) {
            whole.group_costs.iter_mut().zip(row).for_each(|(sum, value)| *sum += value);
        }
        if whole.diverged.is_some() {
            whole.group_costs.fill(f64::INFINITY);
        }
        whole.cost = whole.group_costs.iter().sum();
        costs.settle(&mut whole, &self.whole.controls);
        whole
    }
}

/// Some rows of an array, which may be empty.
fn rows<T: Clone>(values: &[T], width: usize, rows: Range<usize>) -> Vec<T> {
    values.get(rows.start * width..rows.end * width).map(<[T]>::to_vec).unwrap_or_default()
}
