//! Contact of the skin: what lies is borne by its surface, not by its nodes.

use std::sync::Arc;

use bendtwin_core::{Graph, Point, Skin, Timing, geometry::wide, twin::skin::offset_in_frame};
use bendtwin_engine::{
    Backend,
    backend::Outputs,
    model::State,
    world::{Collider, Face, Shape},
};

use crate::{
    differences::{Check, matches_differences},
    expect::{Outcome, close, ensure},
    physics::rest::{farthest, fastest},
    scene::{Scene, cuboid, difference, dot, pose},
};

const G: f64 = 9.81;
/// Depth of the skin around the nodes of a block [m].
const SHELL_M: f32 = 0.008;
/// Points and nodes of a block along an edge.
const POINTS: u32 = 7;
const NODES: u32 = 4;

/// Support of a block.
#[derive(Clone, Copy, Debug)]
enum Under {
    Ground,
    Box,
}

/// A block of 4 x 4 x 2 nodes whose skin is 8 mm around them, above a plane through the origin with
/// this slope along x: the skin's lowest points 1 mm above it.
fn block(under: Under, slope: f64) -> Scene {
    let (s, c) = slope.atan().sin_cos();
    let place = |x: f32, y: f32, up: f32| -> Point {
        let [x, y, up] = [x, y, up].map(f64::from);
        [x * c - up * s, y, x * s + up * c].map(|x| x as f32)
    };
    let spacing = 0.03_f32;
    let node = |i: u32| {
        let [x, y, z] = [i % NODES, i / NODES % NODES, i / (NODES * NODES)];
        place(spacing * x as f32, spacing * y as f32, 0.001 + SHELL_M + spacing * z as f32)
    };
    let points: Vec<Point> = (0..2 * NODES * NODES).map(node).collect();
    let mut scene = Scene::of(&points);
    for j in 0..points.len() as u32 {
        for i in 0..j {
            let between = difference(points[i as usize], points[j as usize]);
            if dot(between, between).sqrt() < 1.8 * f64::from(spacing) {
                scene.spring([i, j], 300.0, 1.5);
            }
        }
    }
    // Below each cell a grid of points: the nodes around carry them, those above with weights below
    // zero.
    for i in 0..POINTS * POINTS {
        let [u, v] = [i % POINTS, i / POINTS].map(|k| k as f32 * 3.0 / (POINTS - 1) as f32);
        let [a, b] = [u, v].map(|k| (k as u32).min(NODES - 2));
        let [fu, fv] = [u - a as f32, v - b as f32];
        let below = SHELL_M / spacing;
        let mut weights = Vec::new();
        for (du, dv, w) in [
            (0, 0, (1.0 - fu) * (1.0 - fv)),
            (1, 0, fu * (1.0 - fv)),
            (0, 1, (1.0 - fu) * fv),
            (1, 1, fu * fv),
        ] {
            let lower = (b + dv) * NODES + a + du;
            weights.push((lower, w * (1.0 + below)));
            weights.push((lower + NODES * NODES, -w * below));
        }
        scene.skin.push(Graph::NOT_OBSERVED, &weights, [Skin::NO_FRAME; 3], [0.0; 3]);
    }
    scene.params.contact.skin = true;
    scene.environment.gravity[2] = -G as f32;
    match under {
        Under::Ground => scene.ground([-s, 0.0, c].map(|x| x as f32), 0.0, 0.6, 0.3),
        Under::Box => {
            let along = |a: [f64; 3], offset_m| Face { normal: a.map(|x| x as f32), offset_m };
            let faces = vec![
                along([-s, 0.0, c], 0.0),
                along([s, 0.0, -c], 1.0),
                along([c, 0.0, s], 3.0),
                along([-c, 0.0, -s], 3.0),
                along([0.0, 1.0, 0.0], 3.0),
                along([0.0, -1.0, 0.0], 3.0),
            ];
            let shape = Shape::Convex(Arc::new(faces));
            let collider = Collider { body: None, shape, friction: 0.3, restitution: 0.6 };
            scene.world.colliders.push(collider);
        }
    }
    scene.timing = Timing { fps: 30.0, substeps: 150 };
    scene
}

/// Depth of the deepest skin point below the plane with this slope [m].
fn depth(scene: &Scene, nodes: &[Point], slope: f64) -> f64 {
    let (s, c) = slope.atan().sin_cos();
    let heights = scene.skin.positions(nodes);
    heights.iter().map(|p| -dot(wide(*p), [-s, 0.0, c])).fold(0.0, f64::max)
}

/// The skin of a block that falls on the ground or on a box stays above it to 1 mm, in every frame of
/// two seconds, though nodes that bear little of it fall on; without contact of the skin it would be
/// 8 mm deep.
pub(crate) fn a_skin_does_not_sink(backend: &dyn Backend) -> Outcome {
    for under in [Under::Ground, Under::Box] {
        let mut scene = block(under, 0.0);
        scene.initial.velocities.fill([0.1, 0.0, -0.5]);
        scene.last(60);
        let n = scene.graph.node_count();
        let deepest = |scene: &Scene| -> Result<f64, String> {
            let rollout = scene.roll_out(backend)?;
            let frames = rollout.positions.chunks(n);
            Ok(frames.map(|nodes| depth(scene, nodes, 0.0)).fold(0.0, f64::max))
        };
        close(&format!("depth in the {under:?}"), deepest(&scene)?, 0.0, 1e-3)?;
        scene.params.contact.skin = false;
        let without = deepest(&scene)?;
        ensure(without > 0.9 * f64::from(SHELL_M), || format!("{without} m without it"))?;
    }
    Ok(())
}

/// A block that lies on its skin, level or on a slope below the angle of friction, stays within
/// 10 µm for ten seconds and is slower than 0.1 mm/s; pressed on the ground by springs it also lies
/// still.
pub(crate) fn what_rests_on_its_skin_does_not_creep(backend: &dyn Backend) -> Outcome {
    for (under, slope, pressed) in
        [(Under::Ground, 0.0, true), (Under::Ground, 0.2, false), (Under::Box, 0.2, false)]
    {
        let what = format!("the {under:?} with slope {slope}");
        let mut scene = block(under, slope);
        // So that it comes to rest soon.
        scene.params.drag = 2.0;
        if pressed {
            for i in NODES * NODES..2 * NODES * NODES {
                let [x, y, z] = scene.graph.rest_positions[i as usize];
                let control = scene.control([x, y, z - 0.1]);
                scene.spring([i, control], 100.0, 1.0);
                if let Some(rest) = scene.params.rest_lengths_m.last_mut() {
                    *rest = 0.05;
                }
            }
        }
        scene.last(150);
        let settled = scene.end(backend)?;
        scene.initial = settled.clone();
        scene.last(300);
        let end = scene.end(backend)?;
        close(
            &format!("creep on {what}"),
            farthest(&settled.positions, &end.positions),
            0.0,
            1e-5,
        )?;
        close(&format!("speed on {what}"), fastest(&end), 0.0, 1e-4)?;
        close(&format!("depth in {what}"), depth(&scene, &end.positions, slope), 0.0, 1e-3)?;
    }
    Ok(())
}

/// The ground bears a block that lies on its skin: to 1 % of its weight.
pub(crate) fn the_ground_bears_what_lies_on_its_skin(backend: &dyn Backend) -> Outcome {
    let mut scene = block(Under::Ground, 0.0);
    scene.params.drag = 2.0;
    scene.last(90);
    let forces = scene.forces(backend)?;
    let weight = G * f64::from(2 * NODES * NODES);
    let last = forces.ground.last().copied().unwrap_or_default();
    close("force of the ground", f64::from(last[2]), weight, 0.01 * weight)
}

/// Where the skin is at the nodes, contact of the skin equals that of the nodes, bit for bit.
pub(crate) fn a_skin_at_its_nodes_touches_as_they_do(backend: &dyn Backend) -> Outcome {
    let mut scene = block(Under::Ground, 0.1);
    scene.skin = Skin::of_nodes(&scene.graph);
    scene.last(20);
    let outputs = Outputs { every: 1, final_state: true, ..Outputs::NONE };
    let with = scene.roll_out_raw(backend, &outputs)?;
    scene.params.contact.skin = false;
    let without = scene.roll_out_raw(backend, &outputs)?;
    ensure(with == without, || "the motion is another".into())
}

/// Through impacts of the skin in the middle of the first substep, at points that are carried from
/// elsewhere and in a frame of nodes, on the ground and on a body that moves and turns, by impacts
/// and in a smooth layer, also with a node that a control point holds: to 1 %.
pub(crate) fn gradients_through_skin_contact(backend: &dyn Backend) -> Outcome {
    for (seed, on_body, smoothing_m, held) in [
        (0, false, 0.0, false),
        (1, true, 0.0, false),
        (2, false, 4e-3, false),
        (3, true, 4e-3, false),
        (4, false, 4e-3, true),
        (5, true, 4e-3, true),
    ] {
        let mut scene = falling(on_body);
        if held {
            // It bears a part of both points.
            scene.fix(2);
            scene.last(scene.frames);
        }
        scene.world.smoothing_m = smoothing_m;
        scene.track_all();
        let must_matter: &[&str] = match (on_body, held) {
            (true, false) => {
                &["initial positions", "initial velocities", "spring stiffness", "poses"]
            }
            (true, true) => &[
                "initial positions",
                "initial velocities",
                "spring stiffness",
                "poses",
                "controls",
            ],
            (false, false) => &[
                "initial positions",
                "initial velocities",
                "spring stiffness",
                "ground restitution",
            ],
            (false, true) => &[
                "initial positions",
                "initial velocities",
                "spring stiffness",
                "ground restitution",
                "controls",
            ],
        };
        matches_differences(backend, &scene, &Check { seed, tolerance: 1e-2, must_matter })?;
    }
    Ok(())
}

/// Five nodes of which two bear points of the skin that come down on the ground, or on a body, in the
/// middle of the first substep; the others are far above.
fn falling(on_body: bool) -> Scene {
    let points = [
        [0.0, 0.0, 0.05],
        [0.06, 0.0, 0.09],
        [0.0, 0.06, 0.1],
        [0.07, 0.06, 0.05],
        [0.03, 0.03, 0.12],
    ];
    let mut scene = Scene::of(&points);
    for j in 0..5_u32 {
        (0..j).for_each(|i| scene.spring([i, j], 60.0, 0.5));
    }
    scene.params.rest_lengths_m.iter_mut().for_each(|l| *l *= 0.97);
    scene.params.contact.skin = true;
    scene.params.contact.ground_restitution = 0.7;
    scene.params.contact.ground_friction = 0.2;
    scene.timing = Timing { fps: 100.0, substeps: 10 };
    let speed = 0.6_f32;
    // Where they come to the surface, half a substep from now.
    let gap = 0.5 * speed * scene.dt() as f32;
    let at = |i: u32| wide(points[i as usize]);
    let push = |scene: &mut Scene, weights: &[(u32, f32)], frame: [u32; 3]| {
        let sum = weights.iter().fold([0.0; 3], |sum, &(i, w)| {
            std::array::from_fn(|c| sum[c] + f64::from(w) * at(i)[c])
        });
        let offset = [0.004, -0.003, f64::from(gap) - sum[2]];
        let own = if frame[0] == Skin::NO_FRAME {
            Some(offset)
        } else {
            offset_in_frame(frame.map(at), offset)
        };
        let own = own.unwrap_or_default().map(|x| x as f32);
        scene.skin.push(Graph::NOT_OBSERVED, weights, frame, own);
    };
    push(&mut scene, &[(0, 0.85), (1, 0.1), (2, 0.05)], [Skin::NO_FRAME; 3]);
    push(&mut scene, &[(3, 0.8), (4, 0.25), (2, -0.05)], [3, 1, 4]);
    scene.frames = 3;
    scene.initial = State::rest(&scene.graph);
    for (i, v) in scene.initial.velocities.iter_mut().enumerate() {
        *v = if i % 3 == 0 { [0.5, 0.1, -speed] } else { [0.5, 0.2, -speed] };
    }
    if on_body {
        let body = scene.body(|frame| {
            let f = frame as f64;
            pose([0.002 * f, -0.001 * f, 0.001 * f], 0.02 * f)
        });
        let Shape::Convex(faces) = cuboid([2.0, 2.0, 1.0]) else { return scene };
        let lowered = |f: &Face| Face { offset_m: f.offset_m - f.normal[2], ..*f };
        let shape = Shape::Convex(Arc::new(faces.iter().map(lowered).collect()));
        let collider = Collider { body: Some(body), shape, friction: 0.2, restitution: 0.7 };
        scene.world.colliders.push(collider);
    } else {
        scene.ground([0.0, 0.0, 1.0], 0.0, 0.7, 0.2);
    }
    scene
}
