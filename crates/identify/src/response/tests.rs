use bendtwin_core::identifiability::Quantity;
use bendtwin_engine::{
    PointLoss, PointSet, Term, backend::GradientRequest, cpu_with_threads, objective::WeightedTerm,
};

use crate::{Regions, directions::directions, motions, strip::strip};

use super::*;

/// The differences of rollouts are the derivatives that the adjoint gives of a loss whose gradient by
/// each coordinate is known.
#[test]
fn responses_are_those_of_the_adjoint() {
    let twin = strip(false);
    let regions = Regions::of(&twin);
    let backend = cpu_with_threads(2);
    let mut scene = motions::scene(&twin, &regions, None, motions::Hold::Own, motions::Act::Hang);
    scene.frames = 12;
    scene.controls = scene.controls[..13 * 4].to_vec().into();
    let nodes = twin.graph.node_count();
    let cancel = CancelToken::default();
    let sample = Sample { frame: 12, skin: Arc::new(twin.skin.clone()) };
    let all = directions(&twin, &regions);
    let variations: Vec<Variation> = all.iter().map(|d| Variation::Along(*d)).collect();
    let samples = std::slice::from_ref(&sample);
    let response = scene
        .respond(&*backend, &regions.of_nodes, &variations, samples, 12, &cancel)
        .unwrap()
        .unwrap();
    // Mean squared distance from where the points are, less a centimetre along z.
    let base = scene.base(&*backend, &cancel).unwrap().unwrap();
    let at = &base.positions[11 * nodes..];
    let targets = at.iter().map(|p| [p[0], p[1], p[2] - 0.01]).collect();
    let loaded = backend.load(Arc::new(scene.model.clone())).unwrap();
    let mut instance = scene.instance(loaded, scene.controls.clone());
    let term = Term::Track {
        of: PointSet::Nodes,
        points: (0..nodes as u32).collect(),
        targets,
        loss: PointLoss::SquaredDistance,
    };
    instance.objective.groups = vec!["track".into()];
    instance.objective.terms =
        Arc::new(vec![WeightedTerm { frame: 12, weight: 1.0, group: 0, term }]);
    let gradient =
        backend.gradients(&[instance], &GradientRequest::PARAMS, &cancel).unwrap().remove(0).params;
    let params = &twin.params;
    for (direction, column) in all.iter().zip(&response.columns) {
        let differences: f64 = (0..nodes).map(|i| f64::from(column[3 * i + 2])).sum();
        let differences = differences * 2.0 * 0.01 / nodes as f64;
        // The derivative along the direction, from that by each parameter.
        let (high, _) =
            direction.apply(&twin.graph, params, &regions.of_nodes, &twin.hands(), 1e-2);
        let along = |of: fn(&Params) -> &[f32]| -> f64 {
            let moved = of(&high).iter().zip(of(params));
            moved.zip(of(&gradient)).map(|((h, p), g)| f64::from((h - p) * g)).sum()
        };
        let drag = f64::from((high.drag - params.drag) * gradient.drag);
        let adjoint = along(|p| &p.spring_stiffness)
            + along(|p| &p.rest_lengths_m)
            + along(|p| &p.spring_dashpot)
            + drag;
        let adjoint = adjoint / 1e-2 * prior_sd(direction.quantity);
        let scale = match direction.quantity {
            Quantity::Drag | Quantity::Dashpot => 2e-5,
            _ => 2e-6,
        };
        let off = (adjoint - differences).abs();
        assert!(off < 0.1 * adjoint.abs() + scale, "{direction:?}: {adjoint} {differences}");
    }
    let largest = response.columns.iter().flatten().fold(0.0_f32, |m, x| m.max(x.abs()));
    assert!(largest > 1e-3, "nothing moved: {largest}");
}

#[test]
fn an_end_that_diverged_is_replaced_by_the_middle() {
    let direction = Direction { quantity: Quantity::Stiffness, region: Some(0), hand: None };
    let of = |ends: [(Option<Vec<f32>>, f64); 2]| {
        difference(&Variation::Along(direction), &[1.0], &ends)[0]
    };
    let sd = prior_sd(Quantity::Stiffness) as f32;
    let both = of([(Some(vec![1.1]), 0.1), (Some(vec![0.9]), -0.1)]);
    assert!((both - sd).abs() < 1e-5, "{both}");
    let one = of([(None, 0.1), (Some(vec![0.9]), -0.1)]);
    assert!((one - sd).abs() < 1e-5, "{one}");
    assert_eq!(of([(None, 0.1), (None, -0.1)]), 0.0);
}
