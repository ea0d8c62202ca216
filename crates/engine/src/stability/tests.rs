use std::sync::Arc;

use bendtwin_core::{
    Contact, Environment, Graph, NodeKind, Params, Timing, environment::ControlVelocity,
};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::*;
use crate::reference::Reference;

fn model(positions: Vec<[f32; 3]>, springs: Vec<[u32; 2]>, triplets: Vec<[u32; 3]>) -> Model {
    let n = positions.len();
    let distance = |a: u32, b: u32| {
        let (a, b) = (positions[a as usize], positions[b as usize]);
        (0..3).map(|c| (a[c] - b[c]).powi(2)).sum::<f32>().sqrt()
    };
    let angle = |[i, j, k]: [u32; 3]| {
        let (a, b, c) = (distance(i, j), distance(k, j), distance(i, k));
        ((a * a + b * b - c * c) / (2.0 * a * b)).clamp(-1.0, 1.0).acos()
    };
    let (e, t) = (springs.len(), triplets.len());
    Model {
        skin: Arc::default(),
        params: Params {
            spring_stiffness: vec![100.0; e],
            spring_dashpot: vec![0.0; e],
            rest_lengths_m: springs.iter().map(|&[a, b]| distance(a, b)).collect(),
            bend_stiffness: vec![0.0; t],
            bend_damping: vec![0.0; t],
            rest_angles_rad: triplets.iter().map(|&t| angle(t)).collect(),
            drag: 0.0,
            contact: Contact::default(),
            ..Params::default()
        },
        graph: Arc::new(Graph {
            kinds: vec![NodeKind::Observed; n],
            masses: vec![1.0; n],
            object_ids: vec![0; n],
            observed_points: vec![Graph::NOT_OBSERVED; n],
            control_rest: vec![],
            rest_positions: positions,
            springs,
            triplets,
            pins: vec![],
            ..Graph::default()
        }),
        environment: Environment { gravity: [0.0; 3], ground: None },
        timing: Timing { fps: 1.0, substeps: 1 },
        control_velocity: ControlVelocity::True,
    }
}

/// A random cloud whose nodes are joined with their near ones, with bending and both kinds of
/// damping.
fn cloud(seed: u64, stiffness: f32, dashpot: f32, bend: f32, bend_damping: f32) -> Model {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let positions: Vec<[f32; 3]> =
        (0..40).map(|_| std::array::from_fn(|_| rng.random_range(0.0..0.1))).collect();
    let (mut springs, mut triplets) = (Vec::new(), Vec::new());
    for a in 0..40_u32 {
        for b in a + 1..40 {
            let d = (0..3).map(|c| positions[a as usize][c] - positions[b as usize][c]);
            if d.map(|x| x * x).sum::<f32>() < 0.035_f32.powi(2) {
                springs.push([a, b]);
            }
        }
    }
    for w in springs.windows(2).filter(|w| w[0][0] == w[1][0]) {
        triplets.push([w[0][1], w[0][0], w[1][1]]);
    }
    let mut model = model(positions, springs, triplets);
    let p = &mut model.params;
    p.spring_stiffness.iter_mut().for_each(|k| *k = stiffness * rng.random_range(0.3..1.0_f32));
    p.spring_dashpot.iter_mut().for_each(|g| *g = dashpot * rng.random_range(0.3..1.0_f32));
    p.bend_stiffness.iter_mut().for_each(|k| *k = bend * rng.random_range(0.3..1.0_f32));
    p.bend_damping.iter_mut().for_each(|c| *c = bend_damping * rng.random_range(0.3..1.0_f32));
    model
}

/// Largest displacement from rest after `substeps`, starting with tiny velocities.
fn excursion(model: &Model, substeps: u32) -> f64 {
    let mut model = model.clone();
    model.timing.substeps = substeps;
    let frames = 4000_usize.div_ceil(substeps as usize);
    let mut r = Reference::new(&model, frames).unwrap();
    for (i, v) in r.velocities.iter_mut().enumerate() {
        *v = std::array::from_fn(|c| 1e-9 * ((3 * i + c) as f64 * 1.7).sin());
    }
    let states = r.roll_out().unwrap();
    if states.len() <= frames {
        return f64::INFINITY;
    }
    let moved = states[frames].positions.iter().flatten().zip(r.positions.iter().flatten());
    moved.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

#[test]
fn two_nodes_are_stable_up_to_two_over_omega() {
    let mut model = model(vec![[0.0; 3], [0.5, 0.0, 0.0]], vec![[0, 1]], vec![]);
    let omega = (2.0 * 100.0 / 0.5_f64).sqrt();
    let found = stable_substeps(&model);
    assert!((found.dt_s / (MARGIN * 2.0 / omega) - 1.0).abs() < 1e-6, "{found:?}");
    model.params.spring_stiffness[0] = 0.0;
    model.params.spring_dashpot[0] = 30.0;
    let found = stable_substeps(&model);
    assert!((found.dt_s / (MARGIN * 2.0 / 60.0) - 1.0).abs() < 1e-6, "{found:?}");
    model.params.spring_dashpot[0] = 0.0;
    assert_eq!(stable_substeps(&model).needed, 1);
    assert_eq!(stable_substeps(&model).dt_s, f64::INFINITY);
}

#[test]
fn random_graphs_hold_at_the_estimate_and_blow_up_soon_beyond_it() {
    let cases = [
        (1000.0, 0.0, 0.0, 0.0),
        (1000.0, 20.0, 0.0, 0.0),
        (100.0, 150.0, 0.0, 0.0),
        (10.0, 0.0, 0.5, 0.0),
        (10.0, 0.2, 0.1, 5e-3),
    ];
    for (case, (k, gamma, bend, damping)) in cases.into_iter().enumerate() {
        for seed in 0..3 {
            let model = cloud(seed, k, gamma, bend, damping);
            let found = stable_substeps(&model);
            assert!(found.needed > 5, "{case}: {found:?}");
            // Rest angles in f32 are not quite at rest: a few micrometres are no instability.
            let held = excursion(&model, found.needed);
            assert!(held < 2e-5, "case {case} {seed}: {held} at {found:?}");
            // Triplets count as stiff as they are far from straight; at rest they yield by a fifth.
            let share = if bend > 0.0 { 0.7 } else { 0.85 };
            let beyond = (f64::from(found.needed) * share).floor() as u32;
            let blown = excursion(&model, beyond);
            assert!(blown > 1e-3, "case {case} {seed}: {blown} at {beyond} of {found:?}");
        }
    }
}

#[test]
fn the_stiffest_node_is_named() {
    let mut model = cloud(5, 100.0, 1.0, 0.0, 0.0);
    for (s, spring) in model.graph.springs.iter().enumerate() {
        if spring.contains(&17) {
            model.params.spring_stiffness[s] = 1e5;
        }
    }
    let found = stable_substeps(&model);
    assert_eq!(found.stiffest_node, 17);
}

#[test]
fn straight_and_degenerate_triplets_count() {
    let rod = |y: f32| {
        let mut m = model(vec![[0.0; 3], [0.1, 0.0, 0.0], [0.2, y, 0.0]], vec![], vec![[0, 1, 2]]);
        m.params.bend_stiffness[0] = 0.3;
        stable_substeps(&m)
    };
    // k |g|² = 0.3 (1 + 4 + 1) / 0.01 = 180.
    assert!((rod(0.0).dt_s / (MARGIN * 2.0 / 180.0_f64.sqrt()) - 1.0).abs() < 1e-3);
    assert!((rod(1e-3).dt_s / rod(0.0).dt_s - 1.0).abs() < 1e-2);
    let mut m = model(vec![[0.0; 3]; 3], vec![[0, 1], [1, 2]], vec![[0, 1, 2]]);
    m.params.rest_angles_rad[0] = 1.0;
    assert_eq!(stable_substeps(&m).needed, 1);
    m.params.rest_angles_rad.clear();
    assert_eq!(enough_substeps(&m, 1), Ok(()), "loading refuses it for another reason");
    assert!(enough_substeps(&m, 0).is_err());
}

#[test]
fn absurd_stiffness_saturates() {
    let mut m = model(vec![[0.0; 3], [0.5, 0.0, 0.0]], vec![[0, 1]], vec![]);
    m.params.spring_stiffness[0] = f32::MAX;
    m.params.rest_lengths_m[0] = 1e-30;
    assert_eq!(stable_substeps(&m).needed, u32::MAX);
}

/// The largest stable step by power iteration, which is slow and simple.
fn patient_dt(model: &Model) -> f64 {
    let system = Linear::new(model);
    let (mut mode, _) = system.start();
    let mut dt = f64::INFINITY;
    for _ in 0..3000 {
        let (k, c) = system.quotients(&mode);
        dt = largest_dt(k, c);
        mode = applied(&system, &mode, dt);
        let length = mode.iter().map(|v| dot(*v, *v)).sum::<f64>().sqrt();
        mode.iter_mut().flatten().for_each(|x| *x /= length);
    }
    dt
}

/// `dt² K + 2 dt C` times v.
fn applied(system: &Linear, v: &[Vector], dt: f64) -> Vec<Vector> {
    let mut out = vec![[0.0; 3]; v.len()];
    let root = |e: u32| system.roots[e as usize];
    for b in &system.bars {
        let [p, q] = b.ends.map(|e| v[e as usize].map(|x| root(e) * x));
        let r: Vector = std::array::from_fn(|c| q[c] - p[c]);
        let along = dot(r, b.direction);
        for c in 0..3 {
            let part = along * b.direction[c];
            let stiff = b.along * part + b.across * (r[c] - part);
            let f = dt * dt * stiff + 2.0 * dt * b.damping * part;
            out[b.ends[0] as usize][c] -= root(b.ends[0]) * f;
            out[b.ends[1] as usize][c] += root(b.ends[1]) * f;
        }
    }
    for h in &system.hinges {
        let parts = h.ends.iter().zip(h.pattern);
        let bent: f64 = parts.clone().map(|(&e, g)| root(e) * dot(g, v[e as usize])).sum();
        let f = (dt * dt * h.stiffness + 2.0 * dt * h.damping) * bent;
        for (&e, g) in parts {
            (0..3).for_each(|c| out[e as usize][c] += root(e) * f * g[c]);
        }
    }
    out
}

/// Models whose stiffness varies wildly from spring to spring, and ones with a spot just a little
/// stiffer than a large body.
fn awkward_models() -> Vec<Model> {
    let mut models: Vec<Model> = (0..4).map(|s| cloud(s, 1000.0, 5.0, 0.1, 1e-3)).collect();
    let mut rng = ChaCha8Rng::seed_from_u64(9);
    for model in &mut models {
        for k in &mut model.params.spring_stiffness {
            *k *= (2.0 * rng.random_range(-1.0..1.0_f32)).exp();
        }
    }
    models.extend((4..7).map(|s| cloud(s, 10.0, 0.2, 0.1, 5e-3)));
    models.extend((7..10).map(|s| cloud(s, 100.0, 40.0, 0.0, 0.0)));
    let n = 400;
    let line = (0..n).map(|i| [0.01 * i as f32, 0.0, 0.0]).collect();
    let mut rod = model(line, (1..n).map(|i| [i - 1, i]).collect(), vec![]);
    models.push(rod.clone());
    for spot in [1.05, 1.2, 2.0] {
        rod.params.spring_stiffness[137] = 100.0 * spot;
        models.push(rod.clone());
    }
    // Stretched: lateral stiffness everywhere.
    rod.params.rest_lengths_m.iter_mut().for_each(|l| *l *= 0.5);
    models.push(rod);
    models
}

#[test]
fn the_margin_covers_unfinished_iteration() {
    for (i, model) in awkward_models().iter().enumerate() {
        let (quick, exact) = (stable_substeps(model).dt_s, patient_dt(model));
        assert!(quick < exact, "model {i}: {quick} {exact}");
        assert!(quick > 0.95 * exact, "model {i}: {quick} {exact}: found less than there is");
    }
}

/// The estimate confirms all that the bound proves, and the bound proves enough to be useful.
#[test]
fn the_bound_agrees_with_the_estimate_where_it_speaks() {
    for (i, model) in awkward_models().iter().enumerate() {
        let exact = patient_dt(model);
        let system = Linear::new(model);
        for bound in bound::of(&system, exact) {
            assert!(bound >= 4.0 - 1e-6, "model {i}: {bound} is below an eigenvalue");
        }
        let fine = bound::of(&system, exact / 1.8)[1];
        assert!(fine <= 4.0, "model {i}: {fine}");
        let needed = stable_substeps(model).needed;
        assert_eq!(enough_substeps(model, needed), Ok(()));
        assert_eq!(enough_substeps(model, 4 * needed), Ok(()));
        let short = needed - 1;
        assert_eq!(enough_substeps(model, short).unwrap_err().needed, needed);
    }
}
