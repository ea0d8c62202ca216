//! Tests of the backend as a client sees it.

use std::sync::Arc;

use bendtwin_core::{
    Contact, Environment, Graph, NodeKind, Params, Pin, Plane, Timing, environment::ControlVelocity,
};

use super::*;
use crate::{
    Objective, PointSet, Term,
    backend::Diagnose,
    model::State,
    objective::{PointLoss, WeightedTerm},
    reference::Reference,
};

/// A graph of surface nodes with the given elements, rest shape as is.
fn model(
    positions: Vec<[f32; 3]>,
    controls: Vec<[f32; 3]>,
    springs: Vec<[u32; 2]>,
    triplets: Vec<[u32; 3]>,
) -> Model {
    let n = positions.len();
    let graph = Graph {
        kinds: vec![NodeKind::Observed; n],
        masses: vec![1.0; n],
        object_ids: vec![0; n],
        observed_points: vec![Graph::NOT_OBSERVED; n],
        rest_positions: positions,
        control_rest: controls,
        springs,
        triplets,
        pins: vec![],
        ..Graph::default()
    };
    let (e, t) = (graph.springs.len(), graph.triplets.len());
    Model {
        skin: Arc::default(),
        params: Params {
            spring_stiffness: vec![100.0; e],
            spring_dashpot: vec![0.0; e],
            rest_lengths_m: vec![1.0; e],
            bend_stiffness: vec![1.0; t],
            bend_damping: vec![0.0; t],
            rest_angles_rad: vec![std::f32::consts::PI; t],
            drag: 0.0,
            contact: Contact::default(),
            ..Params::default()
        },
        graph: Arc::new(graph),
        environment: Environment { gravity: [0.0; 3], ground: None },
        timing: Timing { fps: 30.0, substeps: 667 },
        control_velocity: ControlVelocity::True,
    }
}

/// Rest length of each spring as it lies.
fn relax(model: &mut Model) {
    for (s, &[a, b]) in model.graph.springs.iter().enumerate() {
        let (a, b) = (model.graph.rest_endpoint(a), model.graph.rest_endpoint(b));
        model.params.rest_lengths_m[s] = (0..3).map(|c| (a[c] - b[c]).powi(2)).sum::<f32>().sqrt();
    }
}

/// A hanging chain of `n` nodes, pinned at its first, over a ground.
fn chain(n: u32) -> Model {
    let positions = (0..n).map(|i| [0.04 * i as f32, 0.0, 0.1]).collect();
    let springs = (1..n).map(|i| [i - 1, i]).chain([[1, n]]).collect();
    let triplets = (1..n - 1).map(|i| [i - 1, i, i + 1]).collect();
    let mut model = model(positions, vec![[0.0, 0.0, 0.1]], springs, triplets);
    relax(&mut model);
    let pins = vec![Pin { node: 0, control: 0, offset_m: [0.0; 3] }];
    model.graph = Arc::new(Graph { pins, ..Graph::clone(&model.graph) });
    model.params.spring_dashpot.fill(3.0);
    model.params.bend_stiffness.fill(0.01);
    model.params.bend_damping.fill(1e-3);
    model.params.drag = 0.5;
    model.environment = Environment {
        ground: Some(Plane { normal: [0.0, 0.0, 1.0], offset_m: 0.0 }),
        ..Environment::Z_UP
    };
    model.timing.substeps = 200;
    model
}

fn instance(backend: &dyn Backend, model: Model, frames: usize) -> Instance {
    let initial = State::rest(&model.graph);
    let controls = model.graph.control_rest.repeat(frames + 1);
    let targets: Vec<_> = model.graph.rest_positions.iter().map(|p| [p[0], p[1], 0.01]).collect();
    let terms = (1..=frames).map(|frame| WeightedTerm {
        frame,
        weight: 1.0,
        group: 0,
        term: Term::Chamfer { of: PointSet::Nodes, targets: targets.clone() },
    });
    let terms = if targets.is_empty() { Vec::new() } else { terms.collect() };
    Instance {
        model: backend.load(Arc::new(model)).unwrap(),
        initial: Arc::new(initial),
        controls: Arc::new(controls),
        frames,
        objective: Objective { groups: vec!["chamfer".into()], terms: Arc::new(terms) },
        world: Arc::default(),
        motion: Arc::default(),
    }
}

fn everything() -> (Outputs, GradientRequest) {
    (
        Outputs {
            every: 1,
            initial: true,
            final_state: true,
            diagnose: Diagnose::All,
            ..Outputs::default()
        },
        GradientRequest {
            controls: true,
            initial: true,
            final_state: true,
            cut_every: 0,
            ..GradientRequest::default()
        },
    )
}

fn roll(model: Model, initial: State, frames: usize) -> Rollout {
    let backend = cpu_with_threads(1);
    let controls = vec![[0.0; 3]; (frames + 1) * model.graph.control_count()];
    let loaded = backend.load(Arc::new(model)).unwrap();
    let instance = Instance {
        model: loaded,
        initial: Arc::new(initial),
        controls: Arc::new(controls),
        frames,
        objective: Objective::default(),
        world: Arc::default(),
        motion: Arc::default(),
    };
    let outputs =
        Outputs { every: 1, final_state: true, diagnose: Diagnose::All, ..Outputs::default() };
    backend.roll_out(&[instance], &outputs, &CancelToken::default()).unwrap().remove(0)
}

#[test]
fn two_nodes_oscillate_at_their_frequency() {
    let model = model(vec![[0.0; 3], [1.0, 0.0, 0.0]], vec![], vec![[0, 1]], vec![]);
    let mut initial = State::rest(&model.graph);
    initial.positions[1][0] = 1.1;
    let out = roll(model, initial, 30);
    let omega = 200.0_f64.sqrt();
    for (f, x) in out.positions.chunks(2).enumerate() {
        let t = (f + 1) as f64 / 30.0;
        let gap = f64::from(x[1][0] - x[0][0]);
        assert!((gap - (1.0 + 0.1 * (omega * t).cos())).abs() < 2e-4, "frame {f}: {gap}");
    }
    assert!(out.diverged.is_none());
}

#[test]
fn single_precision_agrees_with_the_reference() {
    let backend = cpu_with_threads(1);
    let model = chain(13);
    let batch = [instance(&*backend, model.clone(), 6)];
    let (outputs, request) = everything();
    let cancel = CancelToken::default();
    let out = backend.roll_out(&batch, &outputs, &cancel).unwrap().remove(0);
    let reference = Reference::new(&model, 6).unwrap();
    let exact = reference.roll_out().unwrap();
    for (f, state) in exact.iter().enumerate() {
        let found = &out.positions[f * 13..(f + 1) * 13];
        for (a, b) in state.positions.iter().flatten().zip(found.iter().flatten()) {
            assert!((a - f64::from(*b)).abs() < 2e-5, "frame {f}: {a} {b}");
        }
    }
    let gradient = backend.gradients(&batch, &request, &cancel).unwrap().remove(0);
    let exact = reference.gradient(&batch[0].objective, 0).unwrap();
    assert!((gradient.loss.total - exact.loss.total).abs() < 1e-4 * exact.loss.total);
    assert_eq!(gradient.loss.total, out.cost);
    assert_eq!(gradient.final_state, out.final_state);
    let pairs = [
        (&gradient.params.spring_stiffness, &exact.parameters.spring_stiffness),
        (&gradient.params.bend_stiffness, &exact.parameters.bend_stiffness),
        (&gradient.params.bend_damping, &exact.parameters.bend_damping),
        (&gradient.params.rest_lengths_m, &exact.parameters.rest_lengths_m),
    ];
    for (found, exact) in pairs {
        let scale = exact.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
        for (a, b) in exact.iter().zip(found) {
            assert!((a - f64::from(*b)).abs() < 1e-2 * scale, "{a} {b}");
        }
    }
}

#[test]
fn results_repeat_bit_for_bit_on_any_number_of_threads() {
    let (outputs, request) = everything();
    let cancel = CancelToken::default();
    let run = |threads: usize| {
        let backend = cpu_with_threads(threads);
        let batch: Vec<_> = (3..9).map(|n| instance(&*backend, chain(n), 4)).collect();
        (
            backend.roll_out(&batch, &outputs, &cancel).unwrap(),
            backend.gradients(&batch, &request, &cancel).unwrap(),
        )
    };
    let one = run(1);
    assert_eq!(one, run(1));
    assert_eq!(one, run(3));
}

#[test]
fn a_rollout_may_be_cut_at_any_frame() {
    let backend = cpu_with_threads(1);
    let (outputs, _) = everything();
    let cancel = CancelToken::default();
    let mut whole = instance(&*backend, chain(7), 6);
    let moving = (0..7).map(|f| [0.01 * f as f32, 0.003 * (f * f) as f32, 0.1]).collect();
    whole.controls = Arc::new(moving);
    let undivided = backend.roll_out(&[whole.clone()], &outputs, &cancel).unwrap().remove(0);
    let part = |initial: Arc<State>, rows: std::ops::Range<usize>| {
        let frames = rows.len() - 1;
        let controls = Arc::new(whole.controls[rows].to_vec());
        let objective = Objective::default();
        let part = Instance { initial, controls, frames, objective, ..whole.clone() };
        backend.roll_out(&[part], &outputs, &cancel).unwrap().remove(0).final_state.unwrap()
    };
    let middle = part(whole.initial.clone(), 0..3);
    assert_eq!(undivided.final_state.unwrap(), part(Arc::new(middle), 2..7));
}

#[test]
fn pinned_nodes_follow_their_control_point() {
    let backend = cpu_with_threads(1);
    let mut moving = instance(&*backend, chain(5), 3);
    moving.controls =
        Arc::new(vec![[0.1, 0.2, 0.3], [0.13, 0.2, 0.3], [0.13, 0.26, 0.3], [0.0, 0.0, 0.0]]);
    let (outputs, _) = everything();
    let out = backend.roll_out(&[moving.clone()], &outputs, &CancelToken::default()).unwrap();
    for (row, control) in moving.controls.iter().enumerate() {
        assert_eq!(out[0].positions[row * 5], *control);
    }
    let velocity = out[0].final_state.as_ref().unwrap().velocities[0];
    assert!((velocity[0] + 0.13 * 30.0).abs() < 1e-4);
}

#[test]
fn degenerate_models_stay_finite() {
    let backend = cpu_with_threads(1);
    let (outputs, request) = everything();
    let coincident = model(vec![[0.1; 3]; 3], vec![], vec![[0, 1], [1, 2]], vec![[0, 1, 2]]);
    let mut no_rest = coincident.clone();
    no_rest.params.rest_lengths_m.fill(0.0);
    let models = [
        model(vec![], vec![], vec![], vec![]),
        model(vec![], vec![[0.0; 3]], vec![], vec![]),
        model(vec![[0.0; 3]], vec![], vec![], vec![]),
        coincident,
        no_rest,
        model(vec![[0.0; 3], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0]], vec![], vec![], vec![[0, 1, 2]]),
        model(vec![[0.0; 3], [1.0, 0.0, 0.0], [0.5, 0.0, 0.0]], vec![], vec![], vec![[0, 1, 2]]),
    ];
    for (i, mut model) in models.into_iter().enumerate() {
        model.params.contact.within_object = true;
        for frames in [0, 2] {
            let batch = [instance(&*backend, model.clone(), frames)];
            let cancel = CancelToken::default();
            let out = backend.roll_out(&batch, &outputs, &cancel).unwrap().remove(0);
            assert!(out.cost.is_finite() && out.diverged.is_none(), "model {i}");
            assert!(out.positions.iter().flatten().all(|x| x.is_finite()), "model {i}");
            assert_eq!(out.frames.len(), frames + 1);
            let g = backend.gradients(&batch, &request, &cancel).unwrap().remove(0);
            assert!(g.params.spring_stiffness.iter().all(|x| x.is_finite()), "model {i}");
            assert!(g.initial.unwrap().positions.iter().flatten().all(|x| x.is_finite()));
        }
    }
}

#[test]
fn divergence_says_where_and_is_no_error() {
    let backend = cpu_with_threads(2);
    let calm = instance(&*backend, chain(4), 5);
    let mut wild = calm.clone();
    let mut initial = State::clone(&wild.initial);
    initial.velocities[2] = [0.0, 3e38, 0.0];
    wild.initial = Arc::new(initial);
    let (outputs, request) = everything();
    let cancel = CancelToken::default();
    let out = backend.roll_out(&[calm, wild.clone()], &outputs, &cancel).unwrap();
    assert!(out[0].diverged.is_none() && out[0].cost.is_finite());
    let at = out[1].diverged.unwrap();
    assert_eq!(at.frame, 1);
    assert!(out[1].cost.is_infinite() && out[1].group_costs[0].is_infinite());
    assert_eq!((out[1].frames.len(), out[1].positions.len()), (1, 4));
    let g = backend.gradients(&[wild], &request, &cancel).unwrap().remove(0);
    assert!(g.loss.total.is_infinite() && g.final_state.is_none());
    assert!(g.params.spring_stiffness.iter().all(|&x| x == 0.0));
    assert!(g.controls.iter().flatten().all(|x| x.is_nan()));
}

#[test]
fn wrong_inputs_are_refused() {
    let backend = cpu_with_threads(1);
    let good = instance(&*backend, chain(4), 2);
    let cancel = CancelToken::default();
    type Break = fn(&mut Instance);
    let broken: [Break; 8] = [
        |i| i.frames = 3,
        |i| i.frames = usize::MAX - 1,
        |i| i.controls = Arc::new(vec![[f32::NAN; 3]; 3]),
        |i| i.initial = Arc::new(State::default()),
        |i| Arc::make_mut(&mut i.initial).positions[0][1] = f32::INFINITY,
        |i| Arc::make_mut(&mut i.objective.terms)[0].frame = 3,
        |i| Arc::make_mut(&mut i.objective.terms)[0].group = 1,
        |i| {
            Arc::make_mut(&mut i.objective.terms)[0].term = Term::Track {
                of: PointSet::Nodes,
                points: vec![4],
                targets: vec![[0.0; 3]],
                loss: PointLoss::Distance,
            };
        },
    ];
    for (b, break_it) in broken.into_iter().enumerate() {
        let mut bad = good.clone();
        break_it(&mut bad);
        let error = backend.losses(&[good.clone(), bad], &cancel).unwrap_err();
        assert!(
            matches!(&error, Error::InvalidInput(m) if m.contains("instance 1")),
            "{b}: {error}"
        );
    }
    let nodes = Some(Arc::new(vec![4]));
    let outputs = Outputs { nodes, ..Outputs::default() };
    assert!(backend.roll_out(&[good], &outputs, &cancel).is_err());
}

#[test]
fn unstable_substeps_are_refused_with_the_number_needed() {
    let backend = cpu_with_threads(1);
    let mut model = chain(6);
    model.timing.substeps = 1;
    let Error::Unstable { substeps: 1, needed, .. } =
        backend.load(Arc::new(model.clone())).unwrap_err()
    else {
        panic!("not refused");
    };
    model.timing.substeps = needed;
    assert!(backend.load(Arc::new(model)).is_ok());
}

#[test]
fn cancelling_stops_the_batch() {
    let backend = cpu_with_threads(1);
    let batch = [instance(&*backend, chain(4), 2)];
    let cancel = CancelToken::default();
    cancel.cancel();
    assert_eq!(backend.losses(&batch, &cancel), Err(Error::Cancelled));
    let (_, request) = everything();
    assert_eq!(backend.gradients(&batch, &request, &cancel), Err(Error::Cancelled));
}

#[test]
fn parameters_can_be_exchanged() {
    let backend = cpu_with_threads(1);
    let soft = instance(&*backend, chain(4), 3);
    let mut params = soft.model.model().params.clone();
    params.bend_stiffness.fill(0.0);
    let mut model = chain(4);
    model.params = params.clone();
    let loaded = Instance { model: backend.load(Arc::new(model)).unwrap(), ..soft.clone() };
    let swapped = backend.with_params(&soft.model, params.clone()).unwrap();
    let swapped = Instance { model: swapped, ..soft.clone() };
    let out = backend.losses(&[soft.clone(), loaded, swapped], &CancelToken::default()).unwrap();
    assert_eq!(out[1], out[2]);
    assert_ne!(out[0], out[1]);
    params.bend_stiffness.pop();
    assert!(matches!(backend.with_params(&soft.model, params), Err(Error::InvalidModel(_))));
}
