//! Results of the engine as tensors of a reply.

mod forces;
mod gradients;
mod span;
mod spread;

use bendtwin_core::Point;
use bendtwin_engine::{backend::Rollout, model::State};
use bendtwin_proto::v1::{
    Fidelity, RollOutResponse, Tensor,
    roll_out_response::{Deviation, Diagnostics, Divergence},
};

pub(crate) use self::{
    gradients::{Gradients, add_gradients},
    span::Span,
};
use crate::{
    request::{grasping, initial::Starts, plausible::Extremes},
    run::plan::Plan,
};

/// Reported cost of an instance: never NaN.
pub(crate) fn cost(rollout: &Rollout) -> f64 {
    if rollout.diverged.is_some() { f64::INFINITY } else { never_nan(rollout.cost) }
}

/// Costs of a part of a reply.
pub(crate) fn costs(part: &RollOutResponse) -> Vec<f64> {
    let costs = part.costs.as_ref().and_then(|t| t.unpack("costs").ok());
    costs.map(|(_, costs)| costs).unwrap_or_default()
}

/// Costs, terms, diagnostics, divergences and what is implausible of instances that follow one
/// another.
pub(crate) fn summary(
    plan: &Plan,
    indices: &[usize],
    rollouts: &[Rollout],
    extremes: &[Extremes],
) -> RollOutResponse {
    let asked = indices.iter().zip(rollouts).zip(extremes).filter(|_| plan.returns.diagnostics);
    let diagnostics = asked.map(|((instance, r), extremes)| {
        let d = r.diagnostics.unwrap_or_default();
        let joules = plan.force_unit(*instance);
        Diagnostics {
            max_strain: d.max_strain,
            max_speed_m_s: d.max_speed_m_s,
            kinetic_energy: joules * d.kinetic_energy,
            elastic_energy: joules * d.elastic_energy,
            ground_contacts: d.ground_contacts,
            max_control_strain: d.max_control_strain,
            control_depth_m: extremes.depth.0,
            stopped_hand_m: extremes.stopped_m,
        }
    });
    let implausible =
        indices.iter().zip(rollouts).zip(extremes).flat_map(|((instance, rollout), extremes)| {
            plan.plausibility.judge(*instance, extremes, Some(rollout))
        });
    let diverged = rollouts.iter().zip(indices).filter_map(|(r, i)| divergence(plan, *i, r));
    let mut part = RollOutResponse {
        first_instance: indices.first().map_or(0, |first| *first as u32),
        diagnostics: diagnostics.collect(),
        diverged: diverged.collect(),
        implausible: implausible.collect(),
        ..head(plan)
    };
    set_costs(plan, rollouts, &mut part);
    part
}

/// Sets costs, terms and successes to those of rollouts.
pub(crate) fn set_costs(plan: &Plan, rollouts: &[Rollout], part: &mut RollOutResponse) {
    let names = plan.costs.names.len();
    let costs: Vec<f64> = rollouts.iter().map(cost).collect();
    let terms: Vec<f64> = rollouts
        .iter()
        .flat_map(|r| (0..names).map(|g| r.group_costs.get(g).copied().unwrap_or(f64::NAN)))
        .map(never_nan)
        .collect();
    part.costs = Some(Tensor::pack(&[costs.len()], &costs));
    part.cost_terms = Some(Tensor::pack(&[costs.len(), names], &terms));
    part.successes = plan.costs.successes(rollouts).map(|s| Tensor::pack(&[costs.len()], &s));
}

/// The divergence of an instance.
pub(crate) fn divergence(plan: &Plan, instance: usize, rollout: &Rollout) -> Option<Divergence> {
    let at = rollout.diverged?;
    let (instance, node) = (instance as u32, plan.node(at.node) as u32);
    Some(Divergence { instance, frame: at.frame as u32, node })
}

/// The part of a reply that is the same for all instances.
pub(crate) fn head(plan: &Plan) -> RollOutResponse {
    let fast = plan.served.fast.map(|f| Deviation {
        mean_m: f.mean_deviation_m,
        max_m: f.max_deviation_m,
        mean_travel_m: f.mean_travel_m,
        frames: f.frames,
    });
    let planners = plan.served.planner.as_ref().and_then(|planner| planner.of.twin.quality.planner);
    let (fidelity, deviation) = match (planners, fast) {
        (Some(p), _) => {
            let (mean_m, max_m) = (p.mean_deviation_m, p.max_deviation_m);
            let (mean_travel_m, frames) = (p.mean_travel_m, p.frames);
            (Fidelity::Planner, Some(Deviation { mean_m, max_m, mean_travel_m, frames }))
        }
        (None, Some(fast)) => (Fidelity::Fast, Some(fast)),
        (None, None) => (Fidelity::Exact, None),
    };
    RollOutResponse {
        cost_names: plan.costs.names.clone(),
        fidelity: fidelity.into(),
        substeps: plan.variants.most_substeps(),
        deviation,
        mass_kg: plan.twin().mass_kg,
        ..RollOutResponse::default()
    }
}

/// Arrays of simulated instances over a span.
pub(crate) struct Arrays<'a> {
    pub(crate) indices: &'a [usize],
    pub(crate) rollouts: &'a [Rollout],
    /// Mean motions of the members of each action, if arrays are of these.
    pub(crate) means: &'a [Rollout],
    pub(crate) starts: &'a Starts,
    /// Control points of final states [m], shape [instances, C, 3]; empty without such states.
    pub(crate) ends: &'a [Point],
    /// Control points at the frame boundaries [m] if asked for, shape [instances, boundaries, C, 3].
    pub(crate) paths: &'a [Point],
}

/// Adds the arrays that were asked for: of all instances, or of one for each action where there is a
/// spread or a mean motion.
pub(crate) fn add_arrays(plan: &Plan, span: Span, arrays: &Arrays<'_>, part: &mut RollOutResponse) {
    if plan.returns.spread {
        part.spread = Some(spread::pack(plan, span, arrays.rollouts));
    }
    if plan.returns.spread || plan.ensemble.weights.is_some() {
        let first = spread::first_members(arrays, plan.ensemble.members);
        return add_own(plan, span, &first.arrays(arrays.starts), part);
    }
    add_own(plan, span, arrays, part);
}

fn add_own(plan: &Plan, span: Span, arrays: &Arrays<'_>, part: &mut RollOutResponse) {
    add_recordings(plan, span, arrays, part);
    if plan.returns.controls {
        add_controls(plan, span, arrays.indices.len(), arrays.paths, part);
    }
}

/// Recorded positions and velocities and costs by frame of rollouts over a span, and final states at
/// its end. Frames that a diverged instance did not reach are NaN (with INT16, which has none, the
/// middle of the extent).
fn add_recordings(plan: &Plan, span: Span, arrays: &Arrays<'_>, part: &mut RollOutResponse) {
    let Arrays { indices: instances, rollouts, starts, ends: controls, .. } = *arrays;
    let returns = &plan.returns;
    if !returns.has_arrays() && returns.best.is_none() {
        return;
    }
    let graph = &plan.twin().graph;
    if returns.forces {
        part.forces = Some(forces::pack(plan, span, instances, rollouts));
    }
    let indices: Vec<u32> = instances.iter().map(|i| *i as u32).collect();
    part.instances = Some(Tensor::pack(&[indices.len()], &indices));
    if returns.every > 0 {
        let rows = returns.recorded_frames(span.frames());
        let width = returns.recorded.count(&plan.twin().skin, graph.node_count());
        let frames: Vec<u32> = (1..=rows).map(|i| (span.from + i * returns.every) as u32).collect();
        let pack = |of: fn(&Rollout) -> &[Point]| {
            let mut values = Vec::with_capacity(rollouts.len() * rows * width);
            for rollout in rollouts {
                extend_padded(&mut values, of(rollout), rows * width);
            }
            let shape = [rollouts.len(), rows, width];
            if returns.int16 {
                Tensor::pack_points_i16(&shape, &values)
            } else {
                Tensor::pack_points(&shape, &values)
            }
        };
        part.frames = Some(Tensor::pack(&[rows], &frames));
        part.positions = Some(pack(|r| &r.positions));
        part.velocities = returns.velocities.then(|| pack(|r| &r.velocities));
    }
    if returns.frame_costs {
        let (rows, width) = (span.rows().len(), plan.costs.names.len());
        let own = rollouts.iter().flat_map(|r| plan.costs.without_conditions(&r.frame_costs));
        let values: Vec<f64> = own.map(|c| never_nan(*c)).collect();
        part.frame_costs = Some(Tensor::pack(&[rollouts.len(), rows, width], &values));
    }
    if returns.final_state && span.to == plan.frames {
        let n = plan.nodes();
        let nothing = State::default();
        let ends: Vec<Option<State>> =
            rollouts.iter().map(|r| Some(plan.carried(r.final_state.as_ref()?))).collect();
        let pack = |of: fn(&State) -> &[Point]| {
            let mut values = Vec::with_capacity(rollouts.len() * n);
            for end in &ends {
                extend_padded(&mut values, of(end.as_ref().unwrap_or(&nothing)), n);
            }
            Tensor::pack_points(&[rollouts.len(), n], &values)
        };
        part.final_positions = Some(pack(|s| &s.positions));
        part.final_velocities = Some(pack(|s| &s.velocities));
        let rods = graph.rods.len();
        if rods > 0 {
            let mut twists = Vec::with_capacity(rollouts.len() * rods);
            for rollout in rollouts {
                let end = twists.len() + rods;
                twists.extend(rollout.final_state.iter().flat_map(|s| &s.twists).take(rods));
                twists.resize(end, f32::NAN);
            }
            part.final_twists = Some(Tensor::pack(&[rollouts.len(), rods], &twists));
        }
        let shape = [rollouts.len(), graph.control_count()];
        part.final_controls = Some(Tensor::pack_points(&shape, controls));
        let commanded: Option<Vec<Vec<Point>>> =
            instances.iter().map(|i| plan.commanded(*i, starts)).collect();
        part.final_commanded_controls =
            commanded.map(|rows| Tensor::pack_points(&shape, &rows.concat()));
        if plan.grasps > 0 {
            let states = ends.iter().map(Option::as_ref);
            part.final_grasping = Some(grasping::pack(states, plan.grasps, n));
        }
    }
}

/// Control points of instances at the frame boundaries of a span, shape [instances, boundaries, C].
fn add_controls(
    plan: &Plan,
    span: Span,
    count: usize,
    paths: &[Point],
    part: &mut RollOutResponse,
) {
    let shape = [count, span.rows().len(), plan.twin().graph.control_count()];
    part.controls = Some(Tensor::pack_points(&shape, paths));
}

fn extend_padded(out: &mut Vec<Point>, values: &[Point], len: usize) {
    let end = out.len() + len;
    out.extend(values.iter().take(len));
    out.resize(end, [f32::NAN; 3]);
}

/// Infinity for NaN; and an empty sum, which is -0, as plain 0.
fn never_nan(value: f64) -> f64 {
    if value.is_nan() { f64::INFINITY } else { value + 0.0 }
}
