//! Forces by what surrounds an object: weights at rest, and the balance of momentum.

use std::sync::Arc;

use bendtwin_core::Point;
use bendtwin_engine::{
    Backend,
    backend::Forces,
    model::State,
    world::{Attachment, Collider, Grasp, IDENTITY, Region},
};

use crate::{
    expect::{Outcome, close, ensure},
    physics::grasps::{grasping, pins},
    scene::{Scene, cuboid, pose},
};

const G: f64 = 9.81;

fn wide(p: Point) -> [f64; 3] {
    p.map(f64::from)
}

fn sum(points: &[Point]) -> [f64; 3] {
    points.iter().fold([0.0; 3], |sum, p| [0, 1, 2].map(|c| sum[c] + f64::from(p[c])))
}

fn force_of(wrench: &[f32; 6]) -> [f64; 3] {
    [0, 1, 2].map(|c| f64::from(wrench[c]))
}

/// A chain of four nodes that came to rest.
fn chain() -> Scene {
    let points: Vec<Point> = (0..4).map(|i| [0.0, 0.0, 0.3 - 0.05 * i as f32]).collect();
    let mut scene = Scene::of(&points);
    scene.graph.masses = vec![1.0, 2.0, 0.5, 1.5];
    scene.environment.gravity = [0.0, 0.0, -G as f32];
    (1..4).for_each(|i| scene.spring([i - 1, i], 500.0, 3.0));
    scene.params.drag = 10.0;
    scene.last(300);
    scene
}

/// A chain hangs with its whole weight on its control point, by a pin, by a spring, and in a grasp of
/// either kind: to 0.6 %, as drag takes 0.5 % of what a substep adds. A grasp's torque is weight times arm.
pub(crate) fn a_chain_hangs_by_its_weight(backend: &dyn Backend) -> Outcome {
    let weight = 5.0 * G;
    let last = |f: &[Point]| wide(f[f.len() - 1]);
    let mut pinned = chain();
    pinned.fix(0);
    pinned.last(300);
    close("by a pin", last(&pinned.forces(backend)?.controls)[2], weight, 6e-3 * weight)?;
    let mut sprung = chain();
    let control = sprung.control([0.0, 0.0, 0.35]);
    sprung.spring([0, control], 500.0, 3.0);
    sprung.last(300);
    close("by a spring", last(&sprung.forces(backend)?.controls)[2], weight, 6e-3 * weight)?;
    let spring = Attachment::Spring { stiffness: 2e3, damping: 1.0 };
    for attachment in [Attachment::Pin, spring] {
        let mut held = chain();
        let body = held.body(|_| pose([0.02, 0.0, 0.3], 0.0));
        held.grasp(Grasp { attachment, ..pins(body, Region::Nodes(Arc::new(vec![0]))) }, |_| true);
        let forces = held.forces(backend)?;
        let Some(wrench) = forces.grasps.last() else { return Err("no frames".into()) };
        let [_, _, force, _, moment, _] = wrench.map(f64::from);
        close("by a grasp", force, weight, 6e-3 * weight)?;
        // r = (-2 cm, 0, z): r x f has y = -r_x f_z.
        close("torque", moment, 0.02 * weight, 6e-3 * 0.02 * weight)?;
    }
    Ok(())
}

/// The ground and a collider carry what lies on them: weight and friction to 1 %.
pub(crate) fn contact_carries_the_weight(backend: &dyn Backend) -> Outcome {
    let mut scene = Scene::of(&[[0.0; 3], [0.5, 0.0, 0.1]]);
    scene.graph.masses = vec![2.0, 3.0];
    scene.environment.gravity = [1.0, 0.0, -G as f32];
    scene.ground([0.0, 0.0, 1.0], 0.0, 0.0, 0.5);
    scene.last(30);
    let shape = cuboid([1.0, 1.0, 0.1]);
    let body = scene.body(|_| pose([0.5, 0.0, 0.0], 0.0));
    scene.world.colliders.push(Collider {
        body: Some(body),
        shape,
        friction: 0.5,
        restitution: 0.0,
    });
    scene.initial.positions[0] = [-2.0, 0.0, 0.0];
    let forces = scene.forces(backend)?;
    let (Some(ground), Some(collider)) = (forces.ground.last(), forces.colliders.last()) else {
        return Err("no frames".into());
    };
    close("the ground's", f64::from(ground[2]), 2.0 * G, 0.02 * G)?;
    close("its friction", f64::from(ground[0]), -2.0, 0.02)?;
    close("the collider's", f64::from(collider[2]), 3.0 * G, 0.03 * G)?;
    close("its friction", f64::from(collider[0]), -3.0, 0.03)
}

/// In every frame, the change of the object's momentum equals the impulse of all forces, gravity
/// included, for every kind of hold and contact: to 1e-3 of the largest. Without drag, and without
/// contact between nodes, whose impulses are internal.
pub(crate) fn forces_balance_momentum(backend: &dyn Backend) -> Outcome {
    for (seed, smoothing_m) in [(0, 0.0), (1, 0.0), (2, 0.0), (2, 2e-3)] {
        let mut scene = grasping(seed, 8);
        scene.params.drag = 0.0;
        scene.world.smoothing_m = smoothing_m;
        let shape = cuboid([0.03, 0.03, 0.01]);
        let body = scene.body(|f| pose([0.05, 0.05, 0.12 - 0.005 * f as f64], 0.02 * f as f64));
        let collider = Collider { body: Some(body), shape, friction: 0.4, restitution: 0.1 };
        scene.world.colliders.push(collider);
        balances(backend, &scene).map_err(|e| format!("seed {seed}, {smoothing_m} m: {e}"))?;
    }
    Ok(())
}

fn balances(backend: &dyn Backend, scene: &Scene) -> Outcome {
    let states = scene.states(backend)?;
    let forces = scene.forces(backend)?;
    let mass: f64 = scene.graph.masses.iter().map(|&m| f64::from(m)).sum();
    let momentum = |s: &State| {
        let parts = s.velocities.iter().zip(&scene.graph.masses);
        parts.fold([0.0; 3], |sum, (v, &m)| {
            [0, 1, 2].map(|c| sum[c] + f64::from(m) * f64::from(v[c]))
        })
    };
    let frame_s = scene.timing.frame_s();
    let mut total = 0.0_f64;
    for f in 0..scene.frames {
        let (before, after) = (momentum(&states[f]), momentum(&states[f + 1]));
        let by = of_frame(&forces, f, scene);
        for c in 0..3 {
            let gravity = mass * f64::from(scene.environment.gravity[c]);
            let size: f64 = by.iter().map(|f| f[c].abs()).sum::<f64>() + gravity.abs();
            let expected = (by.iter().map(|f| f[c]).sum::<f64>() + gravity) * frame_s;
            let what = format!("change of momentum {c} in frame {f}");
            close(&what, after[c] - before[c], expected, 1e-3 * size * frame_s + 1e-4)?;
            total += by.iter().map(|f| f[c].abs()).sum::<f64>();
        }
    }
    ensure(total > 10.0, || format!("forces of {total} N in all: nothing acts"))
}

/// Every force of a frame once: a grasp of control points is these.
fn of_frame(forces: &Forces, f: usize, scene: &Scene) -> Vec<[f64; 3]> {
    let (c, g, k) =
        (scene.graph.control_count(), scene.world.grasps.len(), scene.world.colliders.len());
    let grasps = forces.grasps[f * g..(f + 1) * g].iter().zip(&scene.world.grasps);
    let own = grasps.filter(|(_, g)| !matches!(g.region, Region::Controls(_)));
    let mut all = vec![sum(&forces.controls[f * c..(f + 1) * c]), wide(forces.ground[f])];
    all.extend(own.map(|(wrench, _)| force_of(wrench)));
    all.extend(forces.colliders[f * k..(f + 1) * k].iter().map(force_of));
    all
}

/// A grasp of control points exerts what these exert, and asking for forces changes no bit of the
/// motion.
pub(crate) fn measuring_changes_nothing(backend: &dyn Backend) -> Outcome {
    for seed in 0..3 {
        let mut scene = grasping(seed, 5);
        if seed == 0 {
            scene.world = Default::default();
            scene.motion = Default::default();
        }
        let plain = scene.end(backend)?;
        let outputs = bendtwin_engine::backend::Outputs {
            forces: true,
            final_state: true,
            ..bendtwin_engine::backend::Outputs::NONE
        };
        let measured = scene.roll_out_raw(backend, &outputs)?;
        ensure(measured.final_state.as_ref() == Some(&plain), || {
            format!("seed {seed}: measuring forces changes the motion")
        })?;
    }
    let mut scene = chain();
    scene.fix(0);
    let control = scene.control([0.0, 0.05, 0.25]);
    scene.spring([1, control], 100.0, 1.0);
    scene.last(5);
    let body = scene.body(|_| IDENTITY);
    scene.grasp(pins(body, Region::Controls(Arc::new(vec![0, 1]))), |_| true);
    let forces = scene.forces(backend)?;
    for (f, wrench) in forces.grasps.iter().enumerate() {
        let of = sum(&forces.controls[2 * f..2 * f + 2]);
        for (found, expected) in force_of(wrench).into_iter().zip(of) {
            close("force of the hand", found, expected, 1e-4 * (1.0 + expected.abs()))?;
        }
    }
    Ok(())
}
