//! Gradients of whole rollouts, with and without contact, of every term, and cut in time.

use std::sync::Arc;

use bendtwin_core::Point;
use bendtwin_engine::{
    Backend, Objective, PointLoss, PointSet, Term,
    backend::GradientRequest,
    objective::{ForceBy, WeightedTerm},
};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::{
    differences::{Check, REQUEST, kinds, matches_differences},
    expect::{Outcome, close, ensure},
    physics::grasps::grasping,
    physics::twist::{branched_cable, cable},
    random::{RandomOptions, random_model, random_motion, random_objective},
    scene::Scene,
};

/// A random scene with terms of one kind only, tracks by default.
pub(crate) fn tracked(seed: u64, options: &RandomOptions, frames: usize) -> Scene {
    let model = random_model(seed, options);
    let (mut state, controls) = random_motion(seed, &model, frames);
    // A common velocity, or drag and friction would cancel between the nodes.
    state.velocities.iter_mut().for_each(|v| v[0] += 0.5);
    let mut objective = random_objective(seed, &model, frames);
    keep(&mut objective, |t| matches!(t, Term::Track { of: PointSet::Nodes, .. }));
    let mut scene = Scene::around(model, state, controls, frames);
    scene.objective = objective;
    scene
}

pub(crate) fn keep(objective: &mut Objective, wanted: impl Fn(&Term) -> bool) {
    let mut terms = (*objective.terms).clone();
    terms.retain(|t| wanted(&t.term));
    objective.terms = Arc::new(terms);
}

/// Whole rollouts of random networks without contact: to 1 % of the sum of all contributions.
pub(crate) fn gradients_match_finite_differences(backend: &dyn Backend) -> Outcome {
    for seed in 0..4 {
        let scene = tracked(seed, &RandomOptions::default(), 5);
        let check = Check {
            seed,
            tolerance: 1e-2,
            must_matter: &[
                "spring stiffness",
                "spring dashpot",
                "rest length",
                "bend stiffness",
                "bend damping",
                "rest angle",
                "drag",
                "controls",
                "initial positions",
                "initial velocities",
            ],
        };
        matches_differences(backend, &scene, &check)?;
    }
    Ok(())
}

/// A rod that stays perfectly straight, its bending force 0/0 in every substep, yet bends as soon
/// as a node is moved: to 1 %. (By rest angle and damping there is no derivative there: both only
/// have a size, no direction.)
pub(crate) fn gradients_of_a_straight_rod(backend: &dyn Backend) -> Outcome {
    let points: Vec<_> = (0..5).map(|i| [0.1 * i as f32, 0.0, 0.0]).collect();
    let mut scene = Scene::of(&points);
    (0..4).for_each(|i| scene.spring([i, i + 1], 50.0, 0.5));
    (1..4).for_each(|j| scene.triplet([j - 1, j, j + 1], std::f32::consts::PI, 2.0, 0.0));
    scene.fix(0);
    scene.fix(1);
    scene.last(6);
    let targets = vec![[0.2, 0.02, 0.0], [0.29, 0.05, 0.01], [0.37, 0.1, -0.02]];
    scene.track(vec![2, 3, 4], targets);
    let must_matter = &["controls", "initial positions", "initial velocities"];
    matches_differences(backend, &scene, &Check { seed: 0, tolerance: 1e-2, must_matter })
}

/// Through a rod, whose twist remembers the whole rollout, with clamps that move and turn, and with
/// a branch at its end: to 1 %.
pub(crate) fn gradients_of_a_twisting_rod(backend: &dyn Backend) -> Outcome {
    let cases = [(0, 3.0, cable()), (1, -2.0, cable()), (2, 0.7, branched_cable())];
    for (seed, twist, mut scene) in cases {
        scene.params.twist_stiffness[0] = 0.3;
        scene.params.twist_damping[0] = 3e-2;
        scene.params.rest_twists_rad[0] = -0.4;
        scene.params.spring_dashpot.fill(1.0);
        scene.params.bend_damping.fill(1e-3);
        scene.params.rest_angles_rad.fill(2.8);
        scene.params.drag = 1.0;
        scene.initial.twists = vec![twist];
        scene.initial.velocities.fill([0.5, 0.1, 0.0]);
        scene.frames = 12;
        let rest = scene.graph.control_rest.clone();
        let at = |frame: usize, c: usize| {
            let t = 0.1 * frame as f32 + c as f32;
            let by = [0.01 * t, 0.02 * t.sin(), 0.02 * (1.3 * t).cos() - 0.02];
            std::array::from_fn(|k| rest[c][k] + by[k])
        };
        scene.controls = (0..=12)
            .flat_map(|f| (0..rest.len()).map(move |c| (f, c)))
            .map(|(f, c)| at(f, c))
            .collect();
        scene.track_all();
        let must_matter = &[
            "twist stiffness",
            "twist damping",
            "rest twist",
            "initial twists",
            "bend stiffness",
            "controls",
            "initial positions",
            "initial velocities",
        ];
        matches_differences(backend, &scene, &Check { seed, tolerance: 1e-2, must_matter })?;
    }
    Ok(())
}

/// Gradients by the rolls of the clamps of a rod that bends and twists: to 1 %.
pub(crate) fn gradients_of_a_rolling_clamp(backend: &dyn Backend) -> Outcome {
    let mut scene = cable();
    scene.params.twist_stiffness[0] = 0.3;
    scene.params.twist_damping[0] = 3e-2;
    scene.params.spring_dashpot.fill(1.0);
    scene.params.drag = 1.0;
    scene.last(12);
    scene.motion.rolls = (0..=12).flat_map(|f| [0.2 * f as f32, -0.1 * f as f32]).collect();
    scene.track_all();
    let must_matter = &["rolls", "twist stiffness"];
    matches_differences(backend, &scene, &Check { seed: 0, tolerance: 1e-2, must_matter })
}

/// Through hands that close, hold and open, by pins, springs and control points, and by the forces
/// with which they pull: to 1 %.
pub(crate) fn gradients_through_grasps(backend: &dyn Backend) -> Outcome {
    for seed in [0, 2] {
        let whole = in_the_air(seed);
        let states = whole.states(backend)?;
        // From a frame on in which they hold something.
        let mut scene = whole.clone();
        let c = scene.graph.control_count();
        scene.frames -= 1;
        scene.initial = states[1].clone();
        scene.controls.drain(..c);
        scene.motion = whole.motion_of(1, scene.frames);
        let terms = Arc::make_mut(&mut scene.objective.terms);
        terms.retain(|t| t.frame > 1);
        terms.iter_mut().for_each(|t| t.frame -= 1);
        let by = [ForceBy::Controls, ForceBy::Grasp(0), ForceBy::Grasp(1)];
        terms.extend(by.map(|by| WeightedTerm {
            frame: 3,
            weight: 1e-5,
            group: 0,
            term: Term::Force { by, limit: 1.0 },
        }));
        ensure(!scene.initial.grasping.holds.is_empty(), || "nothing is held".into())?;
        let must_matter = &[
            "poses",
            "initial places",
            "initial positions",
            "initial velocities",
            "controls",
            "spring stiffness",
        ];
        matches_differences(backend, &scene, &Check { seed, tolerance: 1e-2, must_matter })?;
    }
    Ok(())
}

/// A scene with hands, without ground, and with tracks only.
fn in_the_air(seed: u64) -> Scene {
    let mut scene = grasping(seed, 5);
    scene.environment.ground = None;
    scene.environment.gravity = [0.0, 0.0, -2.0];
    keep(&mut scene.objective, |t| matches!(t, Term::Track { of: PointSet::Nodes, .. }));
    scene
}

/// Through impacts on the ground in the middle of the first substep, however the variables are
/// moved, sliding and sticking: to 1 %. (An impact that moves to another substep makes the
/// velocity jump by (1 + e) a dt, which no derivative sees and every difference does.)
pub(crate) fn gradients_through_ground_contact(backend: &dyn Backend) -> Outcome {
    for seed in 0..3 {
        let options = RandomOptions { ground: true, pins: 0, ..RandomOptions::default() };
        let mut scene = tracked(seed, &options, 3);
        scene.timing.substeps = 10;
        scene.params.contact.ground_restitution = 0.8;
        // Gravity low, so that nothing comes down again within the three frames.
        scene.environment.gravity = [0.1, 0.0, -1.0];
        let Some(ground) = scene.environment.ground else { return Err("no ground".into()) };
        let up = ground.normal;
        let height =
            |x: &[f32; 3]| x.iter().zip(up).map(|(x, n)| x * n).sum::<f32>() - ground.offset_m;
        let (speed, dt) = (0.6, scene.dt() as f32);
        for (i, x) in scene.initial.positions.iter_mut().enumerate() {
            let v = &mut scene.initial.velocities[i];
            let falls = i % 4 == 0;
            // Some of those that fall slide fast, some so slowly that friction stops them.
            *v = if i % 8 == 0 { [0.02, 0.01, 0.0] } else { [0.6, 0.3, 0.0] };
            let (lift, push) =
                if falls { (0.5 * speed * dt - height(x), -speed) } else { (0.05, 0.2) };
            let along = v.iter().zip(up).map(|(v, n)| v * n).sum::<f32>();
            for axis in 0..3 {
                x[axis] += lift * up[axis];
                v[axis] += (push - along) * up[axis];
            }
        }
        // Moved so far, they take this shape as theirs, but for some strain.
        scene.graph.rest_positions.clone_from(&scene.initial.positions);
        scene.relax();
        scene.params.rest_lengths_m.iter_mut().for_each(|l| *l *= 0.97);
        scene.params.rest_angles_rad.iter_mut().for_each(|a| *a *= 0.95);
        let check = Check {
            seed,
            tolerance: 1e-2,
            must_matter: &[
                "ground restitution",
                "ground friction",
                "initial positions",
                "initial velocities",
                "spring stiffness",
            ],
        };
        matches_differences(backend, &scene, &check)?;
    }
    Ok(())
}

/// Through collisions between objects that happen in the first substep, however the variables are
/// moved: to 1 %. (The substep of a later collision jumps, as its time of impact is not resolved.)
pub(crate) fn gradients_through_object_contact(backend: &dyn Backend) -> Outcome {
    for (seed, sideways) in [(0, 0.05), (1, 0.9), (2, 0.0)] {
        let mut scene = Scene::of(&[[0.0; 3], [0.015, 0.004, 0.002], [0.08, 0.01, 0.0]]);
        scene.graph.object_ids = vec![0, 1, 1];
        scene.graph.masses[1] = 1.7;
        scene.spring([1, 2], 30.0, 0.5);
        scene.params.rest_lengths_m[0] *= 0.97;
        scene.params.contact.between_objects = true;
        scene.params.drag = 0.3;
        scene.initial.velocities = vec![[0.5, 0.1, 0.0], [-0.4, sideways, 0.1], [0.0, 0.1, 0.0]];
        scene.last(3);
        let targets = vec![[0.05, 0.0, 0.08], [0.0, 0.0, -0.09], [0.1, 0.1, 0.0]];
        scene.track(vec![0, 1, 2], targets);
        let check = Check {
            seed,
            tolerance: 1e-2,
            must_matter: &["object restitution", "initial positions", "initial velocities"],
        };
        matches_differences(backend, &scene, &check)?;
    }
    Ok(())
}

/// Every kind of term, and every way in which a distance counts: to 1 %. Targets lie so near to where
/// nodes come that the nearest node stays the same within a step.
pub(crate) fn gradients_of_every_term(backend: &dyn Backend) -> Outcome {
    let wanted: [fn(&Term) -> bool; 11] = [
        |t| matches!(t, Term::Chamfer { of: PointSet::Nodes, .. }),
        |t| matches!(t, Term::Acceleration),
        |t| matches!(t, Term::Track { of: PointSet::Nodes, loss: PointLoss::Distance, .. }),
        |t| matches!(t, Term::Track { of: PointSet::Nodes, loss: PointLoss::SmoothL1 { .. }, .. }),
        |t| matches!(t, Term::Track { of: PointSet::Nodes, loss: PointLoss::SquaredDistance, .. }),
        |t| matches!(t, Term::Strain { .. }),
        |t| matches!(t, Term::Above { .. }),
        |t| matches!(t, Term::Within { .. }),
        |t| matches!(t, Term::Order { of: PointSet::Nodes, .. }),
        |t| matches!(t, Term::Winding { of: PointSet::Nodes, .. }),
        |t| matches!(t, Term::Coverage { of: PointSet::Nodes, .. }),
    ];
    for (i, wanted) in wanted.into_iter().enumerate() {
        let seed = 20 + i as u64;
        let mut scene = tracked(seed, &RandomOptions::default(), 4);
        scene.objective = random_objective(seed, &scene.model(), 4);
        keep(&mut scene.objective, wanted);
        near_nodes(backend, &mut scene)?;
        let must_matter: &[&str] = match i {
            // Which depends on rest lengths directly, too.
            5 => &["initial positions", "rest length"],
            _ => &["initial velocities"],
        };
        matches_differences(backend, &scene, &Check { seed, tolerance: 1e-2, must_matter })?;
    }
    Ok(())
}

/// The norm at a frame boundary is that of the gradient by initial positions of a rollout that
/// starts there with the terms from there on: to 1e-4. Cut, it is that of the terms of the window.
pub(crate) fn norms_are_those_of_restarts(backend: &dyn Backend) -> Outcome {
    for cut in [0, 2] {
        let scene = tracked(1, &RandomOptions { pins: 2, ..RandomOptions::default() }, 5);
        let states = scene.states(backend)?;
        let c = scene.graph.control_count();
        let request = GradientRequest { norms: true, cut_every: cut, ..GradientRequest::PARAMS };
        let norms = scene.gradient(backend, &request)?.norms;
        ensure(norms.len() == 6, || format!("{} norms of 5 frames", norms.len()))?;
        for (start, &got) in norms.iter().enumerate() {
            // A boundary belongs to the window that ends there.
            let windows = |f: usize| f.saturating_sub(1).checked_div(cut).unwrap_or(0);
            let mut rest = scene.clone();
            rest.frames = scene.frames - start;
            rest.initial = states[start].clone();
            rest.controls = scene.controls[start * c..].to_vec();
            let mut terms = (*scene.objective.terms).clone();
            terms.retain(|t| t.frame >= start && windows(t.frame) == windows(start));
            terms.iter_mut().for_each(|t| t.frame -= start);
            rest.objective.terms = Arc::new(terms);
            let gradient = rest.gradient(backend, &REQUEST)?;
            let by_start = gradient.initial.map(|s| s.positions).unwrap_or_default();
            let expected: f64 =
                by_start.iter().flatten().map(|&x| f64::from(x).powi(2)).sum::<f64>().sqrt();
            ensure(expected > 0.0, || format!("frame {start} has no gradient"))?;
            close(&format!("cut every {cut}: norm at {start}"), got, expected, 1e-4 * expected)?;
        }
    }
    Ok(())
}

/// Moves targets whose nearest nodes are sought to within some 8 mm of nodes' positions in their frame.
fn near_nodes(backend: &dyn Backend, scene: &mut Scene) -> Outcome {
    let rollout = scene.roll_out(backend)?;
    let n = scene.graph.node_count();
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let terms = Arc::make_mut(&mut scene.objective.terms);
    for term in terms {
        let nodes = &rollout.positions[term.frame * n..];
        if let Some(targets) = sought(&mut term.term) {
            for (target, node) in targets.iter_mut().zip(nodes) {
                *target = node.map(|x| x + 0.01 * (rng.random::<f32>() - 0.2));
            }
        }
    }
    Ok(())
}

/// Targets of a term whose nearest points are sought.
pub(crate) fn sought(term: &mut Term) -> Option<&mut Vec<Point>> {
    match term {
        Term::Chamfer { targets, .. } => Some(targets),
        Term::Coverage { targets, .. } => Some(Arc::make_mut(targets)),
        _ => None,
    }
}

/// A gradient cut at every k-th frame boundary is the sum of the gradients of the windows between,
/// each started from the state at its boundary as a constant. To 1e-4 of the largest entry.
pub(crate) fn cut_gradients_are_sums_of_windows(backend: &dyn Backend) -> Outcome {
    for (seed, cut) in [(0, 1), (1, 2), (2, 3)] {
        let options = RandomOptions { ground: true, ..RandomOptions::default() };
        let scene = tracked(seed, &options, 5);
        let states = scene.states(backend)?;
        let c = scene.graph.control_count();
        let whole = scene.gradient(backend, &GradientRequest { cut_every: cut, ..REQUEST })?;
        let uncut = scene.gradient(backend, &REQUEST)?;
        let mut sums: Vec<Vec<f64>> = Vec::new();
        for start in (0..scene.frames).step_by(cut) {
            let end = (start + cut).min(scene.frames);
            let mut window = scene.clone();
            window.frames = end - start;
            window.initial = states[start].clone();
            window.controls = scene.controls[start * c..(end + 1) * c].to_vec();
            let mut terms = (*scene.objective.terms).clone();
            terms.retain(|t| t.frame > start && t.frame <= end);
            terms.iter_mut().for_each(|t| t.frame -= start);
            window.objective.terms = Arc::new(terms);
            let part = window.gradient(backend, &REQUEST)?;
            for (k, kind) in kinds().iter().enumerate() {
                let values = (kind.derivatives)(&part);
                let offset = if kind.name == "controls" { start * c * 3 } else { 0 };
                if start == 0 {
                    sums.push(vec![0.0; (kind.derivatives)(&whole).len()]);
                } else if kind.name.starts_with("initial") {
                    continue;
                }
                for (i, v) in values.iter().enumerate() {
                    sums[k][offset + i] += f64::from(*v);
                }
            }
        }
        for (kind, sum) in kinds().iter().zip(&sums) {
            let got = (kind.derivatives)(&whole);
            let largest = sum.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
            for (i, (got, sum)) in got.iter().zip(sum).enumerate() {
                let what = format!("cut every {cut}: derivative by {} {i}", kind.name);
                close(&what, f64::from(*got), *sum, 1e-4 * largest + 1e-12)?;
            }
        }
        ensure(uncut.params != whole.params, || "cutting changes nothing".into())?;
    }
    Ok(())
}
