mod obstacles;

use bendtwin_core::{Skin, geometry::point_distance};
use bendtwin_engine::Backend;

use super::*;
use crate::{MAX_CAMERAS, scene};

/// A state that went astray: the truth, pushed by a smooth field of up to 2 cm, and its velocities
/// likewise.
fn astray(backend: &dyn Backend) -> (State, State, Vec<Point>) {
    let (truth, controls) = scene::moved(backend, 12);
    let mut state = truth.clone();
    for (i, rest) in scene::model().graph.rest_positions.iter().enumerate() {
        let far = rest[0] / 0.24;
        state.positions[i][2] -= 0.02 * far * far;
        state.velocities[i][1] += 0.3 * far * far;
    }
    (truth, state, controls)
}

fn observe(truth: &State, nodes: &[u32], noise_m: f32) -> Observation {
    let at: Vec<Point> = nodes.iter().map(|n| truth.positions[*n as usize]).collect();
    Observation {
        points: scene::noisy(&at, noise_m, 3),
        tracks: Some(Skin::at_nodes(nodes)),
        ..Observation::default()
    }
}

fn run(
    state: &State,
    controls: &[Point],
    observation: &Observation,
    options: &CorrectOptions,
) -> Result<Corrected, Error> {
    correct(
        &scene::model(),
        state,
        controls,
        &Around::default(),
        observation,
        options,
        &CancelToken::default(),
    )
}

const OPTIONS: CorrectOptions = CorrectOptions {
    noise_m: 0.002,
    give: 0.05,
    velocity_noise_m_s: 0.1,
    velocity_gain_per_s: 0.0,
    most_added_strain: 0.2,
    max_residual_m: None,
};

#[test]
fn a_fifth_of_the_nodes_brings_back_most_of_the_state() {
    let backend = bendtwin_engine::cpu();
    let (truth, state, controls) = astray(&*backend);
    let nodes: Vec<u32> = (0..truth.positions.len() as u32).step_by(5).collect();
    let observation = observe(&truth, &nodes, 0.001);
    let corrected = run(&state, &controls, &observation, &OPTIONS).unwrap();
    let (before, _) = scene::apart(&state.positions, &truth.positions);
    let (after, worst) = scene::apart(&corrected.state.positions, &truth.positions);
    assert!(after < 0.6 * before && worst < 0.015, "{before} {after} {worst}");
    assert!(corrected.after.median_mm < corrected.before.median_mm);
    // What the correction left is no start of an explosion.
    let frames = 10;
    let controls: Vec<Point> = (0..=frames).flat_map(|_| controls.clone()).collect();
    let later = scene::roll(&*backend, &corrected.state, controls.clone(), frames);
    let uncorrected = scene::roll(&*backend, &state, controls.clone(), frames);
    let true_later = scene::roll(&*backend, &truth, controls, frames);
    let (later, _) = scene::apart(&later.positions, &true_later.positions);
    let (uncorrected, _) = scene::apart(&uncorrected.positions, &true_later.positions);
    assert!(later < uncorrected, "{later} {uncorrected}");
}

#[test]
fn velocities_are_corrected_where_they_are_observed() {
    let backend = bendtwin_engine::cpu();
    let (truth, state, controls) = astray(&*backend);
    let nodes: Vec<u32> = (0..truth.positions.len() as u32).step_by(4).collect();
    let mut observation = observe(&truth, &nodes, 0.0);
    let kept = run(&state, &controls, &observation, &OPTIONS).unwrap();
    assert_eq!(kept.state.velocities, state.velocities);
    observation.velocities = nodes.iter().map(|n| truth.velocities[*n as usize]).collect();
    let corrected = run(&state, &controls, &observation, &OPTIONS).unwrap();
    let (before, _) = scene::apart(&state.velocities, &truth.velocities);
    let (after, _) = scene::apart(&corrected.state.velocities, &truth.velocities);
    assert!(after < 0.4 * before, "{before} {after}");
}

#[test]
fn a_cloud_without_tracks_pulls_the_surface_to_it() {
    let backend = bendtwin_engine::cpu();
    let (truth, mut state, controls) = astray(&*backend);
    // Half as far: the two sides of the object are 2 cm apart, and indistinguishable.
    for (x, truth) in state.positions.iter_mut().zip(&truth.positions) {
        *x = std::array::from_fn(|a| 0.5 * (x[a] + truth[a]));
    }
    let observation =
        Observation { points: scene::noisy(&truth.positions, 0.001, 5), ..Observation::default() };
    let corrected = run(&state, &controls, &observation, &OPTIONS).unwrap();
    let (before, _) = scene::apart(&state.positions, &truth.positions);
    let (after, _) = scene::apart(&corrected.state.positions, &truth.positions);
    assert!(after < 0.9 * before, "{before} {after}");
    assert!(corrected.after.mean_mm < corrected.before.mean_mm);
}

/// Median distances that a correction leaves of a cloud of the bent skin of a coarse bar [mm], and
/// the mean distance of the nodes from where they are, by the skin that the cloud is matched with.
fn left_of_a_bent_bar(skin: Option<Skin>) -> (f64, f64) {
    let mut model = scene::coarse();
    let bent = |p: &Point| [p[0], p[1], p[2] + 0.5 * p[0] * p[0]];
    let truth: Vec<Point> = model.graph.rest_positions.iter().map(bent).collect();
    let points = scene::noisy(&model.skin.positions(&truth), 0.0005, 7);
    if let Some(skin) = skin {
        model.skin = skin.into();
    }
    let observation = Observation { points, ..Observation::default() };
    let options = CorrectOptions { max_residual_m: Some(1.0), ..OPTIONS };
    let state = State::rest(&model.graph);
    let corrected = correct(
        &model,
        &state,
        &[],
        &Around::default(),
        &observation,
        &options,
        &CancelToken::default(),
    )
    .unwrap();
    let (off, _) = scene::apart(&corrected.state.positions, &truth);
    (corrected.after.median_mm, 1e3 * off)
}

#[test]
fn a_cloud_is_matched_with_the_skin_of_a_coarse_twin() {
    let at_nodes = Skin::of_nodes(&scene::coarse().graph);
    let (skin_mm, skin_off_mm) = left_of_a_bent_bar(None);
    let (nodes_mm, nodes_off_mm) = left_of_a_bent_bar(Some(at_nodes));
    // Nodes are 40 mm apart.
    assert!(skin_mm < 2.0 && skin_mm < 0.3 * nodes_mm, "{skin_mm} {nodes_mm}");
    assert!(skin_off_mm < 0.7 * nodes_off_mm, "{skin_off_mm} {nodes_off_mm}");
}

#[test]
fn points_that_went_astray_count_little() {
    let backend = bendtwin_engine::cpu();
    let (truth, state, controls) = astray(&*backend);
    let nodes: Vec<u32> = (0..truth.positions.len() as u32).step_by(3).collect();
    let mut observation = observe(&truth, &nodes, 0.001);
    for p in observation.points.iter_mut().step_by(7) {
        p[1] += 0.15;
    }
    let corrected = run(&state, &controls, &observation, &OPTIONS).unwrap();
    let (before, _) = scene::apart(&state.positions, &truth.positions);
    let (after, worst) = scene::apart(&corrected.state.positions, &truth.positions);
    assert!(after < 0.5 * before && worst < 0.015, "{before} {after} {worst}");
}

#[test]
fn strain_is_bounded_and_controls_stay() {
    let backend = bendtwin_engine::cpu();
    let (truth, state, controls) = astray(&*backend);
    let mut observation = observe(&truth, &[10], 0.0);
    observation.points[0][0] += 0.03;
    let options = CorrectOptions { give: 1.0, noise_m: 1e-4, most_added_strain: 0.05, ..OPTIONS };
    let options = CorrectOptions { max_residual_m: Some(1.0), ..options };
    let corrected = run(&state, &controls, &observation, &options).unwrap();
    let graph = &scene::model().graph;
    let strain = |s: &State, [a, b]: [usize; 2]| {
        let rest = point_distance(graph.rest_positions[a], graph.rest_positions[b]);
        (point_distance(s.positions[a], s.positions[b]) / rest - 1.0).abs()
    };
    let between = graph.springs.iter().map(|s| s.map(|e| e as usize));
    for ends in between.filter(|s| s[1] < graph.node_count()) {
        assert!(strain(&corrected.state, ends) < strain(&state, ends) + 0.0501, "{ends:?}");
    }
    assert!(corrected.moved_m > 1e-4);
}

#[test]
fn points_of_another_object_are_refused_with_numbers() {
    let backend = bendtwin_engine::cpu();
    let (truth, state, controls) = astray(&*backend);
    let nodes: Vec<u32> = (0..40).collect();
    let mut observation = observe(&truth, &nodes, 0.0);
    observation.points = scene::noisy(&observation.points, 0.2, 1);
    let error = run(&state, &controls, &observation, &OPTIONS).unwrap_err();
    assert!(matches!(error, Error::NotExplained { .. }), "{error}");
    assert!(error.to_string().contains("mm"), "{error}");
}

#[test]
fn absurd_input_is_refused_in_words() {
    let backend = bendtwin_engine::cpu();
    let (truth, state, controls) = astray(&*backend);
    let good = observe(&truth, &[1, 2], 0.0);
    let refused = |change: &dyn Fn(&mut Observation)| {
        let mut observation = good.clone();
        change(&mut observation);
        let error = run(&state, &controls, &observation, &OPTIONS).unwrap_err();
        assert!(matches!(error, Error::Invalid(_)), "{error}");
    };
    refused(&|o| o.points.clear());
    refused(&|o| o.points[0][1] = f32::NAN);
    refused(&|o| o.points[0][1] = 1e30);
    refused(&|o| o.points.push([0.0; 3]));
    refused(&|o| o.weights = vec![1.0]);
    refused(&|o| o.weights = vec![1.0, -1.0]);
    refused(&|o| o.weights = vec![0.0, 0.0]);
    refused(&|o| o.velocities = vec![[f32::INFINITY; 3]; 2]);
    refused(&|o| o.cameras = vec![[0.0; 3]; MAX_CAMERAS + 1]);
    refused(&|o| o.tracks = Some(Skin::at_nodes(&[0, 1_000_000])));
    refused(&|o| o.tracks = Some(Skin::at_nodes(&[])));
    refused(&|o| o.points = vec![[0.0; 3]; crate::MAX_POINTS + 1]);
    let short = State { velocities: Vec::new(), ..state.clone() };
    assert!(matches!(run(&short, &controls, &good, &OPTIONS), Err(Error::Invalid(_))));
    assert!(matches!(run(&state, &[], &good, &OPTIONS), Err(Error::Invalid(_))));
    let absurd = CorrectOptions { noise_m: f64::NAN, ..OPTIONS };
    assert!(matches!(run(&state, &controls, &good, &absurd), Err(Error::Invalid(_))));
    let stop = CancelToken::default();
    stop.cancel();
    let nothing = Around::default();
    let stopped = correct(&scene::model(), &state, &controls, &nothing, &good, &OPTIONS, &stop);
    assert_eq!(stopped, Err(Error::Cancelled));
}
