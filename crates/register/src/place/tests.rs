use super::*;
use crate::scene::{apart, model, noisy};

/// Bent upwards, turned about the vertical and moved.
fn bent(points: &[Point]) -> Vec<Point> {
    let (s, c) = 1.9_f32.sin_cos();
    let place = |[x, y, z]: &Point| [c * x - s * y + 0.4, s * x + c * y - 0.2, z + 0.1 + x * x];
    points.iter().map(place).collect()
}

#[test]
fn a_turned_and_bent_object_is_found_without_physics() {
    let model = model();
    let truth = bent(&model.graph.rest_positions);
    let seen = Observation { points: noisy(&truth, 0.001, 3), ..Observation::default() };
    let options = RegisterOptions::default();
    let placed =
        place(&model.graph, &model.skin, &seen, &options, &CancelToken::default()).unwrap();
    let (mean, _) = apart(&placed.positions, &truth);
    assert!(mean < 0.008, "{mean} m off, residual {:?}", placed.residual);
    assert!(placed.explained.points > 0.9, "{:?}", placed.explained);
    // The graph's own control points say nothing about another recording.
    let mut other = model.graph.as_ref().clone();
    other.control_rest[0] = [9.0; 3];
    let again = place(&other, &model.skin, &seen, &options, &CancelToken::default()).unwrap();
    assert_eq!(again, placed);
}

#[test]
fn another_object_is_refused() {
    let model = model();
    let points = (0..200).map(|i| [0.05 * (i % 20) as f32, 0.05 * (i / 20) as f32, 0.0]).collect();
    let seen = Observation { points, ..Observation::default() };
    let options = RegisterOptions::default();
    let refused = place(&model.graph, &model.skin, &seen, &options, &CancelToken::default());
    assert!(matches!(refused, Err(Error::NotExplained { .. })), "{refused:?}");
    let few = Observation { points: vec![[0.0; 3]; 3], ..Observation::default() };
    let refused = place(&model.graph, &model.skin, &few, &options, &CancelToken::default());
    assert!(matches!(refused, Err(Error::Invalid(_))), "{refused:?}");
}
