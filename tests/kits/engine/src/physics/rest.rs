//! Contact at rest: nodes that a force presses on the ground, on a collider or on other nodes
//! neither bounce nor creep, with any restitution.

use std::sync::Arc;

use bendtwin_core::{Point, Timing};
use bendtwin_engine::{
    Backend, PointLoss, PointSet, Term,
    model::State,
    objective::WeightedTerm,
    world::{Collider, Face, Shape},
};

use crate::{
    differences::{Check, matches_differences},
    expect::{Outcome, close, ensure},
    scene::{Scene, difference, norm},
};

const G: f64 = 9.81;
const BOUNCY: f32 = 0.8;

/// Support of a scene's nodes.
#[derive(Clone, Copy, Debug)]
enum Under {
    Ground,
    Box,
}

/// A sheet of 16 nodes on a plane through the origin with this slope along x, whose middle is
/// `away` metres up the slope.
fn sheet(under: Under, slope: f64, away: f64, friction: f32) -> Scene {
    let (s, c) = slope.atan().sin_cos();
    let place = |x: f64, y: f64| [x * c, y, x * s].map(|x| x as f32);
    let points: Vec<Point> =
        (0..16).map(|i| place(away + 0.05 * f64::from(i % 4), 0.05 * f64::from(i / 4))).collect();
    let mut scene = Scene::of(&points);
    for i in 0..16_u32 {
        let right = (i % 4 < 3).then_some(i + 1);
        let up = (i < 12).then_some(i + 4);
        right.into_iter().chain(up).for_each(|j| scene.spring([i, j], 200.0, 1.0));
    }
    scene.environment.gravity[2] = -G as f32;
    match under {
        Under::Ground => {
            scene.ground([-s, 0.0, c].map(|x| x as f32), 0.0, BOUNCY, friction);
        }
        Under::Box => {
            let along = |a: [f64; 3], offset_m| Face { normal: a.map(|x| x as f32), offset_m };
            let across = |sign: f64| along([0.0, sign, 0.0], 3.0);
            let ends = |sign: f64| along([sign * c, 0.0, sign * s], 3.0);
            let faces = vec![
                along([-s, 0.0, c], 0.0),
                along([s, 0.0, -c], 1.0),
                ends(1.0),
                ends(-1.0),
                across(1.0),
                across(-1.0),
            ];
            let shape = Shape::Convex(Arc::new(faces));
            let collider = Collider { body: None, shape, friction, restitution: BOUNCY };
            scene.world.colliders.push(collider);
        }
    }
    scene.timing = Timing { fps: 30.0, substeps: 150 };
    scene
}

pub(crate) fn fastest(state: &State) -> f64 {
    state.velocities.iter().map(|v| norm(v.map(f64::from))).fold(0.0, f64::max)
}

pub(crate) fn farthest(from: &[Point], to: &[Point]) -> f64 {
    from.iter().zip(to).map(|(a, b)| norm(difference(*a, *b))).fold(0.0, f64::max)
}

/// Nodes that springs press on the ground or on a box with hundreds of times their weight lie still
/// after a second: below 0.1 mm/s in the state, and without kinetic energy. With the restitution on
/// all of the approach they would leave with e f dt / m, metres per second, in every substep.
pub(crate) fn what_is_pressed_does_not_bounce(backend: &dyn Backend) -> Outcome {
    for under in [Under::Ground, Under::Box] {
        let mut scene = sheet(under, 0.0, 0.0, 0.3);
        for i in 0..16_u32 {
            let [x, y, _] = scene.graph.rest_positions[i as usize];
            let control = scene.control([x, y, -0.06]);
            scene.spring([i, control], 3000.0, 5.0);
            if let Some(rest) = scene.params.rest_lengths_m.last_mut() {
                *rest = 0.02;
            }
        }
        scene.last(30);
        let rollout = scene.roll_out(backend)?;
        let (Some(end), Some(d)) = (rollout.final_state, rollout.diagnostics) else {
            return Err("no final state or no diagnostics came back".into());
        };
        close(&format!("speed on the {under:?}"), fastest(&end), 0.0, 1e-4)?;
        close(&format!("kinetic energy on the {under:?}"), d.kinetic_energy.into(), 0.0, 1e-6)?;
    }
    Ok(())
}

/// A sheet at rest on a slope below the angle of friction stays within 10 µm for twelve seconds, a
/// metre from the origin, where positions are rounded to 60 nm; above that angle it slides.
pub(crate) fn what_rests_does_not_creep(backend: &dyn Backend) -> Outcome {
    for under in [Under::Ground, Under::Box] {
        for slope in [0.151, 0.255] {
            let mut scene = sheet(under, slope, 1.0, 0.3);
            scene.last(30);
            let settled = scene.end(backend)?;
            scene.initial = settled.clone();
            scene.last(360);
            let end = scene.end(backend)?;
            let crept = farthest(&settled.positions, &end.positions);
            close(&format!("creep on the {under:?} with slope {slope}"), crept, 0.0, 1e-5)?;
        }
        let mut scene = sheet(under, 0.4, 1.0, 0.3);
        scene.last(30);
        let end = scene.end(backend)?;
        let way = farthest(&scene.initial.positions, &end.positions);
        let (s, c) = 0.4_f64.atan().sin_cos();
        let expected = 0.5 * G * (s - 0.3 * c);
        close(&format!("slide on the {under:?}"), way, expected, 0.02 * expected)?;
    }
    Ok(())
}

/// Four nodes in the hollows of a bed of other nodes lie still: they sink by less than 10 µm in
/// three seconds, and are no faster than 1 mm/s. A mean of four impulses stops a fall only in part,
/// so that without a push they would sink by g dt, 2 mm/s, and more.
pub(crate) fn what_lies_on_nodes_does_not_sink(backend: &dyn Backend) -> Outcome {
    let bed = (0..16).map(|i| [0.02 * (i % 4) as f32, 0.02 * (i / 4) as f32, 0.0]);
    let top = (0..4).map(|i| [0.02 * (i % 2) as f32 + 0.01, 0.02 * (i / 2) as f32 + 0.01, 0.015]);
    let points: Vec<Point> = bed.chain(top).collect();
    let mut scene = Scene::of(&points);
    (0..16).for_each(|i| scene.fix(i));
    for [a, b] in [[16, 17], [17, 19], [19, 18], [18, 16], [16, 19], [17, 18]] {
        scene.spring([a, b], 50.0, 0.2);
    }
    scene.graph.object_ids = (0..20).map(|i| u32::from(i >= 16)).collect();
    scene.params.contact.between_objects = true;
    scene.params.contact.collision_distance_m = 0.02;
    scene.params.contact.object_restitution = BOUNCY;
    scene.params.contact.object_friction = 0.3;
    scene.environment.gravity[2] = -G as f32;
    scene.timing = Timing { fps: 30.0, substeps: 150 };
    scene.last(30);
    let settled = scene.end(backend)?;
    scene.initial = settled.clone();
    scene.last(90);
    let end = scene.end(backend)?;
    close("sinking", farthest(&settled.positions, &end.positions), 0.0, 1e-5)?;
    close("speed", fastest(&end), 0.0, 1e-3)?;
    let height = f64::from(end.positions[16][2]);
    ensure(height > 0.0139, || format!("a node sank to {height} m"))
}

/// Through contact that lasts: a sheet slides down a slope with much restitution, pressed on it by
/// its weight alone, so far below the ground that no difference takes a node out. To 1 %.
pub(crate) fn gradients_through_resting_contact(backend: &dyn Backend) -> Outcome {
    let mut scene = sheet(Under::Ground, 0.3, 0.0, 0.1);
    scene.timing = Timing { fps: 100.0, substeps: 12 };
    let (s, c) = 0.3_f32.atan().sin_cos();
    for (i, v) in scene.initial.velocities.iter_mut().enumerate() {
        *v = [0.4 * c, 0.05 * (i % 3) as f32, 0.4 * s];
    }
    for x in &mut scene.initial.positions {
        *x = [x[0] + 5e-3 * s, x[1], x[2] - 5e-3 * c];
    }
    scene.graph.rest_positions.clone_from(&scene.initial.positions);
    scene.params.rest_lengths_m.iter_mut().for_each(|l| *l *= 0.97);
    scene.last(3);
    let targets = scene.graph.rest_positions.iter().map(|p| [p[0] + 0.08, p[1], p[2] + 0.05]);
    let track = Term::Track {
        of: PointSet::Nodes,
        points: (0..16).collect(),
        targets: targets.collect(),
        loss: PointLoss::SquaredDistance,
    };
    scene.objective.groups = vec!["track".into()];
    scene.objective.terms =
        Arc::new(vec![WeightedTerm { frame: 3, weight: 1.0, group: 0, term: track }]);
    let must_matter = &["ground friction", "initial velocities", "spring stiffness"];
    matches_differences(backend, &scene, &Check { seed: 0, tolerance: 1e-2, must_matter })
}
