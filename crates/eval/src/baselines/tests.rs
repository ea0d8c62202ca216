use super::*;
use crate::scene;

#[test]
fn harmonic_shares_are_linear_along_a_cable() {
    let mut graph = scene::chain_graph(5);
    // Unequal edges: shares follow length, not index.
    graph.rest_positions[1][0] = 0.05;
    let shares = harmonic_shares(&graph);
    for (i, x) in graph.rest_positions.iter().enumerate() {
        let along = f64::from(x[0]) / 0.4;
        assert!((shares[1][i] - along).abs() < 1e-6, "node {i}: {} for {along}", shares[1][i]);
        assert!((shares[0][i] + shares[1][i] - 1.0).abs() < 1e-6);
    }
}

#[test]
fn interpolation_follows_clamps_that_move_together() {
    let capture = scene::chain(5, 4, 4, [0.01, 0.0, -0.02]);
    let (graph, sequence) = (scene::chain_graph(5), &capture.sequences[0]);
    let start = sequence.points_at(0);
    let prediction = clamp_interpolation(&capture, &graph, sequence, start).unwrap();
    for frame in 0..4 {
        for (a, b) in prediction.at(frame).unwrap().iter().zip(sequence.points_at(frame)) {
            assert!(euclidean(*a, *b) < 1e-6);
        }
    }
}

#[test]
fn standing_still_moves_only_what_is_held() {
    let capture = scene::chain(4, 3, 3, [0.0, 0.1, 0.0]);
    let (graph, sequence) = (scene::chain_graph(4), &capture.sequences[0]);
    let prediction = standing_still(&graph, sequence, sequence.points_at(0));
    let last = prediction.at(2).unwrap();
    assert_eq!(last[1], sequence.points_at(0)[1]);
    assert_eq!(last[0], sequence.points_at(2)[0]);
    assert_eq!(last[3], sequence.points_at(2)[3]);
}

#[test]
fn the_last_residual_is_exact_in_the_last_training_frame() {
    let capture = scene::chain(4, 6, 4, [0.0, 0.1, 0.0]);
    let (graph, sequence) = (scene::chain_graph(4), &capture.sequences[0]);
    let still = standing_still(&graph, sequence, sequence.points_at(0));
    let points = Surface::of_nodes(&graph);
    let corrected = last_residual(&points, sequence, &still).unwrap();
    for (a, b) in corrected.at(3).unwrap().iter().zip(sequence.points_at(3)) {
        assert!(euclidean(*a, *b) < 1e-6);
    }
    let mut whole = sequence.clone();
    whole.train_frame_count = 6;
    assert_eq!(last_residual(&points, &whole, &still), None);
}
