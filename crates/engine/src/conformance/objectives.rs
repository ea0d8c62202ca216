//! Losses, outputs and diagnostics against their definitions.

use std::sync::Arc;

use bendtwin_core::Point;

use super::{
    energy,
    expect::{Outcome, close, ensure},
    random::{RandomOptions, random_model, random_motion, random_objective},
    scene::{Scene, difference, dot, norm},
};
use crate::{
    Backend, PointLoss, Term,
    backend::{GradientRequest, Outputs},
};

fn measured(seed: u64) -> Scene {
    let options = RandomOptions { ground: true, ..RandomOptions::default() };
    let model = random_model(seed, &options);
    let frames = 6;
    let (state, controls) = random_motion(seed, &model, frames);
    let objective = random_objective(seed, &model, frames);
    let mut scene = Scene::around(model, state, controls, frames);
    scene.objective = objective;
    scene
}

/// Value of a term on the positions of frame `f`, from its definition.
fn value(term: &Term, frames: &[&[Point]], f: usize, surface: usize) -> f64 {
    let mean = |values: Vec<f64>| values.iter().sum::<f64>() / values.len().max(1) as f64;
    let squared = |a: Point, b: Point| dot(difference(a, b), difference(a, b));
    match term {
        Term::Chamfer { targets } => {
            let nearest = |t: &Point| {
                let nodes = frames[f][..surface].iter().map(|x| squared(*x, *t));
                nodes.fold(f64::INFINITY, f64::min)
            };
            mean(targets.iter().map(nearest).collect())
        }
        Term::Track { nodes, targets, loss } => {
            let of = |(node, target): (&u32, &Point)| {
                let d = difference(frames[f][*node as usize], *target);
                match loss {
                    PointLoss::Distance => norm(d),
                    PointLoss::SquaredDistance => dot(d, d),
                    PointLoss::SmoothL1 { beta_m } => {
                        let beta = f64::from(*beta_m);
                        let smooth = |d: f64| {
                            if d.abs() < beta { d * d / (2.0 * beta) } else { d.abs() - beta / 2.0 }
                        };
                        d.map(smooth).iter().sum::<f64>() / 3.0
                    }
                }
            };
            mean(nodes.iter().zip(targets).map(of).collect())
        }
        Term::Strain { .. }
        | Term::Above { .. }
        | Term::Within { .. }
        | Term::Clearance { .. }
        | Term::Force { .. } => f64::NAN,
        Term::Acceleration if f < 2 => 0.0,
        Term::Acceleration => {
            let nodes = frames[f].iter().zip(frames[f - 1]).zip(frames[f - 2]);
            let of = |((x, y), z): ((&Point, &Point), &Point)| {
                let a =
                    [0, 1, 2].map(|i| f64::from(x[i]) - 2.0 * f64::from(y[i]) + f64::from(z[i]));
                dot(a, a)
            };
            mean(nodes.map(of).collect())
        }
    }
}

/// Losses are the weighted sums of their terms' definitions on the recorded positions, to 1e-4
/// of each group (f32 differences of coordinates), and roll_out, losses and gradients agree:
/// exactly, as they run the same simulation.
pub(super) fn losses_match_their_definitions(backend: &dyn Backend) -> Outcome {
    for seed in 0..4 {
        let scene = measured(seed);
        let rollout = scene.roll_out(backend)?;
        let n = scene.graph.node_count();
        let frames: Vec<&[Point]> = rollout.positions.chunks_exact(n).collect();
        let mut expected = [0.0; 3];
        for t in scene.objective.terms.iter() {
            let v = value(&t.term, &frames, t.frame, scene.graph.surface_count());
            expected[t.group] += f64::from(t.weight) * v;
        }
        let loss = scene.loss(backend)?;
        ensure(loss.groups.len() == 3, || format!("{} groups of 3", loss.groups.len()))?;
        for (group, want) in expected.into_iter().enumerate() {
            let what = format!("seed {seed}: group {group}");
            close(&what, loss.groups[group], want, 1e-4 * want + 1e-10)?;
        }
        let sum: f64 = loss.groups.iter().sum();
        close("the total of the groups", loss.total, sum, 1e-9 * sum.abs())?;
        let gradient = scene.gradient(backend, &GradientRequest::default())?;
        let totals = [loss.total, rollout.cost, gradient.loss.total];
        ensure(totals.iter().all(|t| t.to_bits() == totals[0].to_bits()), || {
            format!("losses, roll_out and gradients give {totals:?}")
        })?;
        ensure(rollout.group_costs == loss.groups && gradient.loss.groups == loss.groups, || {
            "the groups differ between losses, roll_out and gradients".to_owned()
        })?;
    }
    Ok(())
}

/// Every k-th frame, selected nodes, with and without frame 0: the same numbers as in full.
pub(super) fn outputs_are_as_asked(backend: &dyn Backend) -> Outcome {
    let mut scene = measured(1);
    scene.objective = Default::default();
    let n = scene.graph.node_count();
    let full = scene.roll_out(backend)?;
    ensure(full.frames == [0, 1, 2, 3, 4, 5, 6], || format!("frames {:?}", full.frames))?;
    let end = full.final_state.as_ref().map(|s| s.positions.as_slice());
    ensure(end == Some(&full.positions[6 * n..]), || {
        "the last recorded frame is not the final state".to_owned()
    })?;
    let nodes = vec![5_u32, 0, 17];
    let outputs = Outputs { every: 4, nodes: Some(Arc::new(nodes.clone())), ..Outputs::default() };
    let some = scene.roll_out_raw(backend, &outputs)?;
    ensure(some.frames == [4], || format!("frames {:?} of every 4th of 6", some.frames))?;
    let expected: Vec<Point> = nodes.iter().map(|&i| full.positions[4 * n + i as usize]).collect();
    ensure(some.positions == expected, || "selected nodes differ from the full record".into())?;
    ensure(some.final_state.is_none() && some.diagnostics.is_none(), || {
        "a final state or diagnostics came unasked".to_owned()
    })?;
    let none = scene.roll_out_raw(backend, &Outputs::default())?;
    ensure(none.positions.is_empty() && none.frames.is_empty(), || "recorded unasked".to_owned())
}

/// Diagnostics against the final state: energies to 0.1 % (f32 sums), speed to 1e-6,
/// strain at least that of the final state.
pub(super) fn diagnostics_match_the_state(backend: &dyn Backend) -> Outcome {
    for seed in 0..4 {
        let scene = measured(seed);
        let rollout = scene.roll_out(backend)?;
        let (Some(state), Some(d)) = (&rollout.final_state, rollout.diagnostics) else {
            return Err("no final state or no diagnostics came back".into());
        };
        let mut at_end = scene.clone();
        let c = scene.graph.control_count();
        at_end.controls.drain(..scene.frames * c);
        let points = energy::endpoints(&at_end, state);
        let elastic = energy::elastic(&scene, &points);
        let kinetic = energy::kinetic(&scene, state);
        close("elastic energy", f64::from(d.elastic_energy), elastic, 1e-3 * elastic)?;
        close("kinetic energy", f64::from(d.kinetic_energy), kinetic, 1e-3 * kinetic)?;
        let speeds = state.velocities.iter().map(|v| norm(v.map(f64::from)));
        let fastest = speeds.fold(0.0, f64::max);
        let strains = scene.graph.springs.iter().zip(&scene.params.rest_lengths_m);
        let strain = strains
            .map(|(&s, &l0)| (energy::length(&points, s) / f64::from(l0) - 1.0).abs())
            .fold(0.0, f64::max);
        ensure(f64::from(d.max_speed_m_s) >= fastest - 1e-6, || {
            format!("max speed {} below the final state's {fastest}", d.max_speed_m_s)
        })?;
        ensure(f64::from(d.max_strain) >= strain - 1e-5, || {
            format!("max strain {} below the final state's {strain}", d.max_strain)
        })?;
    }
    Ok(())
}
