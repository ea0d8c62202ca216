//! Losses, outputs and diagnostics against their definitions.

use std::{f64::consts::PI, sync::Arc};

use bendtwin_core::Point;
use bendtwin_engine::{
    Backend, PointLoss, PointSet, Term,
    backend::{Diagnose, Diagnostics, GradientRequest, Outputs},
};

use crate::{
    energy,
    expect::{Outcome, close, ensure},
    random::{RandomOptions, random_model, random_motion, random_objective},
    scene::{Scene, cross, difference, dot, norm},
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

/// Strains of springs between two nodes, and of those to control points.
fn strains(scene: &Scene, nodes: &[Point], controls: &[Point]) -> [Vec<f64>; 2] {
    let mut found = [Vec::new(), Vec::new()];
    let at = |e: u32| nodes.iter().chain(controls).nth(e as usize);
    for (&[a, b], &l0) in scene.graph.springs.iter().zip(&scene.params.rest_lengths_m) {
        if let (Some(&from), Some(&to)) = (at(a), at(b)) {
            let strain = norm(difference(from, to)) / f64::from(l0) - 1.0;
            found[usize::from(a.max(b) as usize >= nodes.len())].push(strain);
        }
    }
    found
}

/// Positions of the points of a set.
fn placed(scene: &Scene, nodes: &[Point], of: PointSet) -> Vec<Point> {
    match of {
        PointSet::Nodes => nodes.to_vec(),
        PointSet::Skin => scene.skin.positions(nodes),
    }
}

/// Value of a term on the positions of frame `f`, from its definition.
fn value(term: &Term, scene: &Scene, frames: &[&[Point]], f: usize) -> f64 {
    let surface = scene.graph.surface_count();
    let chosen = |nodes: &Option<Arc<Vec<u32>>>| -> Vec<Point> {
        match nodes {
            None => frames[f].to_vec(),
            Some(some) => some.iter().map(|&i| frames[f][i as usize]).collect(),
        }
    };
    let mean = |values: Vec<f64>| values.iter().sum::<f64>() / values.len().max(1) as f64;
    let squared = |a: Point, b: Point| dot(difference(a, b), difference(a, b));
    match term {
        Term::Chamfer { of, targets } => {
            let surface = match of {
                PointSet::Nodes => frames[f][..surface].to_vec(),
                PointSet::Skin => scene.skin.positions(frames[f]),
            };
            let nearest = |t: &Point| {
                let distances = surface.iter().map(|x| squared(*x, *t));
                distances.fold(f64::INFINITY, f64::min)
            };
            mean(targets.iter().map(nearest).collect())
        }
        Term::Track { of, points, targets, loss } => {
            let all = placed(scene, frames[f], *of);
            let of = |(point, target): (&u32, &Point)| {
                let d = difference(all[*point as usize], *target);
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
            mean(points.iter().zip(targets).map(of).collect())
        }
        Term::Strain { limit } => {
            let [of_material, _] = strains(scene, frames[f], &[]);
            let beyond = |s: &f64| (s.abs() - f64::from(*limit)).max(0.0).powi(2);
            mean(of_material.iter().map(beyond).collect())
        }
        Term::Above { nodes, normal, offset_m } => {
            let depth = |x: &Point| {
                let height = dot(x.map(f64::from), normal.map(f64::from));
                (f64::from(*offset_m) - height).max(0.0).powi(2)
            };
            mean(chosen(nodes).iter().map(depth).collect())
        }
        Term::Within { nodes, low, high } => {
            let outside = |x: &Point| {
                let of = |k: usize| f64::from((low[k] - x[k]).max(x[k] - high[k]).max(0.0));
                (0..3).map(|k| of(k).powi(2)).sum()
            };
            mean(chosen(nodes).iter().map(outside).collect())
        }
        Term::Clearance { .. } | Term::Force { .. } => f64::NAN,
        Term::Order { of, points, direction, gap_m } => {
            let places = placed(scene, frames[f], *of);
            let along = |i: &u32| dot(places[*i as usize].map(f64::from), direction.map(f64::from));
            let lack = |w: &[u32]| f64::from(*gap_m) - (along(&w[1]) - along(&w[0]));
            mean(points.windows(2).map(|w| lack(w).max(0.0).powi(2)).collect())
        }
        Term::Winding { of, points, origin, direction, turns } => {
            // Two axes that are perpendicular to any line.
            let n = direction.map(f64::from);
            let u = cross(n, [n[2], n[0], n[1]]);
            let v = cross(n, u);
            let places = placed(scene, frames[f], *of);
            let angle = |i: &u32| {
                let way = difference(places[*i as usize], *origin);
                dot(way, v).atan2(dot(way, u))
            };
            let angles: Vec<f64> = points.iter().map(angle).collect();
            let turn = |w: &[f64]| (w[1] - w[0] + PI).rem_euclid(2.0 * PI) - PI;
            let sum: f64 = angles.windows(2).map(turn).sum();
            (sum / (2.0 * PI) - f64::from(*turns)).powi(2)
        }
        Term::Coverage { of, targets, reach_m } => {
            let surface = match of {
                PointSet::Nodes => frames[f][..surface].to_vec(),
                PointSet::Skin => scene.skin.positions(frames[f]),
            };
            let uncovered = |t: &Point| {
                let nearest = surface.iter().map(|x| squared(*x, *t)).fold(f64::INFINITY, f64::min);
                1.0 - (-nearest / (2.0 * f64::from(*reach_m).powi(2))).exp()
            };
            mean(targets.iter().map(uncovered).collect())
        }
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

/// Weighted sums of the terms by frame and group, from the definitions and the recorded positions,
/// shape [F + 1, groups].
fn expected_costs(scene: &Scene, positions: &[Point]) -> Vec<f64> {
    let frames: Vec<&[Point]> = positions.chunks_exact(scene.graph.node_count()).collect();
    let groups = scene.objective.groups.len();
    let mut costs = vec![0.0; frames.len() * groups];
    for t in scene.objective.terms.iter() {
        let v = value(&t.term, scene, &frames, t.frame);
        costs[t.frame * groups + t.group] += f64::from(t.weight) * v;
    }
    costs
}

/// Losses are the weighted sums of their terms' definitions on the recorded positions, to 1e-4
/// of each group (f32 differences of coordinates), and roll_out, losses and gradients agree:
/// exactly, as they run the same simulation.
pub(crate) fn losses_match_their_definitions(backend: &dyn Backend) -> Outcome {
    for seed in 0..4 {
        let scene = measured(seed);
        let rollout = scene.roll_out(backend)?;
        let count = scene.objective.groups.len();
        let mut expected = vec![0.0; count];
        for frame in expected_costs(&scene, &rollout.positions).chunks_exact(count) {
            expected.iter_mut().zip(frame).for_each(|(sum, v)| *sum += v);
        }
        let loss = scene.loss(backend)?;
        ensure(loss.groups.len() == count, || format!("{} groups", loss.groups.len()))?;
        for (group, want) in expected.into_iter().enumerate() {
            let what = format!("seed {seed}: {}", scene.objective.groups[group]);
            ensure(want > 1e-7, || format!("{what} is {want}, too small to tell anything"))?;
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

/// Costs by frame are their terms' definitions, to 1e-4 as above, and their sums the costs; a weight
/// of zero costs nothing and a negative one takes away.
pub(crate) fn frame_costs_match_their_definitions(backend: &dyn Backend) -> Outcome {
    for seed in 0..2 {
        let mut scene = measured(seed);
        let terms = Arc::make_mut(&mut scene.objective.terms);
        for (t, term) in terms.iter_mut().enumerate() {
            term.weight *= [1.0, -1.0, 0.0, 2.0][(t + seed as usize) % 4];
        }
        let outputs = Outputs { every: 1, initial: true, frame_costs: true, ..Outputs::NONE };
        let rollout = scene.roll_out_raw(backend, &outputs)?;
        let expected = expected_costs(&scene, &rollout.positions);
        let (got, groups) = (&rollout.frame_costs, scene.objective.groups.len());
        ensure(got.len() == expected.len(), || {
            format!("{} costs by frame, expected {}", got.len(), expected.len())
        })?;
        for (i, (&got, want)) in got.iter().zip(expected).enumerate() {
            let what = format!("seed {seed}: frame {}, group {}", i / groups, i % groups);
            close(&what, got, want, 1e-4 * want.abs() + 1e-10)?;
        }
        for (group, &whole) in rollout.group_costs.iter().enumerate() {
            let own: Vec<f64> = got.iter().skip(group).step_by(groups).copied().collect();
            let size: f64 = own.iter().map(|x| x.abs()).sum();
            close("the sum over frames", own.iter().sum(), whole, 1e-12 * size)?;
        }
    }
    Ok(())
}

/// Every k-th frame, selected nodes, with and without frame 0: the same numbers as in full.
pub(crate) fn outputs_are_as_asked(backend: &dyn Backend) -> Outcome {
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

/// Recorded velocities are bit for bit those of the states in which rollouts of as many frames end,
/// and in frame 0 those of the initial state.
pub(crate) fn velocities_are_those_of_the_states(backend: &dyn Backend) -> Outcome {
    let mut scene = measured(2);
    scene.objective = Default::default();
    let n = scene.graph.node_count();
    let all = Outputs { every: 1, initial: true, velocities: true, ..Outputs::NONE };
    let full = scene.roll_out_raw(backend, &all)?;
    ensure(full.velocities.len() == full.positions.len(), || {
        format!("{} velocities, {} positions", full.velocities.len(), full.positions.len())
    })?;
    let pinned = |i: usize| scene.graph.pins.iter().any(|p| p.node as usize == i);
    for (i, (got, start)) in full.velocities.iter().zip(&scene.initial.velocities).enumerate() {
        ensure(pinned(i) || got == start, || format!("node {i} starts at {got:?}"))?;
    }
    let c = scene.graph.control_count();
    for frames in 1..=scene.frames {
        let mut shorter = scene.clone();
        shorter.frames = frames;
        shorter.controls.truncate((frames + 1) * c);
        let end = shorter.end(backend)?;
        let recorded = &full.velocities[frames * n..(frames + 1) * n];
        ensure(recorded == end.velocities, || format!("frame {frames} differs from its state"))?;
    }
    let nodes = vec![5_u32, 0, 17];
    let some = Outputs { every: 4, initial: false, nodes: Some(Arc::new(nodes.clone())), ..all };
    let some = scene.roll_out_raw(backend, &some)?;
    let expected: Vec<Point> = nodes.iter().map(|&i| full.velocities[4 * n + i as usize]).collect();
    ensure(some.velocities == expected, || "selected velocities differ from the full record".into())
}

/// Strains and speed are bit for bit the same whether the rest is asked for or not, with and without
/// a frame or a final state; what was not asked for is unknown.
pub(crate) fn extremes_are_those_of_all_diagnostics(backend: &dyn Backend) -> Outcome {
    let mut scene = measured(3);
    // All nodes lie on it.
    scene.ground([0.0, 0.0, 1.0], 10.0, 0.0, 0.0);
    let mut at_rest = scene.clone();
    at_rest.last(0);
    at_rest.objective = Default::default();
    for (scene, final_state) in [(&scene, false), (&scene, true), (&at_rest, false)] {
        let outputs = |diagnose| Outputs { diagnose, final_state, ..Outputs::NONE };
        let all = scene.roll_out_raw(backend, &outputs(Diagnose::All))?;
        let some = scene.roll_out_raw(backend, &outputs(Diagnose::Extremes))?;
        ensure(some.final_state == all.final_state, || "the final states differ".to_owned())?;
        let (Some(all), Some(some)) = (all.diagnostics, some.diagnostics) else {
            return Err("no diagnostics came back".into());
        };
        let extremes = |d: Diagnostics| [d.max_strain, d.max_control_strain, d.max_speed_m_s];
        ensure(extremes(all) == extremes(some) && all.max_speed_m_s > 0.0, || {
            format!("{some:?}, with the rest {all:?}")
        })?;
        let is_known = |d: Diagnostics| [d.kinetic_energy, d.elastic_energy].map(f32::is_finite);
        ensure(is_known(all) == [true; 2] && all.ground_contacts > 0, || format!("{all:?}"))?;
        ensure(is_known(some) == [false; 2] && some.ground_contacts == 0, || format!("{some:?}"))?;
    }
    Ok(())
}

/// Diagnostics against the recorded motion and the final state: energies to 0.1 % (f32 sums),
/// strains to 1e-5, speed to its rounding.
pub(crate) fn diagnostics_match_the_motion(backend: &dyn Backend) -> Outcome {
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
        let n = scene.graph.node_count();
        let frames: Vec<&[Point]> = rollout.positions.chunks_exact(n).collect();
        let (mut most, mut fastest) = ([0.0_f64; 2], 0.0_f64);
        for (f, positions) in frames.iter().enumerate().skip(1) {
            let strains = strains(&scene, positions, &scene.controls[f * c..(f + 1) * c]);
            for (most, strains) in most.iter_mut().zip(strains) {
                *most = strains.iter().fold(*most, |most, s| most.max(s.abs()));
            }
            let speeds = rollout.velocities[f * n..(f + 1) * n].iter();
            fastest = speeds.map(|v| norm(v.map(f64::from))).fold(fastest, f64::max);
        }
        ensure(c == 0 || most[1] > 0.0, || "no control spring is strained".into())?;
        close("largest strain", f64::from(d.max_strain), most[0], 1e-5 * (1.0 + most[0]))?;
        let of_controls = f64::from(d.max_control_strain);
        close("of a control spring", of_controls, most[1], 1e-5 * (1.0 + most[1]))?;
        close("largest speed", f64::from(d.max_speed_m_s), fastest, 1e-6 * fastest)?;
    }
    Ok(())
}
