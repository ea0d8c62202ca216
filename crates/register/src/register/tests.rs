use std::sync::Arc;

use bendtwin_core::{Skin, geometry::point_distance};
use bendtwin_engine::Model;

use super::*;
use crate::scene;

fn run(observation: &Observation, options: &RegisterOptions) -> Result<Registered, Error> {
    let backend = bendtwin_engine::cpu();
    let loaded = backend.load(scene::model()).unwrap();
    register(&*backend, &loaded, observation, options, &CancelToken::default())
}

/// Positions turned about the vertical by an angle, and shifted.
fn carried(points: &[Point], angle: f32) -> Vec<Point> {
    let (s, c) = angle.sin_cos();
    let image = |p: &Point| [c * p[0] - s * p[1] + 0.4, s * p[0] + c * p[1] - 0.1, p[2] + 0.2];
    points.iter().map(image).collect()
}

/// A hanging object, turned by half a turn, and its control points.
fn truth(angle: f32) -> (Vec<Point>, Vec<Point>) {
    let backend = bendtwin_engine::cpu();
    let (state, controls) = scene::moved(&*backend, 15);
    let still = (0..=90).flat_map(|_| controls.clone()).collect();
    let state = scene::roll(&*backend, &state, still, 90);
    (carried(&state.positions, angle), carried(&controls, angle))
}

#[test]
fn a_cloud_with_noise_gaps_and_strangers_becomes_a_state() {
    let (nodes, _) = truth(3.0);
    // The end of the arm is hidden, and some points are of something else.
    let rest = &scene::model().graph.rest_positions;
    let seen: Vec<Point> =
        nodes.iter().zip(rest).filter(|(_, rest)| rest[0] < 0.19).map(|(p, _)| *p).collect();
    assert!(seen.len() < nodes.len() * 9 / 10);
    let mut points = scene::noisy(&seen, 0.002, 4);
    points.extend((0..4).map(|i| [0.4, 0.1, 0.5 + 0.02 * i as f32]));
    let observation = Observation { points, ..Observation::default() };
    let found = run(&observation, &RegisterOptions::default()).unwrap();
    assert!(found.residual.median_mm < 6.0, "{:?}", found.residual);
    assert!(found.explained.points > 0.8, "{:?}", found.explained);
    assert!(found.explained.surface < 1.0, "{:?}", found.explained);
    let (mean, _) = scene::apart(&found.state.positions, &nodes);
    assert!(mean < 0.015, "{mean}");
}

/// A coarse bar that is bent and carried elsewhere, registered to a cloud of its skin; the state's
/// nodes and where they should be.
fn bent_bar(skin: Option<Skin>) -> (Registered, Vec<Point>) {
    let mut model = scene::coarse();
    let bent = |p: &Point| [p[0], p[1], p[2] + 0.8 * p[0] * p[0]];
    let truth: Vec<Point> = model.graph.rest_positions.iter().map(bent).collect();
    let truth = carried(&truth, 0.7);
    let points = scene::noisy(&model.skin.positions(&truth), 0.0005, 7);
    if let Some(skin) = skin {
        model.skin = skin.into();
    }
    let observation = Observation { points, ..Observation::default() };
    let options =
        RegisterOptions { max_residual_m: Some(1.0), settle_frames: 0, ..Default::default() };
    let backend = bendtwin_engine::cpu();
    let loaded = backend.load(model.into()).unwrap();
    let cancel = CancelToken::default();
    (register(&*backend, &loaded, &observation, &options, &cancel).unwrap(), truth)
}

#[test]
fn a_coarse_twin_is_registered_by_its_skin() {
    let (by_skin, truth) = bent_bar(None);
    let (by_nodes, _) = bent_bar(Some(Skin::of_nodes(&scene::coarse().graph)));
    let [skin_mm, nodes_mm] = [&by_skin, &by_nodes].map(|r| r.residual.median_mm);
    // Nodes are 40 mm apart.
    assert!(skin_mm < 2.0 && skin_mm < 0.3 * nodes_mm, "{skin_mm} {nodes_mm}");
    let (off, _) = scene::apart(&by_skin.state.positions, &truth);
    assert!(off < 0.01, "{off}");
    assert!(by_skin.explained.points > 0.99, "{:?}", by_skin.explained);
    assert!(by_skin.explained.surface > 0.99, "{:?}", by_skin.explained);
}

#[test]
fn a_cloud_of_a_twin_without_skin_is_refused() {
    let model = Model { skin: Arc::default(), ..scene::coarse() };
    let points = model.graph.rest_positions.clone();
    let backend = bendtwin_engine::cpu();
    let loaded = backend.load(model.into()).unwrap();
    let observation = Observation { points, ..Observation::default() };
    let options = RegisterOptions::default();
    let refused = register(&*backend, &loaded, &observation, &options, &CancelToken::default());
    assert!(matches!(refused, Err(Error::Invalid(_))), "{refused:?}");
}

#[test]
fn tracks_and_known_controls_give_the_state_within_millimetres() {
    let (nodes, controls) = truth(-2.5);
    let chosen: Vec<u32> = (0..nodes.len() as u32).step_by(5).collect();
    let at: Vec<Point> = chosen.iter().map(|n| nodes[*n as usize]).collect();
    let observation = Observation {
        points: scene::noisy(&at, 0.001, 9),
        tracks: Some(Skin::at_nodes(&chosen)),
        ..Observation::default()
    };
    let options = RegisterOptions { controls: controls.clone(), ..RegisterOptions::default() };
    let found = run(&observation, &options).unwrap();
    assert_eq!(found.controls, controls);
    let (mean, worst) = scene::apart(&found.state.positions, &nodes);
    assert!(mean < 0.006 && worst < 0.02, "{mean} {worst}");
    // Force balance: a frame moves less than free fall from rest does (5.4 mm).
    assert!(found.drift_mm < 5.0, "{}", found.drift_mm);
    let free = run(&observation, &RegisterOptions::default()).unwrap();
    for (a, b) in free.controls.iter().zip(&controls) {
        assert!(point_distance(*a, *b) < 0.03, "{a:?} {b:?}");
    }
}

#[test]
fn points_of_something_else_are_refused_with_numbers() {
    let at = |i: usize| [0.5 * (i % 7) as f32, 0.4 * (i / 7) as f32, 0.3 * (i % 3) as f32];
    let observation = Observation { points: (0..49).map(at).collect(), ..Observation::default() };
    let error = run(&observation, &RegisterOptions::default()).unwrap_err();
    assert!(matches!(error, Error::NotExplained { .. }), "{error}");
    assert!(error.to_string().contains("mm"), "{error}");
}

#[test]
fn degenerate_points_panic_nowhere() {
    let line: Vec<Point> = (0..40).map(|i| [0.01 * i as f32, 0.0, 0.0]).collect();
    let far: Vec<Point> = line.iter().map(|p| [p[0] + 999.0, -999.0, 0.0]).collect();
    for points in [line, far, vec![[0.1; 3]; 30]] {
        let observation = Observation { points, ..Observation::default() };
        if let Ok(found) = run(&observation, &RegisterOptions::default()) {
            assert!(found.state.positions.iter().flatten().all(|x| x.is_finite()));
        }
    }
    for few in 0..LEAST_CLOUD {
        let observation = Observation { points: vec![[0.0; 3]; few], ..Observation::default() };
        let refused = run(&observation, &RegisterOptions::default());
        assert!(matches!(refused, Err(Error::Invalid(_))), "{few}: {refused:?}");
    }
    let one = Observation {
        points: vec![[0.5, 0.5, 0.5]],
        tracks: Some(Skin::at_nodes(&[3])),
        ..Observation::default()
    };
    let any =
        RegisterOptions { max_residual_m: Some(1.0), least_explained: 0.0, ..Default::default() };
    let found = run(&one, &any).unwrap();
    // It comes without a turn: nothing says that it turned.
    assert!(found.residual.median_mm < 50.0, "{:?}", found.residual);
}

#[test]
fn options_are_checked_and_cancellation_is_heard() {
    let (nodes, _) = truth(0.0);
    let observation = Observation { points: nodes, ..Observation::default() };
    let refused = |options: RegisterOptions| {
        assert!(matches!(run(&observation, &options), Err(Error::Invalid(_))), "{options:?}");
    };
    let default = RegisterOptions::default;
    refused(RegisterOptions { controls: vec![[0.0; 3]], ..default() });
    refused(RegisterOptions { controls: vec![[f32::NAN; 3]; 2], ..default() });
    refused(RegisterOptions { noise_m: 0.0, ..default() });
    refused(RegisterOptions { give: f64::NAN, ..default() });
    refused(RegisterOptions { settle_frames: usize::MAX, ..default() });
    refused(RegisterOptions { initial: Some((State::default(), Vec::new())), ..default() });
    let backend = bendtwin_engine::cpu();
    let loaded = backend.load(scene::model()).unwrap();
    let stop = CancelToken::default();
    stop.cancel();
    let stopped = register(&*backend, &loaded, &observation, &default(), &stop);
    assert_eq!(stopped, Err(Error::Cancelled));
}

#[test]
fn what_is_held_stays_and_what_is_free_leaves_obstacles() {
    let (nodes, controls) = truth(0.4);
    let chosen: Vec<u32> = (0..nodes.len() as u32).step_by(5).collect();
    let at: Vec<Point> = chosen.iter().map(|n| nodes[*n as usize]).collect();
    let observation = Observation {
        points: scene::noisy(&at, 0.001, 9),
        tracks: Some(Skin::at_nodes(&chosen)),
        ..Observation::default()
    };
    // The hand is open and elsewhere; a gripper holds two nodes. A slab cuts 5 mm off the lowest part.
    let held: Vec<(u32, Point)> = [40, 41].map(|n| (n, nodes[n as usize])).to_vec();
    let low = nodes.iter().map(|p| p[2]).fold(f32::MAX, f32::min) + 0.005;
    let slab = scene::cuboid([-2.0, -2.0, low - 0.3], [2.0, 2.0, low]);
    let around = Around { obstacles: vec![slab], loose: vec![0, 1] };
    let options = RegisterOptions {
        controls: controls.iter().map(|p| [p[0] + 0.5, p[1], p[2]]).collect(),
        held: held.clone(),
        around,
        ..RegisterOptions::default()
    };
    let found = run(&observation, &options).unwrap();
    for (node, place) in &held {
        assert_eq!(found.state.positions[*node as usize], *place);
    }
    for (node, p) in found.state.positions.iter().enumerate() {
        let is_held = held.iter().any(|h| h.0 as usize == node);
        assert!(is_held || p[2] >= low, "{node} {p:?} {low}");
    }
    let (mean, _) = scene::apart(&found.state.positions, &nodes);
    assert!(mean < 0.015, "{mean}");
    let wrong = RegisterOptions { held: vec![(100_000, [0.0; 3])], ..options };
    assert!(matches!(run(&observation, &wrong), Err(Error::Invalid(_))));
}
