//! Gradients through smooth contact: with the ground, with colliders of every shape that stand, move
//! and turn, and by the forces that they exert.

use std::sync::Arc;

use bendtwin_engine::{
    Backend, PointLoss, PointSet, Term,
    objective::{ForceBy, WeightedTerm},
    world::{Collider, Face, Region, Shape},
};

use crate::{
    differences::{Check, matches_differences},
    expect::{Outcome, ensure},
    physics::grasps::pins,
    random::{RandomOptions, random_model, random_motion, world::shifted},
    scene::{Scene, cuboid, difference, dot, pose},
};

/// Frames of every scene.
const FRAMES: usize = 4;
/// Weight of squared forces, such that they count about as much as distances.
const FORCE_WEIGHT: f32 = 1e-7;

/// A random network in motion, in a layer of 4 mm, with tracks of all its nodes to one side. The
/// ground, if there is one, is at the height of the lowest third of the nodes.
fn scene(seed: u64, ground: bool) -> Scene {
    let options = RandomOptions { ground, ..RandomOptions::default() };
    let mut model = random_model(seed, &options);
    if let Some(plane) = &mut model.environment.ground {
        let up = plane.normal.map(f64::from);
        let rest = model.graph.rest_positions.iter();
        let mut heights: Vec<f64> = rest.map(|p| dot(p.map(f64::from), up)).collect();
        heights.sort_by(f64::total_cmp);
        plane.offset_m = heights[heights.len() / 3] as f32;
    }
    let (mut state, controls) = random_motion(seed, &model, FRAMES);
    state.velocities.iter_mut().for_each(|v| v[0] += 0.3);
    let mut scene = Scene::around(model, state, controls, FRAMES);
    scene.world.smoothing_m = 4e-3;
    let targets = scene.graph.rest_positions.iter().map(|p| [p[0] + 0.04, p[1] - 0.02, p[2]]);
    let term = Term::Track {
        of: PointSet::Nodes,
        points: (0..scene.graph.node_count() as u32).collect(),
        targets: targets.collect(),
        loss: PointLoss::SquaredDistance,
    };
    scene.objective.groups = vec!["track".into()];
    scene.objective.terms =
        Arc::new(vec![WeightedTerm { frame: FRAMES, weight: 1.0, group: 0, term }]);
    scene
}

/// Adds squared forces of these in every frame to the objective.
fn count_forces(scene: &mut Scene, by: &[ForceBy]) {
    let terms = Arc::make_mut(&mut scene.objective.terms);
    let forces = (1..=FRAMES).flat_map(|frame| {
        by.iter().map(move |&by| WeightedTerm {
            frame,
            weight: FORCE_WEIGHT,
            group: 0,
            term: Term::Force { by, limit: 1.0 },
        })
    });
    terms.extend(forces);
    terms.sort_by_key(|t| t.frame);
}

/// A wedge with five faces, about 4 cm in size.
fn wedge() -> Shape {
    let face = |normal, offset_m| Face { normal, offset_m };
    let faces = [
        face([0.0, 0.0, -1.0], 0.02),
        face([0.6, 0.0, 0.8], 0.015),
        face([-0.6, 0.0, 0.8], 0.015),
        face([0.0, 1.0, 0.0], 0.025),
        face([0.0, -1.0, 0.0], 0.025),
    ];
    Shape::Convex(Arc::new(faces.to_vec()))
}

/// A sphere, a capsule, a box and a wedge, one of them fixed, in whose layers nodes start.
fn with_colliders(seed: u64) -> Scene {
    let mut scene = scene(seed, false);
    // Slow enough not to come across edges, where normals jump.
    scene.initial.velocities.iter_mut().flatten().for_each(|v| *v *= 0.2);
    let sphere = Shape::Capsule { from: [0.0; 3], to: [0.0; 3], radius_m: 0.012 };
    let capsule = Shape::Capsule { from: [0.0; 3], to: [0.02, 0.01, 0.0], radius_m: 0.01 };
    // Each with a point of it that is 1 mm deep.
    let shapes = [
        (sphere, [0.0, 0.0, 0.011]),
        (capsule, [0.01, 0.005, 0.009]),
        (cuboid([0.012, 0.02, 0.01]), [0.003, 0.004, 0.009]),
        (wedge(), [0.01, 0.0, 0.01]),
    ];
    for (k, (shape, [x, y, z])) in shapes.into_iter().enumerate() {
        // Around these no node comes to an edge of the box or the wedge: the normal jumps there, so
        // that differences are of two faces and no derivative exists.
        let node = scene.initial.positions[5 * k + 1].map(f64::from);
        let is_fixed = k == seed as usize % 4;
        let turn = if is_fixed { 0.0 } else { 0.3 * k as f64 + seed as f64 };
        let (s, c) = turn.sin_cos();
        let at = [node[0] - c * x + s * y, node[1] - s * x - c * y, node[2] - z];
        let body = (!is_fixed).then(|| {
            scene.body(|f| {
                let t = f as f64;
                pose([at[0] + 5e-4 * t, at[1] - 2e-4 * t, at[2] + 2e-4 * t], turn + 0.02 * t)
            })
        });
        let shape = if is_fixed { shifted(&shape, at.map(|x| x as f32)) } else { shape };
        scene.world.colliders.push(Collider { body, shape, friction: 0.5, restitution: 0.2 });
    }
    scene
}

/// Over the ground, on which a third of the nodes lie and slide: to 1 %.
pub(crate) fn gradients_through_smooth_ground(backend: &dyn Backend) -> Outcome {
    for seed in 0..3 {
        let mut scene = scene(seed, true);
        let touch = scene.forces(backend)?.ground;
        ensure(touch.iter().all(|f| f[2] > 0.0), || "the ground carries nothing".into())?;
        if seed > 0 {
            count_forces(&mut scene, &[ForceBy::Ground]);
        }
        let must_matter = &[
            "ground friction",
            "ground restitution",
            "initial positions",
            "initial velocities",
            "controls",
            "spring stiffness",
        ];
        matches_differences(backend, &scene, &Check { seed, tolerance: 1e-2, must_matter })?;
    }
    Ok(())
}

/// Among colliders of every shape, each of which is the fixed one once, with friction, and by the
/// forces that they exert: to 1 %.
pub(crate) fn gradients_through_smooth_colliders(backend: &dyn Backend) -> Outcome {
    for seed in 0..4 {
        let mut scene = with_colliders(seed);
        let forces = scene.forces(backend)?.colliders;
        for k in 0..4 {
            let pushes = forces.iter().skip(k).step_by(4).any(|f| f.iter().any(|x| *x != 0.0));
            ensure(pushes, || format!("seed {seed}: collider {k} touches nothing"))?;
        }
        if seed > 0 {
            let by = [0, 1, 2, 3].map(ForceBy::Collider);
            count_forces(&mut scene, &by);
        }
        let must_matter = &["poses", "initial positions", "initial velocities", "controls"];
        matches_differences(backend, &scene, &Check { seed, tolerance: 1e-2, must_matter })?;
    }
    Ok(())
}

/// A hand that carries nodes over the ground and past its own collider, by the poses of its body
/// and by all forces: to 1 %.
pub(crate) fn gradients_of_a_hand_over_the_ground(backend: &dyn Backend) -> Outcome {
    for seed in 0..2 {
        let mut scene = scene(seed, true);
        let node = scene.graph.node_count() - 1;
        let at = scene.initial.positions[node].map(f64::from);
        let body = scene.body(|f| {
            let t = f as f64;
            pose([at[0] + 0.003 * t, at[1], at[2] + 0.001 * t], 0.05 * t)
        });
        scene.grasp(pins(body, Region::Nodes(Arc::new(vec![node as u32]))), |_| true);
        let near = |i: &usize| {
            let apart = difference(scene.initial.positions[*i], scene.initial.positions[node]);
            dot(apart, apart)
        };
        let next = (0..node).min_by(|a, b| near(a).total_cmp(&near(b))).unwrap_or(0);
        let towards = difference(scene.initial.positions[next], scene.initial.positions[node]);
        // The next node starts on its surface.
        let center = [towards[0], towards[1], towards[2] + 0.006].map(|x| x as f32);
        let shape = Shape::Capsule { from: center, to: center, radius_m: 0.006 };
        let own = Collider { body: Some(body), shape, friction: 0.5, restitution: 0.0 };
        scene.world.colliders.push(own);
        count_forces(&mut scene, &[ForceBy::Ground, ForceBy::Grasp(0), ForceBy::Collider(0)]);
        let must_matter = &["poses", "initial positions", "initial velocities", "ground friction"];
        matches_differences(backend, &scene, &Check { seed, tolerance: 1e-2, must_matter })?;
    }
    Ok(())
}
