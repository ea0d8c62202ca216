//! Colliders: rest, friction, restitution, normals of shapes, and walls that move.

use std::f64::consts::TAU;

use bendtwin_core::{Point, Timing};
use bendtwin_engine::{
    Backend,
    world::{Collider, Shape},
};

use crate::{
    expect::{Outcome, close, ensure},
    scene::{Scene, cuboid, difference, norm, pose},
};

const G: f64 = 9.81;

fn collider(body: Option<u32>, shape: Shape, friction: f32, restitution: f32) -> Collider {
    Collider { body, shape, friction, restitution }
}

/// A node dropped on the top of a box stays there, within 0.1 mm, and one beside it falls past.
pub(crate) fn a_node_rests_on_a_box(backend: &dyn Backend) -> Outcome {
    let mut scene = Scene::of(&[[0.02, 0.03, 0.06], [0.2, 0.0, 0.06]]);
    scene.environment.gravity = [0.0, 0.0, -G as f32];
    scene.last(60);
    scene.world.colliders.push(collider(None, cuboid([0.1, 0.1, 0.05]), 0.5, 0.0));
    let end = scene.end(backend)?;
    close("height on the box", f64::from(end.positions[0][2]), 0.05, 1e-4)?;
    let fallen = 0.06 - 0.5 * G * 0.36;
    close("height beside the box", f64::from(end.positions[1][2]), fallen, 0.01)
}

/// A node on the tilted top of a box is held by friction above the slope's tangent, and below it
/// slides with g (sin - mu cos): to 1 %.
pub(crate) fn friction_on_an_inclined_box(backend: &dyn Backend) -> Outcome {
    let angle = 0.4_f64;
    let slide = |mu: f64| -> Result<f64, String> {
        let (s, c) = angle.sin_cos();
        let mut scene = Scene::of(&[[0.05 * s as f32, 0.0, 0.05 * c as f32]]);
        scene.environment.gravity = [0.0, 0.0, -G as f32];
        scene.timing = Timing { fps: 100.0, substeps: 100 };
        scene.last(30);
        let rows = [[c, 0.0, s, 0.0], [0.0, 1.0, 0.0, 0.0], [-s, 0.0, c, 0.0]];
        let body = scene.body(|_| rows.map(|row| row.map(|x| x as f32)));
        scene.world.colliders.push(collider(Some(body), cuboid([2.0, 1.0, 0.05]), mu as f32, 0.0));
        let end = scene.end(backend)?;
        let way = norm(difference(end.positions[0], scene.initial.positions[0]));
        Ok(way)
    };
    close("way with much friction", slide(0.5)?, 0.0, 2e-4)?;
    let mu = 0.2;
    let expected = 0.5 * G * (angle.sin() - mu * angle.cos()) * 0.3 * 0.3;
    close("way with little friction", slide(mu)?, expected, 0.01 * expected)
}

/// A tray that moves sideways carries a node along: immediately with enough friction, with an
/// acceleration of mu g if friction is low. To 2 %.
pub(crate) fn a_moving_tray_carries_by_friction(backend: &dyn Backend) -> Outcome {
    let carried = |mu: f64, speed: f64| -> Result<f64, String> {
        let mut scene = Scene::of(&[[0.0, 0.0, 0.05]]);
        scene.environment.gravity = [0.0, 0.0, -G as f32];
        scene.timing = Timing { fps: 100.0, substeps: 100 };
        scene.last(20);
        let body = scene.body(|f| pose([speed * 0.01 * f as f64, 0.0, 0.0], 0.0));
        scene.world.colliders.push(collider(Some(body), cuboid([0.5, 0.5, 0.05]), mu as f32, 0.0));
        Ok(f64::from(scene.end(backend)?.positions[0][0]))
    };
    close("way on a rough tray", carried(2.0, 0.1)?, 0.02, 4e-4)?;
    let expected = 0.5 * 0.1 * G * 0.04;
    close("way on a smooth tray", carried(0.1, 1.0)?, expected, 0.02 * expected)
}

/// A wall that moves with w hits a resting node: it leaves with (1 + e) w, to 0.1 %, and the forces
/// say so.
pub(crate) fn a_moving_wall_gives_momentum(backend: &dyn Backend) -> Outcome {
    for e in [0.0, 0.6] {
        let mut scene = Scene::of(&[[0.12, 0.01, 0.0]]);
        scene.graph.masses[0] = 3.0;
        scene.last(10);
        let speed = 0.5;
        let body = scene.body(|f| pose([0.005 * f as f64, 0.0, 0.0], 0.0));
        scene.world.colliders.push(collider(Some(body), cuboid([0.1, 0.1, 0.1]), 0.0, e));
        let end = scene.end(backend)?;
        let expected = speed * (1.0 + f64::from(e));
        close("speed after the hit", f64::from(end.velocities[0][0]), expected, 1e-3 * expected)?;
        let forces = scene.forces(backend)?;
        let impulse: f64 = forces.colliders.iter().map(|f| f64::from(f[0]) * 0.01).sum();
        close("impulse", impulse, 3.0 * expected, 3e-3 * expected)?;
        // About the body's origin: the impulse has an arm of 1 cm along y.
        let moment: f64 = forces.colliders.iter().map(|f| f64::from(f[5]) * 0.01).sum();
        close("moment", moment, -0.01 * 3.0 * expected, 1e-3)?;
    }
    Ok(())
}

/// A node that flies at a capsule without friction is reflected at its true normal, on the cylinder
/// and at its ends: angles to 0.01 rad (a substep of 5 mm at 1 m/s ends up to 0.05 mm off).
pub(crate) fn capsules_reflect_along_their_normals(backend: &dyn Backend) -> Outcome {
    let shape = Shape::Capsule { from: [-0.1, 0.0, 0.0], to: [0.1, 0.0, 0.0], radius_m: 0.05 };
    for (across, along, expected_along) in [(0.02, 0.03, 0.0), (0.02, 0.12, 0.02), (0.0, 0.0, 0.0)]
    {
        let start: Point = [along, across, 0.08];
        let mut scene = Scene::of(&[start]);
        scene.timing.substeps = 200;
        scene.initial.velocities[0] = [0.0, 0.0, -1.0];
        scene.last(6);
        scene.world.colliders.push(collider(None, shape.clone(), 0.0, 1.0));
        let v = scene.end(backend)?.velocities[0].map(f64::from);
        let (y, x) = (f64::from(across), expected_along);
        let n = [x / 0.05, y / 0.05, (0.0025 - x * x - y * y).sqrt() / 0.05];
        for c in 0..3 {
            let expected = 2.0 * n[2] * n[c] - if c == 2 { 1.0 } else { 0.0 };
            close(&format!("velocity {c} from {start:?}"), v[c], expected, 0.02)?;
        }
    }
    Ok(())
}

/// A node that a body overtakes is pushed out within some hundredths of a second, and a prescribed
/// node inside a collider stays where it is held.
pub(crate) fn colliders_push_out(backend: &dyn Backend) -> Outcome {
    let mut scene = Scene::of(&[[0.045, 0.0, 0.0], [0.0, 0.0, 0.02]]);
    scene.fix(1);
    scene.last(20);
    let body = scene.body(|f| pose([0.0, 0.0, 0.0], TAU / 40.0 * f as f64));
    let sphere = Shape::Capsule { from: [0.0; 3], to: [0.0; 3], radius_m: 0.05 };
    scene.world.colliders.push(collider(Some(body), sphere, 0.0, 0.0));
    let rollout = scene.roll_out(backend)?;
    let at = |f: usize, i: usize| norm(difference(rollout.positions[2 * f + i], [0.0; 3]));
    ensure(at(6, 0) > 0.0495, || format!("still {} m from the centre", at(6, 0)))?;
    ensure(at(20, 0) < 0.2, || format!("thrown to {} m", at(20, 0)))?;
    close("the fixed node", at(20, 1), 0.02, 1e-7)
}
