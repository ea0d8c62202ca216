//! The check of plans.

use bendtwin_contract::{
    plan::{Checked, Error, Force as Judged, MOST_PLANS, check},
    rollout::{self, Limits, SessionParts, TwinShape},
};
use bendtwin_contract_kit::plan as cases;
use bendtwin_core::{Category, Problem as _};
use bendtwin_plan::Movement;
use bendtwin_proto::v1::{
    ActionSpace, Cost, Ensemble, Grasp, GraspSearch, Grasping, InitialState, KnotTimes, PlanBounds,
    PlanMethod, PlanRequest, Plausibility, Returns, Tensor, Vary, World,
    action_space::Coordinates,
    cost::{Clearance, Force, Kind, force::By},
    ensemble::Statistic,
    initial_state::{GivenState, State},
    knot_times::Times,
    plan_method::Method,
    roll_out_request::Actions,
};
use proptest::{collection::vec, num, prelude::*};

/// 5 nodes that hang from two control points.
const TWIN: TwinShape = TwinShape { controls: 2, ..crate::TWIN };

fn checked(request: PlanRequest) -> Result<Checked, Error> {
    check(request, SessionParts::default(), &TWIN, 0.1, &Limits::default())
}

#[test]
fn each_fault_is_refused_and_named() {
    for case in cases::malformed(&TWIN) {
        let error = checked(case.request).expect_err(case.what);
        assert!(error.to_string().contains(case.names), "{}: {error}", case.what);
        let is_variant = error.reason() == "FAST_VARIANT_UNKNOWN";
        assert!(is_variant || error.category() == Category::InvalidArgument, "{}", case.what);
    }
}

#[test]
fn faults_of_the_rollout_are_those_of_a_rollout() {
    for case in bendtwin_contract_kit::rollout::malformed(&TWIN) {
        let mut request = cases::sound(&TWIN);
        request.rollout = Some(case.request);
        let error = checked(request).expect_err(case.what);
        let reasons = ["INVALID_ROLLOUT", "ROLLOUT_TOO_LARGE", "FAST_VARIANT_UNKNOWN"];
        assert!(reasons.contains(&error.reason()), "{}: {error}", case.what);
    }
}

#[test]
fn what_is_left_is_what_a_planner_needs() {
    let mut request = cases::sound(&TWIN);
    request.rollout.as_mut().unwrap().returns =
        Some(Returns { encoding: 1, point_set: 1, ..Returns::default() });
    let checked = checked(request).unwrap();
    assert_eq!((checked.settings.knots, checked.settings.dims), (3, 3));
    assert_eq!((checked.settings.samples, checked.settings.iterations), (4, 1));
    assert_eq!((checked.settings.frames, checked.settings.frame_s), (2, 0.1));
    assert_eq!(checked.nominal, vec![0.0; 18]);
    assert_eq!(checked.movement, Movement::Points(vec![0, 0]));
    let plans = vec![vec![0.5; 18], vec![0.25; 18]];
    let batch = checked.template.batch(&plans, true);
    let Some(Actions::Trajectories(actions)) = &batch.actions else { panic!() };
    assert_eq!(actions.positions.as_ref().unwrap().shape, [2, 3, 2, 3]);
    assert!(batch.returns.as_ref().unwrap().action_gradients);
    rollout::check_for(&batch, &TWIN, &Limits::default(), 0).unwrap();
    assert_eq!(checked.template.last(&plans[0]), None);
}

#[test]
fn poses_and_times_of_knots_are_taken_over() {
    let mut request = cases::sound_with_poses(&TWIN);
    let rollout = request.rollout.as_mut().unwrap();
    rollout.knot_times = Some(KnotTimes { times: Some(Times::PeriodS(0.25)) });
    rollout.frames = 5;
    let whole = checked(request.clone()).unwrap();
    assert_eq!((whole.settings.dims, whole.movement), (6, Movement::Rigid));
    assert_eq!(whole.settings.knot_times, [0.0, 0.25, 0.5]);
    let coordinates = Coordinates::Translation.into();
    request.space = Some(ActionSpace { coordinates, ..Default::default() });
    assert_eq!(checked(request).unwrap().settings.dims, 3);
}

#[test]
fn what_is_said_of_the_one_instance_holds_for_all() {
    let mut request = cases::sound(&TWIN);
    let rollout = request.rollout.as_mut().unwrap();
    let positions = Some(Tensor::pack_points(&[1, 5], &[[0.0; 3]; 5]));
    let state = State::Given(GivenState { positions, ..GivenState::default() });
    rollout.initial = Some(InitialState { state: Some(state) });
    rollout.vary = Some(Vary { stiffness: Some(Tensor::pack(&[1], &[2f32])), ..Vary::default() });
    let Some(bendtwin_proto::v1::cost::Kind::Keypoints(k)) = &mut rollout.costs[0].kind else {
        panic!()
    };
    k.targets = Some(Tensor::pack_points(&[1, 1, 1], &[[0.0; 3]]));
    rollout.returns = Some(Returns { final_state: true, ..Returns::default() });
    let template = checked(request).unwrap().template;
    let plans = vec![vec![0.0; 18]; 3];
    let limits = Limits::default();
    let batch = template.batch(&plans, false);
    assert_eq!(rollout::check_for(&batch, &TWIN, &limits, 0).unwrap().instances, 3);
    assert_eq!(batch.returns, None);
    let last = template.last(&plans[0]).unwrap();
    assert!(last.returns.as_ref().unwrap().final_state);
    rollout::check_for(&last, &TWIN, &limits, 0).unwrap();
}

#[test]
fn every_strain_of_a_batch_is_reported_and_its_limit_is_the_callers() {
    let limits = |plausibility| {
        let mut request = cases::sound(&TWIN);
        request.rollout.as_mut().unwrap().plausibility = plausibility;
        let template = checked(request).unwrap().template;
        let batch = template.batch(&[vec![0.0; 18]], false);
        assert_eq!(batch.plausibility.unwrap().strain, Some(0.0));
        assert!(!batch.plausibility.unwrap().refuse);
        (template.strain_limit(), template.refuses())
    };
    assert_eq!(limits(None), (1.0, false));
    let lifted = Plausibility { strain: Some(f64::INFINITY), ..Plausibility::default() };
    assert_eq!(limits(Some(lifted)), (f64::INFINITY, false));
    let refused = Plausibility { refuse: true, strain: Some(0.2), ..Plausibility::default() };
    assert_eq!(limits(Some(refused)), (0.2, true));
}

#[test]
fn forces_of_a_batch_are_reported_if_plans_are_judged_by_them() {
    let template = |request: PlanRequest| {
        let template = checked(request).unwrap().template;
        let batch = template.batch(&[vec![0.0; 42]], false);
        (template.force().cloned(), batch.plausibility.unwrap().grasp_force_n)
    };
    let with_limit = |grasp_force_n, mut request: PlanRequest| {
        let plausibility = Plausibility { grasp_force_n, ..Plausibility::default() };
        request.rollout.as_mut().unwrap().plausibility = Some(plausibility);
        request
    };
    let without_search = || PlanRequest { grasp_search: None, ..cases::sound_with_places(&TWIN) };
    assert_eq!(template(without_search()), (None, None));
    assert_eq!(template(with_limit(Some(f64::INFINITY), without_search())), (None, None));
    let limited = Judged { limit_n: 4.0, takes: None };
    assert_eq!(template(with_limit(Some(4.0), without_search())), (Some(limited), Some(0.0)));
    // In a search the gripper that is searched, not another, must take hold of something.
    let mut search = with_limit(None, cases::sound_with_places(&TWIN));
    let grasps = &mut search.rollout.as_mut().unwrap().grasps;
    grasps.insert(0, Grasp { gripper: 1, ..grasps[0].clone() });
    let judged = Judged { limit_n: f64::INFINITY, takes: Some(vec![1]) };
    assert_eq!(template(search), (Some(judged), Some(0.0)));
}

#[test]
fn places_are_taken_over_with_what_they_take() {
    let sound = || cases::sound_with_places(&TWIN);
    let mut moved = sound();
    let poses: Vec<f32> = (0..3).flat_map(|p| [p as f32, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0]).collect();
    let poses = Some(Tensor::pack(&[3, 1, 7], &poses));
    moved.grasp_search = Some(GraspSearch { poses, grippers: vec![0] });
    let places = checked(moved).unwrap().places.unwrap();
    assert_eq!((places.count(), &places.grippers[..]), (3, &[0][..]));
    // Only the gripper that is searched moves.
    let row: Vec<f64> = (0..14).map(f64::from).collect();
    let at = places.at(2, &row);
    assert_eq!((&at[..7], &at[7..]), (&[2.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0][..], &row[7..]));
    // Defaults are as many as the places need; memory is that of all of them.
    let defaults = |method| {
        let request = PlanRequest { samples: 0, iterations: 0, method, ..sound() };
        let checked = checked(request).unwrap();
        (checked.settings.samples, checked.settings.iterations)
    };
    assert_eq!(defaults(None), (64, 3));
    let gradient = Method::Gradient(Default::default());
    assert_eq!(defaults(Some(PlanMethod { method: Some(gradient) })), (3, 20));
    let bytes = |count: usize| {
        let poses = cases::sound_with_places(&TWIN).grasp_search.unwrap().poses.unwrap();
        let (_, pose) = poses.unpack::<f32>("poses").unwrap();
        let poses = Some(Tensor::pack(&[count, 1, 7], &pose[..7].repeat(count)));
        let search = Some(GraspSearch { poses, grippers: vec![0] });
        let request = PlanRequest { grasp_search: search, samples: 768, iterations: 9, ..sound() };
        checked(request).unwrap().bytes
    };
    // Knots, best plans and spreads of twelve coordinates.
    assert!(bytes(256) - bytes(2) > 254 * 6 * 8 * 3 * 12);
    // Open grasps, and ones that begin open, may be moved.
    let begins = |closed: Option<Tensor>, phase: u32| {
        let mut request = sound();
        let rollout = request.rollout.as_mut().unwrap();
        rollout.grasps[0].closed = closed;
        let nodes = TWIN.nodes as usize;
        let points = || Some(Tensor::pack_points(&[nodes], &vec![[0.0; 3]; nodes]));
        let given = GivenState {
            positions: points(),
            grasping: Some(Grasping {
                phases: Some(Tensor::pack(&[1], &[phase])),
                holders: Some(Tensor::pack(&[nodes], &vec![0u32; nodes])),
                places: points(),
            }),
            ..GivenState::default()
        };
        rollout.initial = Some(InitialState { state: Some(State::Given(given)) });
        checked(request).map(drop)
    };
    let closed = |values: &[u32]| Some(Tensor::pack(&[values.len()], values));
    assert_eq!(begins(None, 0), Ok(()));
    assert_eq!(begins(closed(&[0, 1, 1]), 1), Ok(()));
    assert!(begins(closed(&[1, 1, 0]), 1).is_err());
}

#[test]
fn costs_of_a_session_have_its_colliders_and_grasps() {
    let session = SessionParts { colliders: 1, grasps: 1 };
    let with = |kind, session| {
        let mut request = cases::sound_with_poses(&TWIN);
        request.rollout.as_mut().unwrap().costs =
            vec![Cost { kind: Some(kind), ..Cost::default() }];
        check(request, session, &TWIN, 0.1, &Limits::default()).map(drop)
    };
    let clearance = |collider| Kind::Clearance(Clearance { collider, margin_m: 0.01 });
    let force = |by| Kind::Force(Force { limit_n: 1.0, by: Some(by) });
    let inside = [clearance(0), force(By::Collider(0)), force(By::Grasp(0))];
    for kind in inside {
        assert_eq!(with(kind.clone(), session), Ok(()));
        let refused = with(kind, SessionParts::default()).unwrap_err().to_string();
        assert!(refused.contains("the request has 0"), "{refused}");
    }
    for kind in [clearance(1), force(By::Collider(1)), force(By::Grasp(1))] {
        let refused = with(kind, session).unwrap_err().to_string();
        assert!(refused.contains("the request has 1"), "{refused}");
    }
    // A world of the request takes the place of the session's.
    let mut request = cases::sound_with_poses(&TWIN);
    let rollout = request.rollout.as_mut().unwrap();
    rollout.world = Some(World::default());
    rollout.costs = vec![Cost { kind: Some(clearance(0)), ..Cost::default() }];
    assert!(check(request, session, &TWIN, 0.1, &Limits::default()).is_err());
}

#[test]
fn the_first_frames_of_a_plan_are_its_motion_without_the_search() {
    let mut request = cases::sound(&TWIN);
    let rollout = request.rollout.as_mut().unwrap();
    rollout.frames = 4;
    rollout.ensemble = Some(Ensemble { members: 2, ..Ensemble::default() });
    rollout.vary =
        Some(Vary { stiffness: Some(Tensor::pack(&[2], &[1f32, 2.0])), ..Vary::default() });
    rollout.time_limit_s = Some(1.0);
    let returns = Some(Returns { final_state: true, ..Returns::default() });
    let first = checked(request.clone()).unwrap().first_frames(3, returns.clone());
    assert_eq!((first.frames, &first.returns, first.costs.len()), (3, &returns, 0));
    assert_eq!((&first.ensemble, &first.vary, first.time_limit_s), (&None, &None, None));
    // Three knots over four frames of 0.1 s.
    assert_eq!(first.knot_times, Some(KnotTimes { times: Some(Times::PeriodS(0.2)) }));
    rollout::check_for(&first, &TWIN, &Limits::default(), 0).unwrap();
    rollout::check_advance(&first).unwrap();
    // The mean of the members' motion is that of the object.
    let mut of_mean = request.clone();
    let ensemble = of_mean.rollout.as_mut().and_then(|rollout| rollout.ensemble.as_mut());
    ensemble.unwrap().set_statistic(Statistic::MeanPrediction);
    let first = checked(of_mean).unwrap().first_frames(3, returns);
    assert!(first.ensemble.is_some() && first.vary.is_some(), "{first:?}");
    rollout::check_for(&first, &TWIN, &Limits::default(), 0).unwrap();
    rollout::check_advance(&first).unwrap();
    let rollout = request.rollout.as_mut().unwrap();
    (rollout.ensemble, rollout.vary) =
        (None, Some(Vary { friction: Some(Tensor::pack(&[1], &[2f32])), ..Vary::default() }));
    let times = Some(KnotTimes { times: Some(Times::PeriodS(0.05)) });
    rollout.knot_times.clone_from(&times);
    let first = checked(request).unwrap().first_frames(3, None);
    assert!(first.vary.is_some() && first.ensemble.is_none());
    assert_eq!(first.knot_times, times);
}

#[test]
fn all_batches_together_are_bounded_by_the_work_of_one_rollout() {
    // 4 plans x 2 frames x 10 substeps x 12 elements, and the costs.
    let limits = Limits { work: 5_000, ..Limits::default() };
    let plan = |iterations| PlanRequest { iterations, ..cases::sound(&TWIN) };
    check(plan(4), SessionParts::default(), &TWIN, 0.1, &limits).unwrap();
    let error = check(plan(8), SessionParts::default(), &TWIN, 0.1, &limits).expect_err("too much");
    assert!(error.to_string().contains("work of all iterations"), "{error}");
    let limits = Limits { request_bytes: 1_000, ..Limits::default() };
    let many = PlanRequest { samples: 100, ..cases::sound(&TWIN) };
    let error = check(many, SessionParts::default(), &TWIN, 0.1, &limits).expect_err("too large");
    assert!(error.to_string().contains("size of a batch"), "{error}");
}

proptest! {
    #[test]
    fn no_numbers_panic_and_what_passes_is_within_the_limits(
        (samples, iterations, coordinates) in (any::<u32>(), any::<u32>(), -1..8i32),
        small in any::<bool>(),
        sigma in vec(num::f32::ANY, 0..10),
        limits in vec(num::f32::ANY, 0..4),
        groups in vec(0..4u32, 0..4),
        start in vec(num::f32::ANY, 0..8),
        (correlation, deadline_s, shift_frames) in (num::f64::ANY, num::f64::ANY, num::f64::ANY),
        has_poses in any::<bool>(),
        grasping in prop::option::of((vec(num::f32::ANY, 0..30), vec(0..3u32, 0..3))),
    ) {
        let floats = |values: &[f32]| (!values.is_empty()).then(|| Tensor::pack(&[values.len()], values));
        let rows = start.len() / 3;
        let points = Tensor::pack(&[rows, 3], &start[..3 * rows]);
        let poses = Tensor::pack(&[start.len() / 7, 7], &start[..start.len() / 7 * 7]);
        let space = ActionSpace {
            coordinates,
            group_of_control: (!groups.is_empty()).then(|| Tensor::pack(&[groups.len()], &groups)),
            start: (rows > 0).then_some(if has_poses { poses } else { points }),
        };
        let mut good = match (&grasping, has_poses) {
            (Some(_), true) => cases::sound_with_places(&TWIN),
            (None, true) => cases::sound_with_poses(&TWIN),
            (_, false) => cases::sound(&TWIN),
        };
        if let Some((values, grippers)) = grasping.filter(|(values, _)| !values.is_empty()) {
            let width = 7 * grippers.len().max(1);
            let places = values.len() / width;
            let shape = [places, grippers.len().max(1), 7];
            let poses = Some(Tensor::pack(&shape, &values[..places * width]));
            good.grasp_search = Some(GraspSearch { poses, grippers });
        }
        let request = PlanRequest {
            samples: if small { samples % 9 } else { samples },
            iterations: if small { iterations % 9 } else { iterations },
            sigma: floats(&sigma),
            bounds: Some(PlanBounds { low: floats(&limits), ..PlanBounds::default() }),
            space: Some(space),
            correlation,
            deadline_s,
            shift_frames,
            ..good
        };
        if let Ok(checked) = checked(request) {
            let settings = &checked.settings;
            prop_assert!((settings.samples * settings.iterations) as u64 <= MOST_PLANS);
            prop_assert_eq!(settings.knots, 3);
            let batch = checked.template.batch(&vec![checked.nominal; 3], false);
            rollout::check_for(&batch, &TWIN, &Limits::default(), 0).unwrap();
        }
    }
}
