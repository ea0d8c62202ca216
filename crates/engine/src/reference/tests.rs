//! Finite differences of whole rollouts with respect to everything that has a gradient.

mod surroundings;

use std::sync::Arc;

use bendtwin_core::{
    Contact, Environment, Graph, NodeKind, Params, Pin, Plane, Timing, environment::ControlVelocity,
};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::*;
use crate::objective::{PointLoss, PointSet, Term, WeightedTerm};

/// A small body of two objects over a tilted ground, with two control points, control springs, a
/// pinned node, and triplets of every kind, so that every code path has a gradient.
fn body(seed: u64) -> Model {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut jitter = || rng.random_range(-0.006..0.006_f32);
    let n = 12;
    let rest_positions: Vec<[f32; 3]> = (0..n)
        .map(|i| {
            let (x, y, z) = (i % 2, (i / 2) % 2, i / 4);
            [x, y, z].map(|c| 0.05 * c as f32 + jitter())
        })
        .collect();
    let mut springs = Vec::new();
    for a in 0..n as u32 {
        for b in a + 1..n as u32 {
            if (a < 8) == (b < 8) {
                springs.push([a, b]);
            }
        }
    }
    springs.extend([[0, n as u32], [1, n as u32], [5, n as u32 + 1]]);
    let triplets = vec![[0, 1, 3], [2, 3, 1], [4, 5, 7], [8, 9, 11], [n as u32, 0, 2], [6, 4, 0]];
    let graph = Graph {
        kinds: (0..n)
            .map(|i| if i < 10 { NodeKind::Observed } else { NodeKind::Interior })
            .collect(),
        masses: (0..n).map(|i| 1.0 + 0.1 * i as f32).collect(),
        object_ids: (0..n).map(|i| u32::from(i >= 8)).collect(),
        observed_points: vec![Graph::NOT_OBSERVED; n],
        rest_positions,
        control_rest: vec![[0.0, 0.0, -0.03], [0.09, 0.02, 0.05]],
        springs,
        triplets,
        pins: vec![Pin { node: 7, control: 1, offset_m: [-0.03, 0.03, 0.0] }],
        ..Graph::default()
    };
    let lengths = graph.springs.iter().map(|&[a, b]| {
        let (a, b) = (graph.rest_endpoint(a), graph.rest_endpoint(b));
        (0..3).map(|c| (a[c] - b[c]).powi(2)).sum::<f32>().sqrt()
    });
    let (e, t) = (graph.springs.len(), graph.triplets.len());
    let mut uniform = |count: usize, low: f32, high: f32| -> Vec<f32> {
        (0..count).map(|_| rng.random_range(low..high)).collect()
    };
    Model {
        skin: Arc::default(),
        params: Params {
            rest_lengths_m: lengths.collect(),
            spring_stiffness: uniform(e, 20.0, 80.0),
            spring_dashpot: uniform(e, 0.5, 3.0),
            bend_stiffness: uniform(t, 0.01, 0.05),
            bend_damping: uniform(t, 1e-4, 1e-3),
            rest_angles_rad: uniform(t, 1.0, 2.0),
            drag: 1.5,
            contact: Contact { within_object: false, ..Contact::default() },
            ..Params::default()
        },
        graph: Arc::new(graph),
        environment: Environment {
            gravity: [0.3, -0.2, -9.81],
            ground: Some(Plane { normal: [0.6, 0.0, 0.8], offset_m: -0.2 }),
        },
        timing: Timing { fps: 30.0, substeps: 60 },
        control_velocity: ControlVelocity::True,
    }
}

/// A scene that moves, glides and falls.
fn scene(model: &Model, frames: usize) -> Reference {
    let mut r = Reference::new(model, frames).unwrap();
    for (i, v) in r.velocities.iter_mut().enumerate() {
        let i = i as f64;
        *v = [0.4 * (i * 1.3).sin(), 0.5 * (i * 0.7).cos(), -0.3 * (i * 0.4).cos()];
    }
    let c = model.graph.control_count();
    for (row, p) in r.controls.iter_mut().enumerate() {
        let f = (row / c) as f64;
        *p = [
            p[0] + 0.01 * (f * 0.9).sin(),
            p[1] - 0.006 * f,
            p[2] + 0.008 * (f * 1.1).cos() - 0.008,
        ];
    }
    r
}

fn objective(model: &Model, frames: usize) -> Objective {
    let targets: Vec<_> = model
        .graph
        .rest_positions
        .iter()
        .enumerate()
        .map(|(i, p)| [p[0] + 0.013, p[1] - 0.009 + 0.002 * i as f32, p[2] - 0.017])
        .collect();
    let mut terms = Vec::new();
    for frame in 0..=frames {
        let track = |loss| Term::Track {
            of: PointSet::Nodes,
            points: vec![1, 3, 6, 7],
            targets: targets[..4].to_vec(),
            loss,
        };
        let kinds = [
            Term::Chamfer { of: PointSet::Nodes, targets: targets[2..9].to_vec() },
            track(PointLoss::SmoothL1 { beta_m: 0.02 }),
            track(PointLoss::Distance),
            track(PointLoss::SquaredDistance),
            Term::Acceleration,
        ];
        for (k, term) in kinds.into_iter().enumerate() {
            let weight = 1.0 + k as f32;
            terms.push(WeightedTerm { frame, weight, group: k % 2, term });
        }
    }
    Objective { groups: vec!["even".into(), "odd".into()], terms: Arc::new(terms) }
}

/// A number of a reference that can be perturbed, and its gradient.
struct Knob {
    name: &'static str,
    scale: f64,
    set: fn(&mut Reference, usize) -> &mut f64,
    gradient: fn(&ReferenceGradient, usize) -> f64,
    count: usize,
}

macro_rules! element {
    ($name:ident, $scale:expr, $count:expr) => {
        Knob {
            name: stringify!($name),
            scale: $scale,
            set: |r, i| &mut r.parameters.$name[i],
            gradient: |g, i| g.parameters.$name[i],
            count: $count,
        }
    };
}

macro_rules! global {
    ($name:ident) => {
        Knob {
            name: stringify!($name),
            scale: 1.0,
            set: |r, _| &mut r.parameters.$name,
            gradient: |g, _| g.parameters.$name,
            count: 1,
        }
    };
}

macro_rules! points {
    ($name:ident, $scale:expr, $count:expr) => {
        Knob {
            name: stringify!($name),
            scale: $scale,
            set: |r, i| &mut r.$name[i / 3][i % 3],
            gradient: |g, i| g.$name[i / 3][i % 3],
            count: 3 * $count,
        }
    };
}

fn knobs(r: &Reference) -> Vec<Knob> {
    let (e, t) = (r.parameters.spring_stiffness.len(), r.parameters.bend_stiffness.len());
    vec![
        element!(spring_stiffness, 50.0, e),
        element!(spring_dashpot, 1.0, e),
        element!(rest_lengths_m, 0.05, e),
        element!(bend_stiffness, 0.03, t),
        element!(bend_damping, 1e-3, t),
        element!(rest_angles_rad, 1.0, t),
        global!(drag),
        global!(ground_restitution),
        global!(ground_friction),
        global!(object_restitution),
        global!(object_friction),
        points!(positions, 0.05, r.positions.len()),
        points!(velocities, 0.5, r.velocities.len()),
        points!(controls, 0.05, r.controls.len()),
        points!(places, 0.05, r.places.len()),
        Knob {
            name: "poses",
            scale: 0.05,
            set: |r, i| &mut r.poses[i / 12][i / 4 % 3][i % 4],
            gradient: |g, i| g.poses[i / 12][i / 4 % 3][i % 4],
            count: 12 * r.poses.len(),
        },
        Knob {
            name: "rolls",
            scale: 1.0,
            set: |r, i| &mut r.rolls[i],
            gradient: |g, i| g.rolls[i],
            count: r.rolls.len(),
        },
    ]
}

/// Largest error of each knob, relative to that knob's largest gradient.
fn errors(r: &Reference, objective: &Objective, step: f64) -> Vec<(&'static str, f64, f64)> {
    least_errors(r, objective, &[step])
}

/// [`errors`] with the step that agrees best, for each: where a loss jumps at impacts, a step may
/// cross a jump that a tenth of the step does not.
fn least_errors(
    r: &Reference,
    objective: &Objective,
    steps: &[f64],
) -> Vec<(&'static str, f64, f64)> {
    let g = r.gradient(objective, 0).unwrap();
    assert!(g.loss.diverged.is_none());
    let mut out = Vec::new();
    for knob in knobs(r).into_iter().filter(|k| k.count > 0) {
        let (mut worst, mut largest) = (0.0_f64, 0.0_f64);
        for i in 0..knob.count {
            let at = |by: f64| {
                let mut moved = r.clone();
                *(knob.set)(&mut moved, i) += by;
                moved.loss(objective).unwrap().total
            };
            let gradient = (knob.gradient)(&g, i);
            let error = |step: &f64| {
                let h = step * knob.scale;
                ((at(h) - at(-h)) / (2.0 * h) - gradient).abs()
            };
            worst = worst.max(steps.iter().map(error).fold(f64::INFINITY, f64::min));
            largest = largest.max(gradient.abs());
        }
        out.push((knob.name, worst / largest.max(1e-30), largest));
    }
    out
}

fn assert_small(errors: &[(&str, f64, f64)], tolerance: f64, inert: &[&str]) {
    for (name, error, largest) in errors {
        if inert.contains(name) {
            assert_eq!(*largest, 0.0, "{name} should have no influence");
        } else {
            assert!(*largest > 0.0, "{name} has no influence");
            assert!(*error < tolerance, "{name}: relative error {error:e}");
        }
    }
}

const CONTACT: [&str; 4] =
    ["ground_restitution", "ground_friction", "object_restitution", "object_friction"];

/// Free flight: smooth, so relative 1e-6.
#[test]
fn smooth_rollout_gradients_match_finite_differences() {
    let mut model = body(1);
    model.environment.ground = None;
    let mut params = model.params.clone();
    params.contact.between_objects = false;
    model.params = params;
    let r = scene(&model, 4);
    let errors = errors(&r, &objective(&model, 4), 1e-5);
    assert_small(&errors, 1e-6, &CONTACT);
}

/// With ground and contact between objects: piecewise smooth, so the steps are small enough to
/// cross no impact, which costs digits: 1e-5.
#[test]
fn contact_rollout_gradients_match_finite_differences() {
    let mut model = body(2);
    model.environment.ground = Some(Plane { normal: [0.6, 0.0, 0.8], offset_m: -0.01 });
    model.params.contact.collision_distance_m = 0.055;
    let mut r = scene(&model, 3);
    r.velocities[8..].iter_mut().for_each(|v| v[2] -= 1.0);
    let errors = errors(&r, &objective(&model, 3), 1e-6);
    assert_small(&errors, 1e-5, &[]);
}

/// Nodes of one object that no spring joins, flung at each other.
#[test]
fn self_contact_gradients_match_finite_differences() {
    let mut model = body(3);
    model.environment.ground = None;
    let mut graph = Graph::clone(&model.graph);
    graph.object_ids = vec![0; 12];
    model.graph = Arc::new(graph);
    model.params.contact.within_object = true;
    model.params.contact.collision_distance_m = 0.055;
    let mut r = scene(&model, 3);
    r.velocities[8..].iter_mut().for_each(|v| v[2] -= 1.0);
    let errors = errors(&r, &objective(&model, 3), 1e-6);
    assert_small(&errors, 1e-5, &CONTACT[..2]);
}

#[test]
fn a_cut_gradient_is_that_of_the_last_window() {
    let mut model = body(4);
    model.environment.ground = None;
    let r = scene(&model, 4);
    let mut objective = objective(&model, 4);
    let kept = |t: &&WeightedTerm| t.frame == 4 && t.term != Term::Acceleration;
    objective.terms = Arc::new(objective.terms.iter().filter(kept).cloned().collect());
    let cut = r.gradient(&objective, 3).unwrap();
    let start = r.roll_out().unwrap().swap_remove(3);
    let mut window = Reference::new(&model, 1).unwrap();
    (window.positions, window.velocities) = (start.positions, start.velocities);
    window.controls = r.controls[3 * 2..].to_vec();
    let terms = objective.terms.iter().cloned().map(|t| WeightedTerm { frame: 1, ..t });
    objective.terms = Arc::new(terms.collect());
    let last = window.gradient(&objective, 0).unwrap();
    assert_eq!(cut.loss.total, last.loss.total);
    assert_eq!(cut.parameters, last.parameters);
    assert!(cut.positions.iter().flatten().all(|&x| x == 0.0));
    assert_eq!(cut.controls[6..], last.controls[..]);
}
