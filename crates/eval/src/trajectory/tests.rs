use super::*;
use crate::scene;

#[test]
fn two_start_frames_give_a_velocity() {
    let mut capture = scene::chain(3, 3, 3, [0.0, 0.01, 0.0]);
    capture.sequences[0].start_frames = 2;
    let state = initial_state(&scene::chain_graph(3), 100.0, &capture.sequences[0]);
    assert_eq!(state.positions, capture.sequences[0].points_at(1));
    assert!(state.velocities.iter().all(|v| (v[1] - 1.0).abs() < 1e-4));
}

#[test]
fn hidden_nodes_move_with_their_nearest_neighbour() {
    let mut capture = scene::chain(3, 2, 2, [0.0; 3]);
    let s = &mut capture.sequences[0];
    for p in &mut s.points[..3] {
        p[2] += 0.5;
    }
    s.visible[2] = false;
    s.points[2] = [f32::NAN; 3];
    let state = initial_state(&scene::chain_graph(3), 100.0, s);
    assert_eq!(state.positions[2], [0.2, 0.0, 1.5]);
}

#[test]
fn predictions_cover_every_frame() {
    let mut capture = scene::chain(4, 7, 5, [0.0, 0.0, 0.01]);
    capture.sequences[0].start_frames = 2;
    let predictions = predict(
        &*bendtwin_engine::cpu_with_threads(1),
        &scene::chain_twin(4),
        &capture,
        &CancelToken::default(),
    )
    .unwrap();
    let p = &predictions[0];
    assert_eq!(p.at(0), None);
    assert_eq!(p.at(7), None);
    assert!((1..7).all(|f| p.at(f).is_some_and(|x| x.len() == 4)));
    // Held nodes are where their control points are.
    assert_eq!(p.at(6).unwrap()[0], capture.sequences[0].points_at(6)[0]);
}
