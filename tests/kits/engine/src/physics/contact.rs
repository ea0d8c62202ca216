//! Contact between nodes: the impulse formula, its mean over pairs, self contact.

use bendtwin_engine::Backend;

use crate::{
    expect::{Outcome, close, ensure},
    scene::{Scene, cross, difference, dot, norm},
};

const DISTANCE: f32 = 0.02;

/// Free nodes of different objects, in contact from the first substep on.
fn colliding(positions: &[[f32; 3]], velocities: &[[f32; 3]], objects: &[u32]) -> Scene {
    let mut scene = Scene::of(positions);
    scene.initial.velocities = velocities.to_vec();
    scene.graph.object_ids = objects.to_vec();
    scene.params.contact.between_objects = true;
    scene.params.contact.collision_distance_m = DISTANCE;
    scene.params.contact.object_restitution = 0.7;
    scene.params.contact.object_friction = 0.3;
    scene.last(1);
    scene
}

fn minus(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

/// Impulse on the first node [kg m/s], from PHYSICS: J = J_n + J_t of the pair.
fn impulse(scene: &Scene, one: usize, two: usize) -> [f64; 3] {
    let (e, mu) = (0.7, 0.3);
    let apart = difference(scene.initial.positions[two], scene.initial.positions[one]);
    let n = apart.map(|x| x / norm(apart));
    let v = difference(scene.initial.velocities[two], scene.initial.velocities[one]);
    let vn = dot(v, n);
    let tangential = minus(v, n.map(|n| n * vn));
    let inverse =
        1.0 / f64::from(scene.graph.masses[one]) + 1.0 / f64::from(scene.graph.masses[two]);
    let speed = norm(tangential);
    let kept = if speed > 0.0 { (1.0 - mu * (1.0 + e) * vn.abs() / speed).max(0.0) } else { 0.0 };
    let along = |i: usize| (-(1.0 + e) * vn * n[i] + (kept - 1.0) * tangential[i]) / inverse;
    [along(0), along(1), along(2)]
}

/// Two nodes of unequal masses collide head on, sliding (friction limited by Coulomb's law), and
/// sticking (friction takes the whole tangential velocity). Velocities after it to 10 µm/s of 1
/// m/s, total momentum to the same; nodes that separate are left alone.
pub(crate) fn colliding_objects_exchange_momentum(backend: &dyn Backend) -> Outcome {
    for sideways in [0.0, 0.9, 0.05] {
        let mut scene = colliding(
            &[[0.0; 3], [0.015, 0.002, 0.0]],
            &[[0.6, 0.0, 0.0], [-0.4, sideways, 0.0]],
            &[0, 1],
        );
        scene.graph.masses[1] = 2.5;
        let end = scene.end(backend)?;
        let j = impulse(&scene, 0, 1);
        for (node, sign) in [(0, -1.0), (1, 1.0)] {
            let m = f64::from(scene.graph.masses[node]);
            for (axis, j) in j.iter().enumerate() {
                let expected = f64::from(scene.initial.velocities[node][axis]) + sign * j / m;
                let what = format!("velocity {axis} of node {node}, {sideways} m/s sideways");
                close(&what, f64::from(end.velocities[node][axis]), expected, 1e-5)?;
            }
        }
        // Separating now: another frame changes nothing.
        scene.initial = end.clone();
        let later = scene.end(backend)?;
        ensure(later.velocities == end.velocities, || "separating nodes still collide".into())?;
    }
    // One object, and no contact asked for: they pass.
    let velocities = [[0.6, 0.0, 0.0], [-0.4, 0.0, 0.0]];
    let mut scene = colliding(&[[0.0; 3], [0.015, 0.0, 0.0]], &velocities, &[3, 3]);
    ensure(scene.end(backend)?.velocities == velocities, || "nodes of one object collide".into())?;
    scene.graph.object_ids[1] = 4;
    scene.params.contact.between_objects = false;
    ensure(scene.end(backend)?.velocities == velocities, || "contact is on though off".into())
}

/// A node between two others takes the mean of both impulses, each of the others its own.
pub(crate) fn a_node_takes_the_mean_of_its_contacts(backend: &dyn Backend) -> Outcome {
    let scene = colliding(
        &[[0.0; 3], [0.013, 0.011, 0.0], [0.014, -0.01, 0.001]],
        &[[1.0, 0.0, 0.0], [0.0; 3], [-0.2, 0.1, 0.0]],
        &[0, 1, 1],
    );
    let end = scene.end(backend)?;
    let (a, b) = (impulse(&scene, 0, 1), impulse(&scene, 0, 2));
    let kicks = [[0, 1, 2].map(|i| -(a[i] + b[i]) / 2.0), a, b];
    for (node, kick) in kicks.into_iter().enumerate() {
        for (axis, kick) in kick.iter().enumerate() {
            let expected = f64::from(scene.initial.velocities[node][axis]) + kick;
            let got = f64::from(end.velocities[node][axis]);
            close(&format!("velocity {axis} of node {node}"), got, expected, 1e-5)?;
        }
    }
    Ok(())
}

/// Two sheets of one object, 4 cm apart, fly at each other: with self contact no two nodes of
/// them come nearer than 80 % of the collision distance (a substep's motion, and
/// pairs that share a mean, cost the rest); without it they pass through.
pub(crate) fn self_contact_keeps_distance(backend: &dyn Backend) -> Outcome {
    let mut points = Vec::new();
    for z in [0.0, 0.04] {
        points.extend((0..16).map(|i| [0.018 * (i % 4) as f32, 0.018 * (i / 4) as f32, z]));
    }
    let mut scene = Scene::of(&points);
    for sheet in [0, 16] {
        for i in 0..16_u32 {
            for next in [(i % 4 < 3).then_some(i + 1), (i < 12).then_some(i + 4)] {
                next.into_iter().for_each(|k| scene.spring([sheet + i, sheet + k], 50.0, 0.1));
            }
        }
    }
    scene.params.contact.collision_distance_m = DISTANCE;
    scene.initial.velocities[..16].fill([0.0, 0.0, 0.2]);
    scene.initial.velocities[16..].fill([0.0, 0.0, -0.2]);
    scene.last(20);
    for within in [true, false] {
        scene.params.contact.within_object = within;
        let rollout = scene.roll_out(backend)?;
        let gaps = rollout.positions.chunks_exact(32).map(|nodes| {
            let pairs = (0..16).flat_map(|a| (16..32).map(move |b| (a, b)));
            let gaps = pairs.map(|(a, b)| norm(difference(nodes[a], nodes[b])));
            gaps.fold(f64::INFINITY, f64::min)
        });
        let closest = gaps.fold(f64::INFINITY, f64::min);
        let kept = closest > 0.8 * f64::from(DISTANCE);
        ensure(kept == within, || {
            format!("with self contact {within} the sheets come to {closest:.4} m")
        })?;
    }
    Ok(())
}

/// Nodes joined by a spring never collide, however near: the same motion with and without.
/// Neighbours of neighbours do.
pub(crate) fn self_contact_spares_neighbours(backend: &dyn Backend) -> Outcome {
    let mut scene = Scene::of(&[[0.0; 3], [0.01, 0.0, 0.0]]);
    scene.spring([0, 1], 1.0, 0.0);
    scene.initial.velocities = vec![[0.05, 0.0, 0.0], [-0.05, 0.01, 0.0]];
    scene.params.contact.collision_distance_m = DISTANCE;
    scene.last(10);
    let without = scene.end(backend)?;
    scene.params.contact.within_object = true;
    ensure(scene.end(backend)? == without, || "neighbours collide".into())?;

    let mut bent = Scene::of(&[[0.0; 3], [0.03, 0.03, 0.0], [0.01, 0.0, 0.0]]);
    bent.spring([0, 1], 1.0, 0.0);
    bent.spring([1, 2], 1.0, 0.0);
    bent.initial.velocities = vec![[0.05, 0.0, 0.0], [0.0; 3], [-0.05, 0.0, 0.0]];
    bent.params.contact.collision_distance_m = DISTANCE;
    bent.params.contact.within_object = true;
    bent.last(1);
    let end = bent.end(backend)?;
    let towards = dot(
        difference(end.velocities[2], end.velocities[0]),
        difference(end.positions[2], end.positions[0]),
    );
    // A head-on hit has no moment either.
    let turn = norm(cross(
        difference(end.velocities[2], end.velocities[0]),
        difference(end.positions[2], end.positions[0]),
    ));
    ensure(towards > 0.0 && turn < 1e-4, || "second neighbours pass through each other".into())
}
