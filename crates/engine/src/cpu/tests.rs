//! Tests of the backend as a client sees it.

use std::sync::Arc;

use bendtwin_core::{
    Contact, Environment, Graph, NodeKind, Params, Timing, environment::ControlVelocity,
};

use super::*;
use crate::{Objective, model::State};

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
    };
    let (e, t) = (graph.springs.len(), graph.triplets.len());
    Model {
        params: Params {
            spring_stiffness: vec![100.0; e],
            spring_dashpot: vec![0.0; e],
            rest_lengths_m: vec![1.0; e],
            bend_stiffness: vec![1.0; t],
            bend_damping: vec![0.0; t],
            rest_angles_rad: vec![std::f32::consts::PI; t],
            drag: 0.0,
            contact: Contact::default(),
        },
        graph: Arc::new(graph),
        environment: Environment { gravity: [0.0; 3], ground: None },
        timing: Timing { fps: 30.0, substeps: 667 },
        control_velocity: ControlVelocity::True,
    }
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
    };
    let recording =
        Recording { every: 1, final_state: true, diagnostics: true, ..Recording::default() };
    backend.roll_out(&[instance], &recording, &CancelToken::default()).unwrap().remove(0)
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
