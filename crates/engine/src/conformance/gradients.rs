//! Gradients against finite differences of the backend's own losses.
//!
//! For every kind of variable, two directions are tried: every variable towards its own
//! gradient (nothing cancels, so a wrong scale shows) and random signs (a wrong pattern
//! shows). Steps change the loss by about a thousandth, which drowns the rounding of an f32
//! simulation; a five-point stencil keeps the truncation below it.

use std::sync::Arc;

use bendtwin_core::{Params, Point};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::{
    expect::{Outcome, close, ensure},
    random::{RandomOptions, random_model, random_motion, random_objective},
    scene::Scene,
};
use crate::{
    Backend, Objective, PointLoss, Term,
    backend::{CancelToken, Gradient, GradientRequest},
};

/// A kind of variable that a loss is differentiated by.
struct Kind {
    name: &'static str,
    /// The variables of a scene.
    variables: fn(&mut Scene) -> Vec<&mut f32>,
    /// Their derivatives.
    derivatives: fn(&Gradient) -> Vec<f32>,
    /// Largest step of a variable.
    largest_step: fn(f32) -> f32,
}

macro_rules! parameter {
    ($name:literal, $share:literal, $get:expr, $get_mut:expr) => {
        Kind {
            name: $name,
            variables: |s| {
                let get: fn(&mut Params) -> Vec<&mut f32> = $get_mut;
                get(&mut s.params)
            },
            derivatives: |g| {
                let get: fn(&Params) -> Vec<f32> = $get;
                get(&g.params)
            },
            largest_step: |x| $share * x,
        }
    };
}

fn kinds() -> Vec<Kind> {
    vec![
        parameter!("spring stiffness", 0.05, |p| p.spring_stiffness.clone(), |p| p
            .spring_stiffness
            .iter_mut()
            .collect()),
        parameter!("spring dashpot", 0.05, |p| p.spring_dashpot.clone(), |p| p
            .spring_dashpot
            .iter_mut()
            .collect()),
        parameter!("rest length", 0.005, |p| p.rest_lengths_m.clone(), |p| p
            .rest_lengths_m
            .iter_mut()
            .collect()),
        parameter!("bend stiffness", 0.05, |p| p.bend_stiffness.clone(), |p| p
            .bend_stiffness
            .iter_mut()
            .collect()),
        parameter!("bend damping", 0.05, |p| p.bend_damping.clone(), |p| p
            .bend_damping
            .iter_mut()
            .collect()),
        parameter!("rest angle", 0.05, |p| p.rest_angles_rad.clone(), |p| p
            .rest_angles_rad
            .iter_mut()
            .collect()),
        parameter!("drag", 0.3, |p| vec![p.drag], |p| vec![&mut p.drag]),
        parameter!("ground restitution", 0.05, |p| vec![p.contact.ground_restitution], |p| vec![
            &mut p.contact.ground_restitution
        ]),
        parameter!("ground friction", 0.2, |p| vec![p.contact.ground_friction], |p| vec![
            &mut p.contact.ground_friction
        ]),
        parameter!("object restitution", 0.05, |p| vec![p.contact.object_restitution], |p| vec![
            &mut p.contact.object_restitution
        ]),
        parameter!("object friction", 0.2, |p| vec![p.contact.object_friction], |p| vec![
            &mut p.contact.object_friction
        ]),
        Kind {
            name: "controls",
            variables: |s| s.controls.iter_mut().flatten().collect(),
            derivatives: |g| flat(&g.controls),
            largest_step: |_| 1e-4,
        },
        Kind {
            name: "initial positions",
            variables: |s| s.initial.positions.iter_mut().flatten().collect(),
            derivatives: |g| g.initial.as_ref().map_or(Vec::new(), |s| flat(&s.positions)),
            largest_step: |_| 1e-4,
        },
        Kind {
            name: "initial velocities",
            variables: |s| s.initial.velocities.iter_mut().flatten().collect(),
            derivatives: |g| g.initial.as_ref().map_or(Vec::new(), |s| flat(&s.velocities)),
            largest_step: |_| 5e-3,
        },
    ]
}

fn flat(points: &[Point]) -> Vec<f32> {
    points.iter().flatten().copied().collect()
}

const REQUEST: GradientRequest =
    GradientRequest { cut_every: 0, controls: true, initial: true, final_state: false };

/// How a check is done.
struct Check {
    seed: u64,
    /// Allowed error, relative to the sum of |derivative · step|.
    tolerance: f64,
    /// Kinds that must have a derivative other than zero.
    must_matter: &'static [&'static str],
}

/// Rounding of a loss, relative to it: an f32 simulation of a few hundred substeps moves each node
/// by some 5e-8 m, of distances of some cm, and nodes average out in part.
const ROUNDING: f64 = 1e-6;
/// How much of the loss a step should change.
const CHANGE: f64 = 1e-3;

fn matches_differences(backend: &dyn Backend, scene: &Scene, check: &Check) -> Outcome {
    let gradient = scene.gradient(backend, &REQUEST)?;
    ensure(gradient.loss.diverged.is_none(), || "the scene diverges".into())?;
    let mut rng = ChaCha8Rng::seed_from_u64(check.seed);
    for kind in kinds() {
        let what = format!("seed {}: {}", check.seed, kind.name);
        let mut probe = scene.clone();
        let values: Vec<f32> = (kind.variables)(&mut probe).into_iter().map(|x| *x).collect();
        let derivatives = (kind.derivatives)(&gradient);
        ensure(derivatives.len() == values.len(), || {
            format!("{what}: {} derivatives for {} variables", derivatives.len(), values.len())
        })?;
        // Weak variables get larger steps: the loss is the more linear in them.
        let strength = |scale: f64| -> f64 {
            let steps = values.iter().map(|x| scale * f64::from((kind.largest_step)(*x)));
            steps.zip(&derivatives).map(|(s, g)| (s * f64::from(*g)).abs()).sum()
        };
        let scale = (CHANGE * gradient.loss.total / strength(1.0)).min(1.0);
        if strength(scale) < 20.0 * ROUNDING * gradient.loss.total {
            ensure(!check.must_matter.contains(&kind.name), || {
                format!("{what}: the gradient is too small to be right, {:.1e}", strength(1.0))
            })?;
            continue;
        }
        let towards: Vec<f64> = derivatives.iter().map(|g| f64::from(g.signum())).collect();
        let mut sign = |_| if rng.random::<bool>() { 1.0 } else { -1.0 };
        let random: Vec<f64> = derivatives.iter().map(&mut sign).collect();
        for (direction, signs) in [("towards the gradient", towards), ("random signs", random)] {
            let moved = |times: f64| -> (Scene, f64) {
                let mut moved = scene.clone();
                let mut expected = 0.0;
                let variables = (kind.variables)(&mut moved).into_iter().enumerate();
                for (i, x) in variables {
                    let step = times * signs[i] * scale * f64::from((kind.largest_step)(*x));
                    let new = (f64::from(*x) + step) as f32;
                    // The step that f32 really took.
                    expected += (f64::from(new) - f64::from(*x)) * f64::from(derivatives[i]);
                    *x = new;
                }
                (moved, expected)
            };
            let probes = [2.0, 1.0, -1.0, -2.0].map(moved);
            let mut batch = Vec::new();
            for (scene, _) in &probes {
                batch.push(scene.instance(scene.load(backend)?));
            }
            let losses = backend.losses(&batch, &CancelToken::default());
            let l: Vec<f64> = losses.map_err(|e| e.to_string())?.iter().map(|l| l.total).collect();
            close(
                &format!("{what}: predicted change, {direction}"),
                (probes[1].1 - probes[2].1) / 2.0,
                (8.0 * (l[1] - l[2]) - (l[0] - l[3])) / 12.0,
                check.tolerance * strength(scale) + ROUNDING * gradient.loss.total,
            )?;
        }
    }
    Ok(())
}

/// A random scene with terms of one kind only, tracks unless told otherwise.
fn tracked(seed: u64, options: &RandomOptions, frames: usize) -> Scene {
    let model = random_model(seed, options);
    let (mut state, controls) = random_motion(seed, &model, frames);
    // A common velocity, or drag and friction would cancel between the nodes.
    state.velocities.iter_mut().for_each(|v| v[0] += 0.5);
    let mut objective = random_objective(seed, &model, frames);
    keep(&mut objective, |t| matches!(t, Term::Track { .. }));
    let mut scene = Scene::around(model, state, controls, frames);
    scene.objective = objective;
    scene
}

fn keep(objective: &mut Objective, wanted: impl Fn(&Term) -> bool) {
    let mut terms = (*objective.terms).clone();
    terms.retain(|t| wanted(&t.term));
    objective.terms = Arc::new(terms);
}

/// Whole rollouts of random networks without contact: to 1 % of the sum of all contributions.
pub(super) fn gradients_match_finite_differences(backend: &dyn Backend) -> Outcome {
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

/// Through impacts on the ground in the middle of the first substep, however the variables are
/// moved, sliding and sticking: to 1 %. (An impact that moves to another substep makes the
/// velocity jump by (1 + e) a dt, which no derivative sees and every difference does.)
pub(super) fn gradients_through_ground_contact(backend: &dyn Backend) -> Outcome {
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
            |x: &Point| x.iter().zip(up).map(|(x, n)| x * n).sum::<f32>() - ground.offset_m;
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
pub(super) fn gradients_through_object_contact(backend: &dyn Backend) -> Outcome {
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
        let nodes = vec![0, 1, 2];
        let targets = vec![[0.05, 0.0, 0.01], [0.0; 3], [0.1, 0.1, 0.0]];
        let track = Term::Track { nodes, targets, loss: PointLoss::SquaredDistance };
        scene.objective.groups = vec!["track".into()];
        scene.objective.terms = Arc::new(vec![crate::objective::WeightedTerm {
            frame: 3,
            weight: 1.0,
            group: 0,
            term: track,
        }]);
        let check = Check {
            seed,
            tolerance: 1e-2,
            must_matter: &["object restitution", "initial positions", "initial velocities"],
        };
        matches_differences(backend, &scene, &check)?;
    }
    Ok(())
}

/// Chamfer, acceleration and every way in which a distance counts: to 1 %. Chamfer's targets lie so
/// near to where nodes come that the nearest node stays the same within a step.
pub(super) fn gradients_of_every_term(backend: &dyn Backend) -> Outcome {
    let wanted: [fn(&Term) -> bool; 5] = [
        |t| matches!(t, Term::Chamfer { .. }),
        |t| matches!(t, Term::Acceleration),
        |t| matches!(t, Term::Track { loss: PointLoss::Distance, .. }),
        |t| matches!(t, Term::Track { loss: PointLoss::SmoothL1 { .. }, .. }),
        |t| matches!(t, Term::Track { loss: PointLoss::SquaredDistance, .. }),
    ];
    for (i, wanted) in wanted.into_iter().enumerate() {
        let seed = 20 + i as u64;
        let mut scene = tracked(seed, &RandomOptions::default(), 4);
        scene.objective = random_objective(seed, &scene.model(), 4);
        keep(&mut scene.objective, wanted);
        if i == 0 {
            near_nodes(backend, &mut scene)?;
        }
        let check = Check { seed, tolerance: 1e-2, must_matter: &["initial velocities"] };
        matches_differences(backend, &scene, &check)?;
    }
    Ok(())
}

/// Moves Chamfer targets to within some 8 mm of nodes' positions in their frame.
fn near_nodes(backend: &dyn Backend, scene: &mut Scene) -> Outcome {
    let rollout = scene.roll_out(backend)?;
    let n = scene.graph.node_count();
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let terms = Arc::make_mut(&mut scene.objective.terms);
    for term in terms {
        let nodes = &rollout.positions[term.frame * n..];
        if let Term::Chamfer { targets } = &mut term.term {
            for (target, node) in targets.iter_mut().zip(nodes) {
                *target = node.map(|x| x + 0.01 * (rng.random::<f32>() - 0.2));
            }
        }
    }
    Ok(())
}

/// A gradient cut at every k-th frame boundary is the sum of the gradients of the windows between,
/// each started from the state at its boundary as a constant. To 1e-4 of the largest entry.
pub(super) fn cut_gradients_are_sums_of_windows(backend: &dyn Backend) -> Outcome {
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
