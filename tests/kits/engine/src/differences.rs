//! The comparison of derivatives with finite differences of the backend's own losses.
//!
//! For every kind of variable, two directions are tried: every variable towards its own
//! gradient (nothing cancels, so a wrong scale shows) and random signs (a wrong pattern
//! shows). Steps change the loss by about a thousandth, which drowns the rounding of an f32
//! simulation; a five-point stencil keeps the truncation below it.

use bendtwin_core::{CancelToken, Params, Point};
use bendtwin_engine::{
    Backend,
    backend::{Gradient, GradientRequest},
};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::{
    expect::{Outcome, close, ensure},
    scene::Scene,
};

/// A kind of variable that a loss is differentiated by.
pub(crate) struct Kind {
    pub(crate) name: &'static str,
    /// The variables of a scene.
    variables: fn(&mut Scene) -> Vec<&mut f32>,
    /// Their derivatives.
    pub(crate) derivatives: fn(&Gradient) -> Vec<f32>,
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

/// Every kind of variable.
pub(crate) fn kinds() -> Vec<Kind> {
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
        parameter!("rest angle", 0.02, |p| p.rest_angles_rad.clone(), |p| p
            .rest_angles_rad
            .iter_mut()
            .collect()),
        parameter!("twist stiffness", 0.05, |p| p.twist_stiffness.clone(), |p| p
            .twist_stiffness
            .iter_mut()
            .collect()),
        parameter!("twist damping", 0.05, |p| p.twist_damping.clone(), |p| p
            .twist_damping
            .iter_mut()
            .collect()),
        Kind {
            name: "rest twist",
            variables: |s| s.params.rest_twists_rad.iter_mut().collect(),
            derivatives: |g| g.params.rest_twists_rad.clone(),
            largest_step: |_| 0.3,
        },
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
        Kind {
            name: "initial twists",
            variables: |s| s.initial.twists.iter_mut().collect(),
            derivatives: |g| g.initial.as_ref().map_or(Vec::new(), |s| s.twists.clone()),
            largest_step: |_| 0.3,
        },
        Kind {
            name: "initial places",
            variables: |s| s.initial.grasping.holds.iter_mut().flat_map(|h| &mut h.place).collect(),
            derivatives: |g| {
                let holds = g.initial.iter().flat_map(|s| &s.grasping.holds);
                holds.flat_map(|h| h.place).collect()
            },
            largest_step: |_| 1e-4,
        },
        Kind {
            name: "poses",
            variables: |s| s.motion.poses.iter_mut().flatten().flatten().collect(),
            derivatives: |g| g.poses.iter().flatten().flatten().copied().collect(),
            largest_step: |_| 1e-4,
        },
        Kind {
            name: "rolls",
            variables: |s| s.motion.rolls.iter_mut().collect(),
            derivatives: |g| g.rolls.clone(),
            largest_step: |_| 0.03,
        },
    ]
}

fn flat(points: &[Point]) -> Vec<f32> {
    points.iter().flatten().copied().collect()
}

/// Everything that a gradient can have.
pub(crate) const REQUEST: GradientRequest = GradientRequest {
    cut_every: 0,
    controls: true,
    initial: true,
    final_state: false,
    motion: true,
    ..GradientRequest::PARAMS
};

/// Parameters of a check.
pub(crate) struct Check {
    /// Seed of the random direction; names the scene in messages.
    pub(crate) seed: u64,
    /// Allowed error, relative to the sum of |derivative · step|.
    pub(crate) tolerance: f64,
    /// Kinds that must have a derivative other than zero.
    pub(crate) must_matter: &'static [&'static str],
}

/// Rounding of a loss, relative to it: an f32 simulation of a few hundred substeps moves each node
/// by some 5e-8 m, of distances of some cm, and nodes average out in part.
const ROUNDING: f64 = 1e-6;
/// Share of the loss that a step should change.
const CHANGE: f64 = 1e-3;

/// Compares all derivatives of a scene's loss with finite differences.
pub(crate) fn matches_differences(backend: &dyn Backend, scene: &Scene, check: &Check) -> Outcome {
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
