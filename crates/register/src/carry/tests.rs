use super::*;
use crate::scene;

#[test]
fn the_rest_shape_follows_by_its_share() {
    let model = scene::model();
    let from = State::rest(&model.graph);
    let mut to = from.clone();
    to.positions.iter_mut().for_each(|p| p[0] *= 1.1);
    let controls = &model.graph.control_rest;
    assert_eq!(carried(&model, &from, &to, controls, 0.0), model.params);
    assert_eq!(carried(&model, &from, &from, controls, 1.0), model.params);
    let half = carried(&model, &from, &to, controls, 0.5);
    half.check(&model.graph).unwrap();
    let along = model.graph.springs.iter().position(|s| {
        let [a, b] = s.map(|e| model.graph.rest_endpoint(e));
        a[1] == b[1] && a[2] == b[2] && (s[1] as usize) < model.graph.node_count()
    });
    let along = along.unwrap();
    let ratio = half.rest_lengths_m[along] / model.params.rest_lengths_m[along];
    assert!((ratio - 1.05).abs() < 1e-4, "{ratio}");
}
