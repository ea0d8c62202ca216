//! Grasps: what they take, how they hold, when they release; and clamps that roll.

use std::{f64::consts::TAU, sync::Arc};

use bendtwin_core::{CancelToken, Point};
use bendtwin_engine::{
    Backend,
    backend::Outputs,
    model::State,
    world::{Attachment, Grasp, IDENTITY, Phase, Pose, Region},
};

use crate::{
    expect::{Outcome, close, ensure},
    physics::twist::cable,
    random::{RandomOptions, random_model, random_motion, random_objective},
    scene::{Scene, difference, norm, pose},
};

/// A grasp by pins that never slips.
pub(crate) fn pins(body: u32, region: Region) -> Grasp {
    Grasp { body, region, attachment: Attachment::Pin, max_force: f32::INFINITY }
}

fn sphere(center: Point, radius_m: f32) -> Region {
    Region::Sphere { center, radius_m }
}

/// Position of a body's point.
fn moved(pose: &Pose, o: [f64; 3]) -> [f64; 3] {
    pose.map(|row| {
        let [x, y, z, p] = row.map(f64::from);
        x * o[0] + y * o[1] + z * o[2] + p
    })
}

/// A held node is at its place on the body at every frame's end, to 1 µm of rounding, with the
/// velocity of the straight line there.
pub(crate) fn a_held_node_follows_its_body(backend: &dyn Backend) -> Outcome {
    let mut scene = Scene::of(&[[0.1, 0.02, 0.0], [0.3, 0.0, 0.0]]);
    scene.environment.gravity = [0.0, 0.0, -9.81];
    scene.last(12);
    let path = |f: usize| {
        let t = f as f64;
        pose([0.05 + 0.01 * t, 0.02 * (0.5 * t).sin(), 0.003 * t * t], 0.1 * t)
    };
    let body = scene.body(path);
    scene.grasp(pins(body, sphere([0.05, 0.02, 0.0], 0.03)), |_| true);
    let rollout = scene.roll_out(backend)?;
    let place = [0.05, 0.02, 0.0];
    for f in 1..=12 {
        let off =
            norm(difference(rollout.positions[2 * f], moved(&path(f), place).map(|x| x as f32)));
        close(&format!("distance from its place in frame {f}"), off, 0.0, 1e-6)?;
    }
    let end = scene.end(backend)?;
    let (a, b) = (moved(&path(11), place), moved(&path(12), place));
    for c in 0..3 {
        let expected = (b[c] - a[c]) * scene.timing.fps;
        close("velocity", f64::from(end.velocities[0][c]), expected, 2e-3)?;
    }
    let fallen = 0.5 * 9.81 * 0.12_f64.powi(2);
    close("the free node's height", f64::from(end.positions[1][2]), -fallen, 0.02 * fallen)
}

/// A node on a spring of a grasp swings with the frequency of stiffness and mass: it is back after a
/// period, within 1 % of the amplitude.
pub(crate) fn a_spring_hold_has_its_frequency(backend: &dyn Backend) -> Outcome {
    let (stiffness, amplitude) = (400.0, 0.01);
    let mut scene = Scene::of(&[[0.0; 3]]);
    scene.graph.masses[0] = 4.0;
    scene.timing.fps = 10.0 / TAU * 4.0;
    scene.timing.substeps = 200;
    scene.last(8);
    let body = scene.body(|_| IDENTITY);
    let attachment = Attachment::Spring { stiffness, damping: 0.0 };
    scene.grasp(Grasp { attachment, ..pins(body, sphere([0.0; 3], 0.001)) }, |_| true);
    // It starts with the speed that carries it so far.
    scene.initial.velocities[0] = [0.0, amplitude * 10.0, 0.0];
    let rollout = scene.roll_out(backend)?;
    let y: Vec<f64> = rollout.positions.iter().map(|p| f64::from(p[1])).collect();
    let a = f64::from(amplitude);
    close("after a quarter", y[1], a, 0.01 * a)?;
    close("after half a period", y[2], 0.0, 0.01 * a)?;
    close("after three quarters", y[3], -a, 0.01 * a)?;
    close("after two periods", y[8], 0.0, 0.02 * a)
}

/// A hand takes exactly the nodes in its region, sphere or box, in its own coordinates; nodes that
/// are pinned, or in another hand, stay where they are held.
pub(crate) fn a_hand_takes_what_is_inside(backend: &dyn Backend) -> Outcome {
    let points: Vec<Point> = (0..8).map(|i| [0.01 * i as f32, 0.0, 0.0]).collect();
    let mut scene = Scene::of(&points);
    scene.fix(2);
    scene.last(2);
    // Turned by a quarter: the body's x axis points along the world's y axis.
    let at = |f: usize| pose([0.03, 0.01 * f as f64, 0.0], TAU / 4.0);
    let body = scene.body(at);
    scene.grasp(pins(body, sphere([0.0; 3], 0.0151)), |_| true);
    let low = [-0.001, -0.0251, -0.001];
    scene.grasp(pins(body, Region::Box { low, high: [0.001, 0.001, 0.001] }), |_| true);
    scene.grasp(pins(body, Region::Nodes(Arc::new(vec![0, 3]))), |f| f == 1);
    let end = scene.end(backend)?;
    let held: Vec<(u32, u32)> = end.grasping.holds.iter().map(|h| (h.node, h.grasp)).collect();
    let expected = [(0, 2), (3, 0), (4, 0), (5, 1)];
    ensure(held == expected, || format!("held are {held:?}, expected {expected:?}"))?;
    ensure(end.grasping.phases == [Phase::Closed; 3], || format!("{:?}", end.grasping.phases))?;
    for (i, x) in end.positions.iter().enumerate() {
        let expected = match i {
            0 => 0.01,
            3..=5 => 0.02,
            _ => 0.0,
        };
        close(&format!("way of node {i}"), f64::from(x[1]), expected, 1e-6)?;
    }
    Ok(())
}

/// A released node keeps its velocity and falls: a parabola, to 1 %. Another hand that closes at
/// the same moment takes over.
pub(crate) fn opening_lets_fall(backend: &dyn Backend) -> Outcome {
    let mut scene = Scene::of(&[[0.0; 3], [0.5, 0.0, 0.0]]);
    scene.environment.gravity = [0.0, 0.0, -9.81];
    scene.timing.substeps = 100;
    scene.last(20);
    let body = scene.body(|f| pose([0.0, 0.0, 0.005 * f as f64], 0.0));
    scene.grasp(pins(body, Region::Nodes(Arc::new(vec![0, 1]))), |f| f < 10);
    scene.grasp(pins(body, Region::Nodes(Arc::new(vec![1]))), |f| f >= 10);
    let end = scene.end(backend)?;
    let t = 0.1;
    let expected = 0.05 + 0.5 * t - 0.5 * 9.81 * t * t;
    close("height of what falls", f64::from(end.positions[0][2]), expected, 5e-4)?;
    close("height of what was handed over", f64::from(end.positions[1][2]), 0.1, 1e-6)?;
    ensure(end.grasping.holds.len() == 1, || format!("{:?}", end.grasping))
}

/// A control point's springs and pins hold until its hand opens, and never again after that.
pub(crate) fn control_points_release(backend: &dyn Backend) -> Outcome {
    let mut scene = Scene::of(&[[0.0; 3], [0.1, 0.0, 0.0], [0.2, 0.0, 0.0], [0.3, 0.0, 0.0]]);
    scene.environment.gravity = [0.0, 0.0, -9.81];
    scene.timing.substeps = 100;
    scene.fix(0);
    scene.fix(1);
    let by = scene.control([0.2, 0.0, 0.01]);
    scene.spring([2, by], 1e3, 0.0);
    scene.last(20);
    let body = scene.body(|_| IDENTITY);
    let region = Region::Controls(Arc::new(vec![1, 2]));
    scene.grasp(pins(body, region), |f| !(10..15).contains(&f));
    let rollout = scene.roll_out(backend)?;
    let z = |frame: usize, node: usize| f64::from(rollout.positions[4 * frame + node][2]);
    let sag = 9.81 * 0.01 / 1e3;
    for f in 0..=20 {
        close("the pinned node", z(f, 0), 0.0, 1e-7)?;
        if f <= 10 {
            close("a pin in the hand", z(f, 1), 0.0, 1e-7)?;
            ensure(z(f, 2) <= 1e-6 && z(f, 2) >= -2.1 * sag, || format!("spring: {}", z(f, 2)))?;
        }
    }
    let fallen = -0.5 * 9.81 * 0.01;
    close("a node that fell for 0.1 s", z(20, 1), fallen, 0.01 * -fallen)?;
    ensure(z(20, 2) < 0.9 * fallen, || format!("the spring still holds at {}", z(20, 2)))?;
    let end = scene.end(backend)?;
    ensure(end.grasping.phases == [Phase::Open], || format!("{:?}", end.grasping.phases))
}

/// A hand releases at the end of the first frame in which it would have to pull harder than its
/// limit, and holds again only after commands to open and to close.
pub(crate) fn a_hand_slips_above_its_force(backend: &dyn Backend) -> Outcome {
    let mut scene = Scene::of(&[[0.0; 3]]);
    scene.graph.masses[0] = 2.0;
    scene.environment.gravity = [0.0, 0.0, -10.0];
    scene.last(12);
    // Still for five frames (20 N), then up with 1 m/s² more each frame: 22 N at most, 24 N ...
    let height = |f: usize| match f {
        0..=5 => 0.0,
        6 => 1e-4,
        _ => 1e-4 * ((f - 5) * (f - 5)) as f64,
    };
    let body = scene.body(|f| pose([0.0, 0.0, height(f)], 0.0));
    let hand = Grasp { max_force: 21.5, ..pins(body, Region::Nodes(Arc::new(vec![0]))) };
    scene.grasp(hand, |f| f != 9);
    let phases: Vec<Phase> =
        scene.states(backend)?.iter().skip(1).map(|s| s.grasping.phases[0]).collect();
    let expected: Vec<Phase> = (0..12)
        .map(|f| match f {
            0..=4 => Phase::Closed,
            // v jumps by 0.01 m/s, which takes 2 N on average.
            5..=8 => Phase::Slipped,
            9 => Phase::Open,
            _ => Phase::Slipped,
        })
        .collect();
    ensure(phases == expected, || format!("{phases:?}, expected {expected:?}"))
}

/// Instances with their own schedules behave in a batch as they do alone, and a rollout that is
/// split at any frame resumes bit for bit.
pub(crate) fn grasps_resume_exactly(backend: &dyn Backend) -> Outcome {
    let mut batch = Vec::new();
    let mut ends = Vec::new();
    for seed in 0..4 {
        let scene = grasping(seed, 6);
        let states = scene.states(backend)?;
        let end = scene.end(backend)?;
        ensure(states.last() == Some(&end), || format!("scene {seed} resumes differently"))?;
        let holds = states.iter().any(|s| !s.grasping.holds.is_empty());
        ensure(holds, || format!("scene {seed} holds nothing"))?;
        batch.push(scene.instance(scene.load(backend)?));
        ends.push(end);
    }
    let outputs = Outputs { final_state: true, ..Outputs::NONE };
    let together = backend.roll_out(&batch, &outputs, &CancelToken::default());
    let together: Vec<Option<State>> =
        together.map_err(|e| e.to_string())?.into_iter().map(|r| r.final_state).collect();
    for (seed, (a, b)) in together.iter().zip(&ends).enumerate() {
        ensure(a.as_ref() == Some(b), || format!("scene {seed} differs in a batch"))?;
    }
    Ok(())
}

/// A random network with two hands, of pins that may slip and of springs, that open and close at
/// various times, over the ground and near a collider.
pub(crate) fn grasping(seed: u64, frames: usize) -> Scene {
    let options = RandomOptions { ground: true, contact: seed == 3, ..RandomOptions::default() };
    let model = random_model(seed, &options);
    let (state, controls) = random_motion(seed, &model, frames);
    let objective = random_objective(seed, &model, frames);
    let mut scene = Scene::around(model, state, controls, frames);
    scene.objective = objective;
    let turn = 0.05 + 0.02 * seed as f64;
    let pinning = scene.body(|f| pose([0.02, 0.03, 0.02 + 0.002 * f as f64], turn * f as f64));
    let pulling = scene.body(|f| pose([0.06, 0.06 - 0.002 * f as f64, 0.05], -turn * f as f64));
    let closes = |offset: usize| move |f: usize| !(f + seed as usize + offset).is_multiple_of(4);
    let max_force = if seed == 1 { 60.0 } else { f32::INFINITY };
    scene.grasp(Grasp { max_force, ..pins(pinning, sphere([0.0; 3], 0.03)) }, closes(0));
    let attachment = Attachment::Spring { stiffness: 500.0, damping: 3.0 };
    let region = Region::Box { low: [-0.03; 3], high: [0.03; 3] };
    scene.grasp(Grasp { attachment, ..pins(pulling, region) }, closes(2));
    if seed == 2 {
        let region = Region::Controls(Arc::new(vec![0, 2]));
        scene.grasp(pins(pulling, region), |f| f < 2);
    }
    scene
}

/// A rod between two clamps that roll against one another is twisted by the same angle, to 1e-4,
/// and stores it; a rollout that resumes there adds to it.
pub(crate) fn a_rolling_clamp_twists_its_rod(backend: &dyn Backend) -> Outcome {
    let mut scene = cable();
    scene.params.twist_stiffness[0] = 0.05;
    scene.params.spring_dashpot.fill(1.0);
    scene.params.drag = 20.0;
    scene.frames = 40;
    scene.last(40);
    let roll = |f: usize| 1.5 * (f.min(30) as f32) / 30.0;
    let still = scene.end(backend)?;
    scene.motion.rolls = (0..=40).flat_map(|f| [0.6 * roll(f), -0.4 * roll(f)]).collect();
    let states = scene.states(backend)?;
    let end = scene.end(backend)?;
    ensure(states.last() == Some(&end), || "it resumes differently".to_owned())?;
    // Without stiffness nothing moves the nodes, so the roll is all that is new.
    scene.params.twist_stiffness[0] = 0.0;
    let rolled = scene.end(backend)?.twists[0];
    let mut unrolled = scene.clone();
    unrolled.motion.rolls.clear();
    let unrolled = unrolled.end(backend)?.twists[0];
    close("twist without torque", f64::from(rolled) - f64::from(unrolled), 1.5, 1e-4)?;
    let turned = f64::from(end.twists[0]);
    ensure(turned > 0.5 && turned < 1.6, || format!("twist with torque: {turned}"))?;
    let way = norm(difference(end.positions[4], still.positions[4]));
    ensure(way > 1e-3, || format!("the torque moves the cable by {way} m"))?;
    Ok(())
}
