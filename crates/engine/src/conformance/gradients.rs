//! Gradients against finite differences of the backend's own losses.
//!
//! For every kind of variable, two directions are tried: every variable towards its own
//! gradient (nothing cancels, so a wrong scale shows) and random signs (a wrong pattern
//! shows). Steps are relative for parameters, absolute for states and controls, and large
//! enough to drown the rounding of an f32 simulation; a five-point stencil keeps the
//! truncation below it.

use std::sync::Arc;

use bendtwin_core::Params;
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
    /// Finite difference step of a variable.
    step: fn(f32) -> f32,
}

macro_rules! parameter {
    ($name:literal, $get:expr, $get_mut:expr) => {
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
            step: |x| 4e-3 * x,
        }
    };
}

fn kinds() -> Vec<Kind> {
    let mut kinds = vec![
        parameter!("spring stiffness", |p| p.spring_stiffness.clone(), |p| p
            .spring_stiffness
            .iter_mut()
            .collect()),
        parameter!("spring dashpot", |p| p.spring_dashpot.clone(), |p| p
            .spring_dashpot
            .iter_mut()
            .collect()),
        parameter!("bend stiffness", |p| p.bend_stiffness.clone(), |p| p
            .bend_stiffness
            .iter_mut()
            .collect()),
        parameter!("bend damping", |p| p.bend_damping.clone(), |p| p
            .bend_damping
            .iter_mut()
            .collect()),
        parameter!("rest angle", |p| p.rest_angles_rad.clone(), |p| p
            .rest_angles_rad
            .iter_mut()
            .collect()),
        parameter!("drag", |p| vec![p.drag], |p| vec![&mut p.drag]),
        parameter!("ground restitution", |p| vec![p.contact.ground_restitution], |p| vec![
            &mut p.contact.ground_restitution
        ]),
        parameter!("ground friction", |p| vec![p.contact.ground_friction], |p| vec![
            &mut p.contact.ground_friction
        ]),
        parameter!("object restitution", |p| vec![p.contact.object_restitution], |p| vec![
            &mut p.contact.object_restitution
        ]),
        parameter!("object friction", |p| vec![p.contact.object_friction], |p| vec![
            &mut p.contact.object_friction
        ]),
    ];
    kinds.push(Kind {
        name: "rest length",
        variables: |s| s.params.rest_lengths_m.iter_mut().collect(),
        derivatives: |g| g.params.rest_lengths_m.clone(),
        step: |x| 1e-3 * x,
    });
    kinds.push(Kind {
        name: "controls",
        variables: |s| s.controls.iter_mut().flatten().collect(),
        derivatives: |g| g.controls.iter().flatten().copied().collect(),
        step: |_| 2e-5,
    });
    kinds.push(Kind {
        name: "initial positions",
        variables: |s| s.initial.positions.iter_mut().flatten().collect(),
        derivatives: |g| g.initial.iter().flat_map(|s| &s.positions).flatten().copied().collect(),
        step: |_| 2e-5,
    });
    kinds.push(Kind {
        name: "initial velocities",
        variables: |s| s.initial.velocities.iter_mut().flatten().collect(),
        derivatives: |g| g.initial.iter().flat_map(|s| &s.velocities).flatten().copied().collect(),
        step: |_| 5e-4,
    });
    kinds
}

const REQUEST: GradientRequest =
    GradientRequest { cut_every: 0, controls: true, initial: true, final_state: false };

/// How a check is done.
struct Check {
    seed: u64,
    /// Allowed error, relative to the sum of |derivative · step|.
    tolerance: f64,
    /// Factor on all steps.
    scale: f32,
    /// Kinds that must have a derivative other than zero.
    must_matter: &'static [&'static str],
}

fn matches_differences(backend: &dyn Backend, scene: &Scene, check: &Check) -> Outcome {
    let gradient = scene.gradient(backend, &REQUEST)?;
    ensure(gradient.loss.diverged.is_none(), || "the scene diverges".into())?;
    let mut rng = ChaCha8Rng::seed_from_u64(check.seed);
    for kind in kinds() {
        let mut probe = scene.clone();
        let values: Vec<f32> = (kind.variables)(&mut probe).into_iter().map(|x| *x).collect();
        let derivatives = (kind.derivatives)(&gradient);
        ensure(derivatives.len() == values.len(), || {
            format!("{} derivatives for {} of {}", derivatives.len(), values.len(), kind.name)
        })?;
        let steps: Vec<f32> = values.iter().map(|x| (kind.step)(*x) * check.scale).collect();
        let strength: f64 =
            derivatives.iter().zip(&steps).map(|(g, s)| f64::from(g * s).abs()).sum();
        if strength == 0.0 {
            ensure(!check.must_matter.contains(&kind.name), || {
                format!("seed {}: the gradient by {} is zero", check.seed, kind.name)
            })?;
        }
        let towards: Vec<f32> = derivatives.iter().map(|g| g.signum()).collect();
        let random: Vec<f32> =
            derivatives.iter().map(|_| if rng.random::<bool>() { 1.0 } else { -1.0 }).collect();
        for (direction, signs) in [("towards the gradient", towards), ("random", random)] {
            let moved = |times: f32| {
                let mut moved = scene.clone();
                let variables = (kind.variables)(&mut moved).into_iter();
                for ((x, s), sign) in variables.zip(&steps).zip(&signs) {
                    *x += times * s * sign;
                }
                moved
            };
            let batch = [2.0, 1.0, -1.0, -2.0].map(moved);
            let expected: f64 = {
                let exact = |times: f32| -> Vec<f32> {
                    let mut m = moved(times);
                    (kind.variables)(&mut m).into_iter().map(|x| *x).collect()
                };
                // The step that f32 really took, times the derivative.
                let (up, down) = (exact(1.0), exact(-1.0));
                let taken = up.iter().zip(&down).map(|(u, d)| f64::from(*u) - f64::from(*d));
                taken.zip(&derivatives).map(|(d, g)| d * f64::from(*g)).sum::<f64>() / 2.0
            };
            let mut loaded = Vec::new();
            for scene in &batch {
                loaded.push(scene.instance(scene.load(backend)?));
            }
            let losses = backend.losses(&loaded, &CancelToken::default());
            let l: Vec<f64> = losses.map_err(|e| e.to_string())?.iter().map(|l| l.total).collect();
            let difference = (8.0 * (l[1] - l[2]) - (l[0] - l[3])) / 12.0;
            let rounding = 2e-8 * l[1].abs();
            close(
                &format!("seed {}: change of loss by {}, {direction}", check.seed, kind.name),
                expected,
                difference,
                check.tolerance * strength + rounding,
            )?;
        }
    }
    Ok(())
}

/// A random scene with terms of one kind only, tracks unless told otherwise.
fn tracked(seed: u64, options: &RandomOptions, frames: usize) -> Scene {
    let model = random_model(seed, options);
    let (state, controls) = random_motion(seed, &model, frames);
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
            scale: 1.0,
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

/// Through impacts on the ground, time of impact included: to 3 %, as a finite step moves some
/// impact to the next substep, which the derivative cannot see.
pub(super) fn gradients_through_ground_contact(backend: &dyn Backend) -> Outcome {
    for seed in 0..4 {
        let options = RandomOptions { ground: true, nodes: 12, ..RandomOptions::default() };
        let mut scene = tracked(seed, &options, 5);
        scene.initial.velocities.iter_mut().for_each(|v| v[2] -= 0.8);
        let check = Check {
            seed,
            tolerance: 3e-2,
            scale: 0.25,
            must_matter: &["ground restitution", "ground friction", "initial positions"],
        };
        matches_differences(backend, &scene, &check)?;
    }
    Ok(())
}

/// Through collisions between objects that happen in the first substep, however the variables are
/// moved: to 2 %. (The substep of a later collision jumps, as its time of impact is not resolved.)
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
            tolerance: 2e-2,
            scale: 1.0,
            must_matter: &["object restitution", "initial positions", "initial velocities"],
        };
        matches_differences(backend, &scene, &check)?;
    }
    Ok(())
}

/// Chamfer, acceleration and every way in which a distance counts: to 3 %, as the nearest node
/// of some target changes within the step.
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
        let check =
            Check { seed, tolerance: 3e-2, scale: 0.5, must_matter: &["initial velocities"] };
        matches_differences(backend, &scene, &check)?;
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
