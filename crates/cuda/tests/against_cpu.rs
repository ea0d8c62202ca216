//! The device against the CPU, which defines what is correct, on fresh random models: every run
//! draws its own seed and prints it; `BENDTWIN_SEED` repeats one.

#[path = "against_cpu/skin.rs"]
mod skin;
#[path = "against_cpu/surroundings.rs"]
mod surroundings;

use std::sync::{Arc, OnceLock};

use bendtwin_core::{CancelToken, Params};
use bendtwin_cuda::{Options, cuda};
use bendtwin_engine::{
    Backend, Model, Objective, PointLoss, PointSet, Term,
    backend::{GradientRequest, Instance, Outputs},
    cpu,
    objective::WeightedTerm,
};
use bendtwin_engine_kit::{RandomOptions, in_frames, random_model, random_motion, task_terms};

fn backend() -> Arc<dyn Backend> {
    static BACKEND: OnceLock<Arc<dyn Backend>> = OnceLock::new();
    BACKEND.get_or_init(|| cuda(&Options::default()).expect("a CUDA device")).clone()
}

fn seed() -> u64 {
    static SEED: OnceLock<u64> = OnceLock::new();
    *SEED.get_or_init(|| {
        let given = std::env::var("BENDTWIN_SEED").ok().and_then(|s| s.parse().ok());
        let now = std::time::SystemTime::now().duration_since(std::time::UNIX_EPOCH);
        let seed = given.unwrap_or_else(|| now.map_or(0, |t| t.as_secs()));
        println!("BENDTWIN_SEED={seed}");
        seed
    })
}

/// Models of every kind, from a handful of nodes to more than a block's threads.
fn models() -> Vec<(String, Model)> {
    let kinds = [
        ("plain", RandomOptions { bending: false, damping: false, ..RandomOptions::default() }),
        ("bending", RandomOptions::default()),
        ("rod", RandomOptions { rod: true, pins: 4, ..RandomOptions::default() }),
        ("ground", RandomOptions { ground: true, ..RandomOptions::default() }),
        (
            "skin on the ground",
            RandomOptions { ground: true, skin_contact: true, ..RandomOptions::default() },
        ),
        ("two objects", RandomOptions { objects: 2, contact: true, ..RandomOptions::default() }),
        (
            "everything",
            RandomOptions {
                objects: 2,
                contact: true,
                ground: true,
                pins: 3,
                ..RandomOptions::default()
            },
        ),
    ];
    let sizes = [5, 60, 401, 1500];
    let each = kinds.into_iter().enumerate().flat_map(|(k, (name, options))| {
        sizes.into_iter().map(move |nodes| {
            let options = RandomOptions { nodes, ..options };
            let seed = seed() + (k as u64) * 100 + nodes as u64;
            let mut model = random_model(seed, &options);
            in_frames(Arc::make_mut(&mut model.skin));
            // With equal dashpots other kernels run.
            if (k + nodes).is_multiple_of(2) {
                model.params.spring_dashpot.fill(0.4);
            }
            (format!("{name}, {nodes} nodes, seed {seed}"), model)
        })
    });
    each.collect()
}

fn instance(backend: &dyn Backend, model: &Model, seed: u64, frames: usize) -> Instance {
    let (initial, controls) = random_motion(seed, model, frames);
    Instance {
        model: backend.load(Arc::new(model.clone())).expect("random models are stable"),
        initial: Arc::new(initial),
        controls: Arc::new(controls),
        frames,
        objective: objective(model, frames),
        world: Arc::default(),
        motion: Arc::default(),
    }
}

fn objective(model: &Model, frames: usize) -> Objective {
    let graph = &model.graph;
    let aside = |i: u32| graph.rest_positions[i as usize].map(|x| x + 0.01);
    let some: Vec<u32> = (0..graph.surface_count() as u32).step_by(2).collect();
    let targets: Vec<_> = some.iter().map(|&i| aside(i)).collect();
    let loss = PointLoss::SmoothL1 { beta_m: 0.01 };
    let terms = (1..=frames).flat_map(|frame| {
        let track = Term::Track {
            of: PointSet::Nodes,
            points: some.clone(),
            targets: targets.clone(),
            loss,
        };
        let [skin_chamfer, skin_track, skin_order, skin_winding, skin_coverage] =
            skin::terms(model, frame);
        let [order, winding, coverage] = task_terms(model, PointSet::Nodes, &some);
        let terms = [
            (0, 1.0, Term::Chamfer { of: PointSet::Nodes, targets: targets.clone() }),
            (1, 0.5, track),
            (2, 0.2, Term::Acceleration),
            (3, 0.9, skin_chamfer),
            (4, 0.7, skin_track),
            (5, 0.8, order),
            (6, 0.01, winding),
            (7, 0.05, coverage),
            (8, 0.6, skin_order),
            (9, 0.01, skin_winding),
            (10, 0.05, skin_coverage),
        ];
        terms.map(|(group, weight, term)| WeightedTerm { frame, weight, group, term })
    });
    Objective {
        groups: [
            "chamfer",
            "track",
            "acceleration",
            "skin chamfer",
            "skin track",
            "order",
            "winding",
            "coverage",
            "skin order",
            "skin winding",
            "skin coverage",
        ]
        .map(str::to_owned)
        .to_vec(),
        terms: Arc::new(terms.collect()),
    }
}

fn both(model: &Model, seed: u64, frames: usize) -> [(Arc<dyn Backend>, Instance); 2] {
    [cpu(), backend()].map(|b| {
        let instance = instance(&*b, model, seed, frames);
        (b, instance)
    })
}

#[test]
#[ignore = "needs a CUDA device"]
fn positions_after_a_frame_agree() {
    let outputs = Outputs { every: 1, final_state: true, ..Outputs::default() };
    let mut worst = 0.0_f64;
    for (name, model) in models() {
        let [expected, found] = both(&model, seed(), 1).map(|(b, i)| {
            b.roll_out(&[i], &outputs, &CancelToken::default()).expect("valid").remove(0)
        });
        let squares = expected
            .positions
            .iter()
            .zip(&found.positions)
            .map(|(a, b)| a.iter().zip(b).map(|(x, y)| f64::from(x - y).powi(2)).sum::<f64>());
        let rms = (squares.sum::<f64>() / expected.positions.len().max(1) as f64).sqrt();
        println!("{name}: {rms:.2e} m rms");
        assert!(rms < 1e-6, "{name}: {rms} m rms");
        assert!((expected.cost - found.cost).abs() <= 1e-4 * expected.cost.abs(), "{name}");
        worst = worst.max(rms);
    }
    println!("worst {worst:.2e} m rms");
}

fn relative(name: &str, what: &str, expected: &[f32], found: &[f32]) -> f64 {
    relative_within(1e-3, name, what, expected, found)
}

/// Norm of the difference by that of what is expected, which is to be at most `within`.
fn relative_within(within: f64, name: &str, what: &str, expected: &[f32], found: &[f32]) -> f64 {
    let square = |v: f64| v * v;
    let size: f64 = expected.iter().map(|&x| square(f64::from(x))).sum::<f64>().sqrt();
    let apart: f64 = expected
        .iter()
        .zip(found)
        .map(|(&x, &y)| square(f64::from(x) - f64::from(y)))
        .sum::<f64>()
        .sqrt();
    assert_eq!(expected.len(), found.len(), "{name}, {what}");
    let relative = if apart == 0.0 { 0.0 } else { apart / size };
    assert!(relative < within, "{name}, {what}: {relative:.2e} relative to {size:.2e}");
    relative
}

fn arrays(p: &Params) -> [(&'static str, Vec<f32>); 10] {
    [
        ("stiffness", p.spring_stiffness.clone()),
        ("dashpot", p.spring_dashpot.clone()),
        ("rest length", p.rest_lengths_m.clone()),
        ("bend stiffness", p.bend_stiffness.clone()),
        ("bend damping", p.bend_damping.clone()),
        ("rest angle", p.rest_angles_rad.clone()),
        ("twist stiffness", p.twist_stiffness.clone()),
        ("twist damping", p.twist_damping.clone()),
        ("rest twist", p.rest_twists_rad.clone()),
        ("drag", vec![p.drag]),
    ]
}

#[test]
#[ignore = "needs a CUDA device"]
fn gradients_agree() {
    for (name, model) in models() {
        for cut_every in [0, 1] {
            let request = GradientRequest {
                cut_every,
                controls: true,
                initial: true,
                final_state: true,
                ..GradientRequest::PARAMS
            };
            let [expected, found] = both(&model, seed(), 3).map(|(b, i)| {
                b.gradients(&[i], &request, &CancelToken::default()).expect("valid").remove(0)
            });
            let name = format!("{name}, cut {cut_every}");
            let mut worst = 0.0_f64;
            for ((what, a), (_, b)) in arrays(&expected.params).iter().zip(&arrays(&found.params)) {
                worst = worst.max(relative(&name, what, a, b));
            }
            let flat = |p: &[[f32; 3]]| p.as_flattened().to_vec();
            let (a, b) = (flat(&expected.controls), flat(&found.controls));
            worst = worst.max(relative(&name, "controls", &a, &b));
            let [a, b] = [&expected, &found].map(|g| {
                let state = g.initial.clone().unwrap_or_default();
                [flat(&state.positions), flat(&state.velocities)].concat()
            });
            worst = worst.max(relative(&name, "initial state", &a, &b));
            let [a, b] = [&expected, &found].map(|g| g.initial.clone().unwrap_or_default().twists);
            worst = worst.max(relative(&name, "initial twists", &a, &b));
            println!("{name}: {worst:.2e}");
        }
    }
}

#[test]
#[ignore = "needs a CUDA device"]
fn repeats_are_identical_in_any_batch() {
    let backend = backend();
    let outputs = Outputs { every: 1, final_state: true, ..Outputs::default() };
    let request = GradientRequest { controls: true, initial: true, ..GradientRequest::default() };
    let cancel = CancelToken::default();
    for (name, model) in models() {
        let one = instance(&*backend, &model, seed(), 2);
        let twice: Vec<_> = (0..2)
            .map(|_| {
                let batch = std::slice::from_ref(&one);
                let rollout = backend.roll_out(batch, &outputs, &cancel).expect("valid");
                (rollout, backend.gradients(batch, &request, &cancel).expect("valid"))
            })
            .collect();
        assert!(twice[0] == twice[1], "{name}");
    }
}
