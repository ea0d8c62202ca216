//! Registrations of the small twin, and corrections of a session of it.

use bendtwin_core::Point;
use bendtwin_engine::model::State;
use bendtwin_proto::v1::{
    CorrectOptions, Observation, Plane, RegisterOptions, RegisterStateRequest, RegisteredState,
    World, observation::Tracks, world::GroundChoice,
};

use super::*;
use crate::{
    register::register_state,
    request::initial::Start,
    session::{
        Session, Setup,
        correct::{CorrectionInput, corrected},
    },
};

const BY: Point = [0.3, -0.1, 0.2];

pub(super) fn at_rest(bench: &Bench) -> Start {
    let graph = &bench.warm.twin.graph;
    let controls = Arc::new(graph.control_rest.clone());
    Start::new(Arc::new(State::rest(graph)), controls)
}

/// Observation of these node positions.
pub(super) fn tracked(points: &[Point]) -> Option<Observation> {
    let nodes: Vec<u32> = (0..points.len() as u32).collect();
    Some(Observation {
        points: Some(Tensor::pack_points(&[points.len()], points)),
        tracks: Some(Tracks::Nodes(Tensor::pack(&[nodes.len()], &nodes))),
        ..Observation::default()
    })
}

/// A registration of the nodes to these points, with `frames` frames of physics.
fn request(points: &[Point], frames: u32) -> RegisterStateRequest {
    let options = RegisterOptions { settle_frames: Some(frames), ..RegisterOptions::default() };
    let observation = tracked(points);
    RegisterStateRequest { observation, options: Some(options), ..Default::default() }
}

fn register(
    bench: &Bench,
    request: RegisterStateRequest,
    cancel: &CancelToken,
) -> Result<RegisteredState, Error> {
    register_state(&bench.warm, at_rest(bench), request, &bench.backend, cancel)
}

fn points(tensor: &Option<Tensor>) -> Vec<Point> {
    tensor.as_ref().unwrap().unpack_points("points").unwrap().1
}

fn moved(points: &[Point]) -> Vec<Point> {
    points.iter().map(|p| std::array::from_fn(|i| p[i] + BY[i])).collect()
}

fn farthest(a: &[Point], b: &[Point]) -> f64 {
    assert_eq!(a.len(), b.len());
    let apart = a.iter().zip(b).map(|(a, b)| bendtwin_core::geometry::point_distance(*a, *b));
    apart.fold(0.0, f64::max)
}

#[test]
fn a_chain_is_found_where_it_is_with_its_control_point() {
    let bench = Bench::new();
    let graph = &bench.warm.twin.graph;
    let there = moved(&graph.rest_positions);
    let found = register(&bench, request(&there, 0), &CancelToken::default()).unwrap();
    let state = found.state.as_ref().unwrap();
    assert!(farthest(&points(&state.positions), &there) < 1e-3);
    assert!(farthest(&points(&state.controls), &moved(&graph.control_rest)) < 5e-3);
    assert_eq!(points(&state.velocities), [[0.0; 3]; 4]);
    assert!(state.twists.is_none());
    let (before, after) = (found.before.unwrap(), found.after.unwrap());
    assert!((before.median_mm - 374.2).abs() < 1.0 && after.median_mm < 1.0, "{found:?}");
    assert!(found.explained.unwrap().points > 0.99);
    assert_eq!(found.motion.len(), 7);
    for (motion, by) in found.motion.iter().zip(BY) {
        assert!((motion - f64::from(by)).abs() < 1e-3, "{found:?}");
    }
}

#[test]
fn physics_are_those_of_the_worlds_gravity_and_ground() {
    let bench = Bench::new();
    let there = moved(&bench.warm.twin.graph.rest_positions);
    let drift_in = |world| {
        let request = RegisterStateRequest { world, ..request(&there, 3) };
        register(&bench, request, &CancelToken::default()).unwrap().drift_mm
    };
    let weightless = World { gravity: vec![0.0; 3], ..World::default() };
    assert!(drift_in(Some(weightless)) < 0.1);
    assert!(drift_in(None) > 1.0);
}

#[test]
fn what_the_twin_is_not_is_refused_and_cancelled_work_ends() {
    let bench = Bench::new();
    let apart: Vec<Point> = (0..4).map(|i| [0.3 * (i % 2) as f32, 0.0, 0.2 * i as f32]).collect();
    let options = RegisterOptions { max_residual_m: Some(1e-3), ..RegisterOptions::default() };
    let wrong = RegisterStateRequest { options: Some(options), ..request(&apart, 0) };
    let error = register(&bench, wrong, &CancelToken::default()).unwrap_err();
    assert_eq!(error.reason(), "OBSERVATION_NOT_EXPLAINED");
    assert_eq!(error.category(), Category::FailedPrecondition);
    assert!(error.to_string().contains("at most 1.0 mm"), "{error}");

    let options = RegisterOptions { noise_m: Some(f64::NAN), ..RegisterOptions::default() };
    let wrong = RegisterStateRequest { options: Some(options), ..request(&apart, 0) };
    let error = register(&bench, wrong, &CancelToken::default()).unwrap_err();
    assert_eq!(error.reason(), "INVALID_OBSERVATION");

    let cancel = CancelToken::default();
    cancel.cancel();
    let error = register(&bench, request(&apart, 0), &cancel).unwrap_err();
    assert_eq!(error.category(), Category::Cancelled);
}

/// A session whose slots are at rest.
pub(super) fn session(bench: &Bench, slots: usize) -> Session {
    session_in(bench, slots, None)
}

/// A session whose slots are at rest in a world.
pub(super) fn session_in(bench: &Bench, slots: usize, world: Option<World>) -> Session {
    let setup = Setup {
        twin: bench.warm.id,
        owner: String::new(),
        capture: String::new(),
        fidelity: bendtwin_proto::v1::Fidelity::Exact,
        world,
        grasps: Vec::new(),
        idle: std::time::Duration::from_secs(60),
    };
    Session::new(setup, vec![at_rest(bench); slots], None)
}

#[test]
fn a_correction_moves_the_slots_that_it_names_and_a_refused_one_none() {
    let bench = Bench::new();
    let model = bench.warm.loaded.model();
    let session = session(&bench, 2);
    let mut there = model.graph.rest_positions.clone();
    there[3][1] += 0.02;
    let backend = &bench.backend;
    let seen = |options: Option<CorrectOptions>| {
        let options = options.unwrap_or_default();
        CorrectionInput::new(&bench.warm, backend, &session.setup, tracked(&there), options)
            .unwrap()
    };
    let cancel = CancelToken::default();
    let strict = CorrectOptions { max_residual_m: Some(0.0), ..CorrectOptions::default() };
    let error = corrected(&session, &[0, 1], &seen(Some(strict)), Vec::new(), &cancel).unwrap_err();
    assert_eq!(error.reason(), "OBSERVATION_NOT_EXPLAINED");
    assert!(error.to_string().starts_with("slot 0: "), "{error}");
    let state = |slot| session.states(&[slot]).0.remove(0).state;
    assert_eq!([state(0), state(1)], [at_rest(&bench).state, at_rest(&bench).state]);

    let done = corrected(&session, &[1], &seen(None), Vec::new(), &cancel).unwrap();
    assert_eq!(done.len(), 1);
    assert_eq!(done[0].slot, 1);
    let (before, after) = (done[0].before.unwrap(), done[0].after.unwrap());
    assert!(after.mean_mm < 0.8 * before.mean_mm, "{done:?}");
    assert!(state(1).positions[3][1] > 0.005 && done[0].moved_mm > 5.0, "{done:?}");
    assert_eq!(state(0), at_rest(&bench).state);
    assert_eq!(session.describe("").frames, [0, 0]);
}

#[test]
fn the_ground_is_that_of_the_session() {
    let bench = Bench::new();
    let model = bench.warm.loaded.model();
    let mut there = model.graph.rest_positions.clone();
    there[3][2] -= 0.015;
    let height_in = |world: Option<World>| {
        let session = session_in(&bench, 2, world);
        let backend = &bench.backend;
        let options = CorrectOptions::default();
        let by =
            CorrectionInput::new(&bench.warm, backend, &session.setup, tracked(&there), options);
        let by = by.unwrap();
        corrected(&session, &[0], &by, Vec::new(), &CancelToken::default()).unwrap();
        session.states(&[0]).0[0].state.positions[3][2]
    };
    let plane = Plane { normal: Vec::new(), offset_m: 0.1999 };
    let ground = GroundChoice::Ground(plane);
    let table = World { ground_choice: Some(ground), ..World::default() };
    assert!(height_in(Some(table)) >= 0.1998);
    assert!(height_in(None) < 0.199);
}
