use std::sync::Arc;

use bendtwin_core::{
    Contact, Environment, Graph, NodeKind, Params, Timing, environment::ControlVelocity,
};

use super::*;
use crate::stable_substeps;

/// A straight chain of ten nodes 1 cm apart that hangs on a control point; its third spring is far
/// stiffer than the others.
fn chain(dashpot: f32) -> Model {
    let n = 10;
    let mut spring_stiffness = vec![50.0; n];
    spring_stiffness[3] = 5e3;
    Model {
        skin: Arc::default(),
        graph: Arc::new(Graph {
            rest_positions: (0..n).map(|i| [0.01 * i as f32, 0.0, 1.0]).collect(),
            kinds: vec![NodeKind::Observed; n],
            masses: vec![1.0; n],
            object_ids: vec![0; n],
            observed_points: vec![Graph::NOT_OBSERVED; n],
            control_rest: vec![[-0.01, 0.0, 1.0]],
            springs: (1..n as u32).map(|i| [i, i - 1]).chain([[0, n as u32]]).collect(),
            triplets: (2..n as u32).map(|i| [i - 2, i - 1, i]).collect(),
            pins: Vec::new(),
            ..Graph::default()
        }),
        params: Params {
            spring_stiffness,
            spring_dashpot: vec![dashpot; n],
            rest_lengths_m: vec![0.01; n],
            bend_stiffness: vec![1e-4; n - 2],
            bend_damping: vec![1e-6; n - 2],
            rest_angles_rad: vec![std::f32::consts::PI; n - 2],
            drag: 0.0,
            contact: Contact::default(),
            ..Params::default()
        },
        environment: Environment { gravity: [0.0, 0.0, -9.81], ground: None },
        timing: Timing { fps: 30.0, substeps: 200 },
        control_velocity: ControlVelocity::True,
    }
}

#[test]
fn what_is_stable_anyway_is_not_softened() {
    let model = chain(1.0);
    let needed = stable_substeps(&model).needed;
    assert!(needed > 4, "{needed}");
    let reduction = Reduction::to(&model, needed).unwrap();
    assert_eq!(reduction, Reduction { substeps: needed, rate_limit: None });
    let mut expected = model.clone();
    expected.timing.substeps = needed;
    assert_eq!(reduction.apply(&model), expected);
}

#[test]
fn only_what_is_too_stiff_gives_way() {
    let model = chain(1.0);
    let substeps = stable_substeps(&model).needed / 2;
    let reduction = Reduction::to(&model, substeps).unwrap();
    assert!(reduction.rate_limit.is_some());
    let soft = reduction.apply(&model);
    assert!(stable_substeps(&soft).needed <= substeps, "the variant is stable");
    let changed = |of: fn(&Params) -> &Vec<f32>| {
        let pairs = of(&soft.params).iter().zip(of(&model.params)).enumerate();
        pairs.filter(|(_, (a, b))| a < b).map(|(i, _)| i).collect::<Vec<_>>()
    };
    assert_eq!(changed(|p| &p.spring_stiffness), [3]);
    assert!(changed(|p| &p.bend_stiffness).is_empty());
}

#[test]
fn overdamped_models_lose_damping_first() {
    let model = chain(2e3);
    let substeps = stable_substeps(&model).needed / 3;
    let soft = Reduction::to(&model, substeps).unwrap().apply(&model);
    assert!(soft.params.spring_dashpot.iter().all(|d| *d < 2e3));
    assert!(soft.params.spring_stiffness.iter().all(|k| *k >= 49.9));
}

#[test]
fn the_backend_takes_every_variant_and_it_does_not_diverge() {
    use bendtwin_core::CancelToken;

    use crate::{
        Objective,
        backend::{Instance, Outputs},
        model::State,
    };
    let backend = crate::cpu_with_threads(1);
    for (dashpot, share) in [(1.0, 2), (1.0, 8), (2e3, 5)] {
        let model = chain(dashpot);
        let substeps = stable_substeps(&model).needed / share;
        let soft = Reduction::to(&model, substeps).unwrap().apply(&model);
        let loaded = backend.load(Arc::new(soft)).unwrap();
        let instance = Instance {
            initial: Arc::new(State::rest(&model.graph)),
            controls: Arc::new(vec![[-0.01, 0.0, 1.0]; 31]),
            frames: 30,
            model: loaded,
            objective: Objective::default(),
            world: Arc::default(),
            motion: Arc::default(),
        };
        let outputs = Outputs { final_state: true, ..Outputs::default() };
        let out = backend.roll_out(&[instance], &outputs, &CancelToken::default()).unwrap();
        assert_eq!(out[0].diverged, None);
    }
}

#[test]
fn what_cannot_be_softened_enough_or_makes_no_sense_has_no_reduction() {
    let model = chain(1.0);
    assert_eq!(Reduction::to(&model, 0), None);
    let mut broken = chain(1.0);
    broken.params.spring_dashpot.pop();
    assert_eq!(Reduction::to(&broken, 10), None);
}
