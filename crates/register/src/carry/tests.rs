use super::*;
use crate::scene;

#[test]
fn the_rest_shape_follows_by_its_share() {
    let model = scene::model();
    let from = State::rest(&model.graph);
    let mut to = from.clone();
    to.positions.iter_mut().for_each(|p| p[0] *= 1.1);
    let (controls, own) = (&model.graph.control_rest, &model.params);
    assert_eq!(carried(&model, own, &from, &to, controls, 0.0), model.params);
    assert_eq!(carried(&model, own, &from, &from, controls, 1.0), model.params);
    let half = carried(&model, own, &from, &to, controls, 0.5);
    half.check(&model.graph).unwrap();
    let along = model.graph.springs.iter().position(|s| {
        let [a, b] = s.map(|e| model.graph.rest_endpoint(e));
        a[1] == b[1] && a[2] == b[2] && (s[1] as usize) < model.graph.node_count()
    });
    let along = along.unwrap();
    let ratio = half.rest_lengths_m[along] / model.params.rest_lengths_m[along];
    assert!((ratio - 1.05).abs() < 1e-4, "{ratio}");
}

#[test]
fn carried_corrections_add_up_within_bounds() {
    let mut model = Model::clone(&scene::model());
    let own = model.params.clone();
    let from = State::rest(&model.graph);
    for (factor, expected) in [(1.2, 2.0), (0.8, 2.0 / 3.0)] {
        model.params = own.clone();
        let mut to = from.clone();
        to.positions.iter_mut().flatten().for_each(|x| *x *= factor);
        let controls = model.graph.control_rest.clone();
        for _ in 0..20 {
            model.params = carried(&model, &own, &from, &to, &controls, 1.0);
        }
        model.params.check(&model.graph).unwrap();
        let inner =
            model.graph.springs.iter().position(|s| (s[1] as usize) < model.graph.node_count());
        let inner = inner.unwrap();
        let ratio = model.params.rest_lengths_m[inner] / own.rest_lengths_m[inner];
        assert!((ratio - expected).abs() < 1e-4, "{factor}: {ratio}");
    }
}

#[test]
fn what_is_within_the_noise_does_not_last() {
    let at = |median_mm| {
        let before = crate::Residual { median_mm, ..crate::Residual::default() };
        let state = State::default();
        Corrected { state, before, after: before, moved_m: 0.0, misfit: 0.0 }.beyond_noise(0.005)
    };
    assert_eq!(at(0.0), 0.0);
    assert!((at(5.0) - 0.5).abs() < 1e-9);
    assert!(at(50.0) > 0.98);
}
