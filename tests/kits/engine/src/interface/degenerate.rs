//! Degenerate inputs: random graphs, degenerate geometry, graphs without nodes or without springs,
//! and motion that diverges.

use std::{f32::consts::PI, sync::Arc};

use bendtwin_core::CancelToken;
use bendtwin_engine::{
    Backend, PointLoss, PointSet, Term,
    backend::{Diagnose, Gradient, GradientRequest, Outputs},
    objective::WeightedTerm,
};

use crate::{
    expect::{Outcome, close, ensure, finite},
    random::{
        RandomOptions, random_model, random_motion, random_objective,
        world::{WorldOptions, count_forces, random_world},
    },
    scene::Scene,
};

const EVERYTHING: GradientRequest = GradientRequest {
    cut_every: 0,
    controls: true,
    initial: true,
    final_state: true,
    ..GradientRequest::PARAMS
};

fn finite_gradient(what: &str, gradient: &Gradient) -> Outcome {
    let p = &gradient.params;
    let arrays = [
        &p.spring_stiffness,
        &p.spring_dashpot,
        &p.rest_lengths_m,
        &p.bend_stiffness,
        &p.bend_damping,
        &p.rest_angles_rad,
        &p.twist_stiffness,
        &p.twist_damping,
        &p.rest_twists_rad,
    ];
    let c = &p.contact;
    let globals =
        [p.drag, c.ground_restitution, c.ground_friction, c.object_restitution, c.object_friction];
    let ok = arrays.into_iter().flatten().chain(&globals).all(|x| x.is_finite())
        && gradient.controls.iter().flatten().all(|x| x.is_finite())
        && gradient.loss.total.is_finite();
    ensure(ok, || format!("{what}: the gradient is not finite"))?;
    gradient.initial.as_ref().map_or(Ok(()), |s| finite(&format!("{what}: gradient"), s))
}

/// Tracks every node to the origin in the last frame.
fn track_all(scene: &mut Scene) {
    let nodes: Vec<u32> = (0..scene.graph.node_count() as u32).collect();
    let targets = vec![[0.01, 0.02, 0.03]; nodes.len()];
    let track = Term::Track {
        of: PointSet::Nodes,
        points: nodes,
        targets: targets.clone(),
        loss: PointLoss::Distance,
    };
    let term = |term| WeightedTerm { frame: scene.frames, weight: 1.0, group: 0, term };
    scene.objective.terms = Arc::new(vec![
        term(track),
        term(Term::Chamfer { of: PointSet::Nodes, targets }),
        term(Term::Acceleration),
    ]);
    scene.objective.groups = vec!["all".into()];
}

fn runs_finite(what: &str, scene: &mut Scene, backend: &dyn Backend) -> Outcome {
    scene.stabilise(backend).map_err(|e| format!("{what}: {e}"))?;
    track_all(scene);
    let end = scene.end(backend).map_err(|e| format!("{what}: {e}"))?;
    finite(what, &end)?;
    let gradient = scene.gradient(backend, &EVERYTHING).map_err(|e| format!("{what}: {e}"))?;
    finite_gradient(what, &gradient)
}

/// Twenty random worlds with every part on and off, over the ground and in the air: finite states,
/// costs of forces, and gradients, those by poses included.
pub(crate) fn random_worlds_stay_finite(backend: &dyn Backend) -> Outcome {
    for seed in 0..20_u64 {
        let bit = |i: u32| (seed >> i) & 1 == 1;
        let options = RandomOptions { ground: bit(0), pins: 3, ..RandomOptions::default() };
        let with = WorldOptions {
            grasps: bit(1) || !bit(2),
            colliders: if bit(2) { 4 } else { 0 },
            smoothing_m: if bit(3) { 2e-3 } else { 0.0 },
            rolls: false,
            max_force: bit(4).then_some(1.0),
        };
        let what = format!("world {seed}");
        let model = random_model(seed, &options);
        let (state, controls) = random_motion(seed, &model, 4);
        let (world, motion) = random_world(seed, &model, &state.positions, 4, &with);
        let mut scene = Scene::around(model, state, controls, 4);
        (scene.world, scene.motion) = (world, motion);
        track_all(&mut scene);
        count_forces(&mut scene.objective, &scene.world, bit(0), 4);
        let end = scene.end(backend).map_err(|e| format!("{what}: {e}"))?;
        finite(&what, &end)?;
        let request = GradientRequest { motion: true, ..EVERYTHING };
        let gradient = scene.gradient(backend, &request).map_err(|e| format!("{what}: {e}"))?;
        finite_gradient(&what, &gradient)?;
        let poses = gradient.poses.iter().flatten().flatten();
        ensure(gradient.poses.len() == scene.motion.poses.len(), || format!("{what}: poses"))?;
        ensure(poses.copied().all(f32::is_finite), || format!("{what}: gradient by poses"))?;
    }
    Ok(())
}

/// Forty random graphs with every feature on and off: finite states, losses and gradients.
pub(crate) fn random_graphs_stay_finite(backend: &dyn Backend) -> Outcome {
    for seed in 0..40_u64 {
        let bit = |i: u32| (seed >> i) & 1 == 1;
        let options = RandomOptions {
            nodes: 1 + (seed as usize * 7) % 50,
            controls: seed as usize % 4,
            pins: if seed % 5 == 4 { 4 } else { seed as usize % 3 },
            objects: 1 + seed as u32 % 3,
            bending: !bit(0) || bit(3),
            damping: !bit(1),
            ground: bit(2),
            contact: bit(1),
            skin_contact: bit(4),
            rod: seed % 5 == 4,
        };
        let model = random_model(seed, &options);
        let frames = 8;
        let (state, controls) = random_motion(seed, &model, frames);
        let objective = random_objective(seed, &model, frames);
        let mut scene = Scene::around(model, state, controls, frames);
        scene.objective = objective;
        let what = format!("seed {seed}");
        let end = scene.end(backend).map_err(|e| format!("{what}: {e}"))?;
        finite(&what, &end)?;
        finite_gradient(&what, &scene.gradient(backend, &EVERYTHING)?)?;
    }
    Ok(())
}

/// Geometry for which directions and angles do not exist.
pub(crate) fn degenerate_geometry_stays_finite(backend: &dyn Backend) -> Outcome {
    let line = [[0.0; 3], [0.1, 0.0, 0.0], [0.2, 0.0, 0.0]];
    let folded = [[0.1, 0.0, 0.0], [0.0; 3], [0.1, 0.0, 0.0]];
    let together = [[0.1, 0.1, 0.1]; 3];
    let arm_gone = [[0.1, 0.0, 0.0], [0.1, 0.0, 0.0], [0.2, 0.0, 0.0]];
    let shapes = [
        ("a straight triplet", line),
        ("a folded triplet", folded),
        ("all nodes in one point", together),
        ("an arm of length zero", arm_gone),
    ];
    for (shape, points) in shapes {
        for rest_angle in [PI, 0.0, 1.5] {
            for moving in [false, true] {
                let mut scene = Scene::of(&points);
                scene.spring([0, 1], 10.0, 0.5);
                scene.spring([1, 2], 10.0, 0.5);
                scene.params.rest_lengths_m.fill(0.1);
                scene.triplet([0, 1, 2], rest_angle, 0.01, 1e-4);
                scene.environment.gravity = [0.0, 0.0, -9.81];
                scene.ground([0.0, 0.0, 1.0], -0.5, 0.5, 0.3);
                scene.params.contact.within_object = true;
                scene.graph.object_ids[2] = 1;
                scene.params.contact.between_objects = true;
                if moving {
                    scene.initial.velocities[0] = [0.1, 0.2, -0.1];
                }
                scene.last(5);
                let what = format!("{shape}, rest angle {rest_angle}, moving {moving}");
                runs_finite(&what, &mut scene, backend)?;
            }
        }
    }
    // A control point upon its node, and a node that starts on the ground, exactly.
    let mut scene = Scene::of(&[[0.0; 3]]);
    let control = scene.control([0.0; 3]);
    scene.spring([0, control], 10.0, 1.0);
    scene.params.rest_lengths_m[0] = 0.05;
    scene.ground([0.0, 0.0, 1.0], 0.0, 0.0, 2.0);
    scene.last(5);
    runs_finite("a control point upon its node", &mut scene, backend)?;
    // Rest length zero: a strain does not exist. Refused or survived, not NaN.
    let mut scene = Scene::of(&line[..2]);
    scene.spring([0, 1], 10.0, 0.5);
    scene.params.rest_lengths_m[0] = 0.0;
    scene.last(5);
    match backend.load(Arc::new(scene.model())) {
        Err(bendtwin_engine::Error::InvalidModel(_) | bendtwin_engine::Error::Unstable { .. }) => {
            Ok(())
        }
        _ => runs_finite("a rest length of zero", &mut scene, backend),
    }
}

/// No nodes, one node, nodes without springs: all run, and free fall is free fall (to 0.1 %:
/// one substep of 0.5 ms in a second).
pub(crate) fn empty_and_lonely_graphs_work(backend: &dyn Backend) -> Outcome {
    for nodes in [0, 1, 5] {
        let points: Vec<_> = (0..nodes).map(|i| [0.1 * i as f32, 0.0, 0.0]).collect();
        let mut scene = Scene::of(&points);
        scene.environment.gravity[2] = -9.81;
        scene.last(100);
        track_all(&mut scene);
        let rollout = scene.roll_out(backend).map_err(|e| format!("{nodes} nodes: {e}"))?;
        ensure(rollout.positions.len() == 101 * nodes, || {
            format!("{} positions of {nodes} nodes", rollout.positions.len())
        })?;
        for x in rollout.positions.iter().skip(100 * nodes) {
            close("fall in a second", f64::from(x[2]), -9.81 / 2.0, 5e-3)?;
        }
        let gradient = scene.gradient(backend, &EVERYTHING)?;
        finite_gradient(&format!("{nodes} nodes"), &gradient)?;
        ensure(gradient.initial.is_some_and(|s| s.positions.len() == nodes), || {
            "the initial gradient has another shape".to_owned()
        })?;
    }
    // Controls that hold nothing, and no frames at all.
    let mut scene = Scene::of(&[[0.0; 3]]);
    scene.control([1.0, 0.0, 0.0]);
    scene.last(3);
    runs_finite("a control point that holds nothing", &mut scene, backend)?;
    scene.last(0);
    scene.objective = Default::default();
    let rollout = scene.roll_out(backend).map_err(|e| format!("no frames: {e}"))?;
    ensure(rollout.frames == [0] && rollout.final_state == Some(scene.initial.clone()), || {
        "zero frames do not return the start".to_owned()
    })
}

/// A node that flies away is reported with its frame and index, costs infinitely, and does not
/// disturb its neighbours in the batch. What is not known of it is no number: zero would look like a
/// perfect rollout. Only gradients by parameters are zero, for a fit to add up.
pub(crate) fn divergence_says_where(backend: &dyn Backend) -> Outcome {
    let mut scene = Scene::of(&[[0.0; 3], [0.1, 0.0, 0.0], [0.2, 0.0, 0.0]]);
    scene.spring([0, 1], 10.0, 0.1);
    scene.control([1.0, 0.0, 0.0]);
    scene.last(6);
    track_all(&mut scene);
    let calm = scene.clone();
    // 400 m a frame: past a kilometre in frame 3.
    scene.initial.velocities[2] = [0.0, 40_000.0, 0.0];
    let batch = [
        calm.instance(calm.load(backend)?),
        scene.instance(scene.load(backend)?),
        calm.instance(calm.load(backend)?),
    ];
    let outputs = Outputs {
        every: 1,
        final_state: true,
        diagnose: Diagnose::All,
        velocities: true,
        frame_costs: true,
        ..Outputs::NONE
    };
    let cancel = CancelToken::default();
    let rollouts = backend.roll_out(&batch, &outputs, &cancel).map_err(|e| e.to_string())?;
    let losses = backend.losses(&batch, &cancel).map_err(|e| e.to_string())?;
    let request = GradientRequest { norms: true, ..EVERYTHING };
    let gradients = backend.gradients(&batch, &request, &cancel).map_err(|e| e.to_string())?;
    let (Some(rollout), Some(loss), Some(gradient)) =
        (rollouts.get(1), losses.get(1), gradients.get(1))
    else {
        return Err("too few results".into());
    };
    for (call, d) in [
        ("roll_out", rollout.diverged),
        ("losses", loss.diverged),
        ("gradients", gradient.loss.diverged),
    ] {
        let at = d.map(|d| (d.frame, d.node));
        ensure(at == Some((3, 2)), || {
            format!("{call}: diverged at {at:?} (frame, node), expected frame 3, node 2")
        })?;
    }
    let costs = [rollout.cost, loss.total, gradient.loss.total];
    ensure(costs.iter().all(|c| *c == f64::INFINITY), || format!("costs {costs:?}"))?;
    ensure(rollout.frames == [1, 2], || format!("recorded frames {:?}", rollout.frames))?;
    ensure(rollout.final_state.is_none() && rollout.velocities.len() == 6, || {
        format!("{} velocities, final state {:?}", rollout.velocities.len(), rollout.final_state)
    })?;
    let by_frame: Vec<bool> = rollout.frame_costs.iter().map(|c| c.is_finite()).collect();
    ensure(by_frame == [true, true, true, false, false, false, false], || {
        format!("costs by frame {:?}", rollout.frame_costs)
    })?;
    let Some(d) = rollout.diagnostics else { return Err("it has no diagnostics".into()) };
    close("speed before it diverged", f64::from(d.max_speed_m_s), 4e4, 1.0)?;
    close("strain before it diverged", f64::from(d.max_strain), 0.0, 1e-4)?;
    ensure(d.kinetic_energy.is_nan() && d.elastic_energy.is_nan(), || format!("{d:?}"))?;
    let p = &gradient.params;
    let zero = p.spring_stiffness.iter().chain(&p.spring_dashpot).all(|g| *g == 0.0);
    ensure(zero && p.spring_stiffness.len() == 1, || {
        "its gradient by parameters is not zero".to_owned()
    })?;
    let Some(initial) = &gradient.initial else { return Err("no initial gradient".into()) };
    let unknown = initial.positions.iter().chain(&initial.velocities).chain(&gradient.controls);
    let count = unknown.clone().count();
    ensure(unknown.flatten().all(|g| g.is_nan()) && count == 6 + gradient.controls.len(), || {
        format!("{count} gradients, not all of them unknown: {initial:?}")
    })?;
    ensure(gradient.controls.len() == 7, || format!("{} controls", gradient.controls.len()))?;
    let norms = &gradient.norms;
    ensure(norms.len() == 7 && norms.iter().all(|n| n.is_nan()), || format!("norms {norms:?}"))?;
    for i in [0, 2] {
        ensure(rollouts[i].diverged.is_none() && losses[i].total.is_finite(), || {
            format!("instance {i} suffers from another one's divergence")
        })?;
    }
    Ok(())
}
