//! The check of rollouts.

use bendtwin_contract::rollout::{
    Batch, Error, Limits, MOST_SUBSTEPS, PlannerShape, TwinShape, check, check_for, finer_substeps,
    memory, work,
};
use bendtwin_contract_kit::rollout as cases;
use bendtwin_core::{Category, Problem as _};
use bendtwin_proto::v1::{
    Capsule, Collider, ControlTrajectories, Cost, Cuboid, Ensemble, GripperPoses, InitialState,
    Plane, PointSet, Returns, RollOutRequest, Sphere, Tensor, Vary,
    collider::{Carrier, Fixed, Shape},
    cost::{
        Clearance, ControlPath, ControlSpeed, Coverage, Force, Height, Keypoints, Kind, Strain,
        TargetCloud, When, Winding, Within,
        force::{All, By},
        winding::Around,
    },
    ensemble::Statistic,
    initial_state::{GivenState, State},
    roll_out_request::Actions,
    world::GroundChoice,
};
use proptest::prelude::*;

use crate::TWIN;

fn sound() -> RollOutRequest {
    cases::sound(&TWIN)
}

fn refused(request: &RollOutRequest, twin: &TwinShape, limits: &Limits) -> Error {
    check_for(request, twin, limits, 0).expect_err("must be refused")
}

#[test]
fn each_fault_is_refused_and_named() {
    for case in cases::malformed(&TWIN) {
        let error = refused(&case.request, &TWIN, &Limits::default());
        assert!(error.to_string().contains(case.names), "{}: {error}", case.what);
        let is_variant =
            matches!(error, Error::NoFastVariant { .. } | Error::NoPlannersTwin { .. });
        assert!(is_variant || error.category() == Category::InvalidArgument, "{}", case.what);
    }
}

#[test]
fn what_needs_no_twin_is_refused_without_one() {
    // Only the twin, or the call, tells about these.
    const NEEDS_TWIN: [&str; 23] = [
        "a point that the skin does not have",
        "a point to record that the skin does not have",
        "parts in time of one message",
        "no controls",
        "a control too many",
        "a control too many of a gripper",
        "a node short",
        "a node too many",
        "a control too many in the state",
        "a grasp too many in the state",
        "a frame of an imported twin's capture",
        "a node that is not there",
        "node 2^32 - 1",
        "a node to record that is not there",
        "no fast variant",
        "a grasp of a node that is not there",
        "a grasp of a node twice",
        "a force of a control point that is not there",
        "the height of a node that is not there",
        "a node that is not there in a box",
        "the order of a node that is not there",
        "the winding of a node that is not there",
        "the winding of a skin point that is not there",
    ];
    for case in cases::malformed(&TWIN) {
        let alone = check(&case.request, &Limits::default());
        if NEEDS_TWIN.contains(&case.what) {
            assert!(alone.is_ok(), "{}: {alone:?}", case.what);
        } else {
            let error = refused(&case.request, &TWIN, &Limits::default());
            assert_eq!(alone, Err(error), "{}", case.what);
        }
    }
}

#[test]
fn sound_requests_pass() {
    let limits = Limits::default();
    let batch = check_for(&sound(), &TWIN, &limits, 0);
    assert_eq!(batch, Ok(Batch { instances: 2, knots: 3, frames: 2 }));
    let with = |change: &dyn Fn(&mut RollOutRequest)| {
        let mut request = sound();
        change(&mut request);
        check_for(&request, &TWIN, &limits, 0).map(drop)
    };
    let given = |shape: &[usize]| {
        let positions = Some(Tensor::pack(shape, &vec![0.0f32; shape.iter().product()]));
        let given = GivenState {
            positions: positions.clone(),
            velocities: positions,
            ..GivenState::default()
        };
        Some(InitialState { state: Some(State::Given(given)) })
    };
    assert_eq!(with(&|r| r.initial = given(&[5, 3])), Ok(()));
    assert_eq!(with(&|r| r.initial = given(&[2, 5, 3])), Ok(()));
    // A cost that is switched off, and one of weight 1.
    assert_eq!(with(&|r| r.costs[0].weight = Some(0.0)), Ok(()));
    assert_eq!(with(&|r| r.costs[0].weight = None), Ok(()));
    assert_eq!(with(&|r| r.costs = vec![r.costs[0].clone(); 256]), Ok(()));
    assert_eq!(with(&|r| r.costs[0].name = "ä".repeat(64)), Ok(()));
    let fast = TwinShape { fast_substeps: Some(5), ..TWIN };
    let request = RollOutRequest { fidelity: 2, ..sound() };
    assert!(check_for(&request, &fast, &limits, 0).is_ok());
}

#[test]
fn only_a_fixed_capsule_has_an_axis_to_wind_around() {
    let with = |change: &dyn Fn(&mut Collider)| {
        let mut request = cases::sound_in_a_world(&TWIN);
        let shape = Capsule { from: vec![0.0; 3], to: vec![0.0, 0.1, 0.0], radius_m: 0.01 };
        let mut collider = Collider { shape: Some(Shape::Capsule(shape)), ..Collider::default() };
        change(&mut collider);
        request.world.get_or_insert_default().colliders = vec![collider];
        let nodes = Some(Tensor::pack(&[2], &[0u32, 1]));
        let around = Some(Around::Collider(0));
        let winding = Winding { nodes, around, turns: 1.0, skin_points: None };
        request.costs[0].kind = Some(Kind::Winding(winding));
        check_for(&request, &TWIN, &Limits::default(), 0).map(drop)
    };
    assert_eq!(with(&|_| ()), Ok(()));
    assert_eq!(with(&|c| c.carrier = Some(Carrier::Fixed(Fixed {}))), Ok(()));
    let rows = [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0f32].repeat(3);
    let path = Tensor::pack(&[3, 7], &rows);
    let point = Capsule { from: vec![0.1; 3], to: vec![0.1; 3], radius_m: 0.01 };
    let ball = Sphere { center: Vec::new(), radius_m: 0.1 };
    let refused: [&dyn Fn(&mut Collider); 4] = [
        &|c| c.carrier = Some(Carrier::Gripper(0)),
        &|c| c.carrier = Some(Carrier::Path(path.clone())),
        &|c| c.shape = Some(Shape::Capsule(point.clone())),
        &|c| c.shape = Some(Shape::Sphere(ball.clone())),
    ];
    for (i, change) in refused.into_iter().enumerate() {
        let error = with(change).expect_err("must be refused").to_string();
        assert!(error.contains("`costs[0].winding.collider`"), "{i}: {error}");
        assert!(error.contains("no fixed capsule"), "{i}: {error}");
    }
}

#[test]
fn a_condition_is_one_more_evaluation() {
    let of = |when: When, success_at_most| {
        let mut request = sound();
        let tensor = Tensor::pack(&[100, 3], &[0.0f32; 300]);
        let coverage = Coverage { points: Some(tensor), reach_m: 0.01, point_set: 0 };
        let kind = Some(Kind::Coverage(coverage));
        request.costs = vec![Cost { when: when.into(), success_at_most, kind, ..Cost::default() }];
        let batch = check(&request, &Limits::default()).unwrap();
        let bytes = memory(&request, &batch, &TWIN, 0).bytes(1, 1);
        (work(&request, &batch, &TWIN), bytes)
    };
    let ((once, small), (twice, large)) =
        (of(When::LastFrame, None), of(When::LastFrame, Some(0.1)));
    let (every, _) = of(When::EveryFrame, None);
    // There are two frames.
    assert!(twice > once && twice == every, "{once} {twice} {every}");
    assert!(large > small, "{large} bytes with a condition, {small} without");
    let limits = Limits { targets: 2 * 116, ..Limits::default() };
    for (success_at_most, passes) in [(None, true), (Some(0.1), false)] {
        let mut request = sound();
        let tensor = Tensor::pack(&[100, 3], &[0.0f32; 300]);
        let coverage = Coverage { points: Some(tensor), reach_m: 0.01, point_set: 0 };
        let kind = Some(Kind::Coverage(coverage));
        let when = When::EveryFrame.into();
        request.costs = vec![Cost { when, success_at_most, kind, ..Cost::default() }];
        assert_eq!(check_for(&request, &TWIN, &limits, 0).is_ok(), passes);
    }
}

#[test]
fn sound_worlds_pass() {
    let with = |change: &dyn Fn(&mut RollOutRequest)| {
        let mut request = cases::sound_in_a_world(&TWIN);
        change(&mut request);
        check_for(&request, &TWIN, &Limits::default(), 0).map(drop)
    };
    assert_eq!(with(&|_| ()), Ok(()));
    let row = [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0f32];
    let path = Tensor::pack(&[3, 7], row.repeat(3).as_slice());
    assert_eq!(
        with(&|r| {
            let world = r.world.get_or_insert_default();
            world.gravity = vec![0.0; 3];
            world.ground_choice = Some(GroundChoice::NoGround(true));
            world.colliders[0].pose = row.to_vec();
            world.colliders[0].carrier = Some(Carrier::Path(path.clone()));
        }),
        Ok(())
    );
    assert_eq!(with(&|r| r.grasps[0].closed = Some(Tensor::pack(&[2, 3], &[1u32; 6]))), Ok(()));
    assert_eq!(with(&|r| r.grasps[0].closed = Some(Tensor::pack(&[1], &[0u32]))), Ok(()));
    let mass = |count: usize| Vary {
        mass: Some(Tensor::pack(&[count], &vec![2.0f32; count])),
        ..Vary::default()
    };
    assert_eq!(with(&|r| r.vary = Some(mass(2))), Ok(()));
    let worst = Ensemble { members: 5, ..Ensemble::default() };
    let ensemble = |r: &mut RollOutRequest| {
        r.vary = Some(mass(5));
        r.ensemble = Some(worst);
    };
    assert_eq!(with(&ensemble), Ok(()));
    // Five members are five times the work.
    let mut request = cases::sound_in_a_world(&TWIN);
    let batch = check(&request, &Limits::default()).unwrap();
    let alone = work(&request, &batch, &TWIN);
    ensemble(&mut request);
    assert_eq!(work(&request, &batch, &TWIN), 5 * alone);
    // Along the mean of their motion costs are measured once more, and what it takes is kept.
    let of_costs = memory(&request, &batch, &TWIN, 0);
    request.ensemble.iter_mut().for_each(|e| e.set_statistic(Statistic::MeanPrediction));
    assert_eq!(check(&request, &Limits::default()), Ok(batch));
    assert!((5 * alone + 1..6 * alone).contains(&work(&request, &batch, &TWIN)));
    let of_mean = memory(&request, &batch, &TWIN, 0);
    assert!(of_mean.prepared > of_costs.prepared && of_mean.fixed > of_costs.fixed);
}

#[test]
fn limits_hold_and_say_what_to_do() {
    let beyond = |request: &RollOutRequest, limits: Limits, advice: &str| {
        let error = refused(request, &TWIN, &limits);
        assert_eq!(error.reason(), "ROLLOUT_TOO_LARGE", "{error}");
        assert!(error.to_string().contains(advice), "{error}");
    };
    let all = Limits::default();
    beyond(&sound(), Limits { instances: 1, ..all }, "split the batch");
    beyond(&sound(), Limits { request_bytes: 50, ..all }, "fewer knots");
    beyond(&sound(), Limits { costs: 0, ..all }, "number of costs");
    // 2 instances x 2 frames x 10 substeps x 12 elements, and 20 a target point of the last frame.
    let work = 2 * (2 * 10 * 12 + 20);
    beyond(&sound(), Limits { work: work - 1, ..all }, "shorter horizon");
    assert!(check_for(&sound(), &TWIN, &Limits { work, ..all }, 0).is_ok());
    let cloud = Kind::TargetCloud(TargetCloud {
        points: Some(Tensor::pack(&[9, 3], &[0f32; 27])),
        point_set: 0,
    });
    let everywhere = Cost { when: When::EveryFrame.into(), kind: Some(cloud), ..Cost::default() };
    let request = RollOutRequest { costs: vec![everywhere], ..sound() };
    beyond(&request, Limits { targets: 2 * (9 + 16) - 1, ..all }, "thin the targets out");
    let returns = Some(Returns { every_frames: 1, ..Returns::default() });
    let request = RollOutRequest { returns, ..sound() };
    beyond(&request, Limits { reply_bytes: 700, ..all }, "returns.every_frames");
    // In parts it fits.
    assert!(check_for(&request, &TWIN, &Limits { reply_bytes: 700, ..all }, 1).is_ok());
}

/// Twice as stiff takes the root of two as many substeps, half as heavy too, twice as damped twice.
#[test]
fn what_is_varied_is_counted_with_the_substeps_that_it_takes() {
    let plain = RollOutRequest { costs: Vec::new(), ..sound() };
    let of = |vary: Vary| {
        let request = RollOutRequest { vary: Some(vary), ..plain.clone() };
        let batch = check(&request, &Limits::default()).unwrap();
        work(&request, &batch, &TWIN)
    };
    let two = |a: f32, b: f32| Some(Tensor::pack(&[2], &[a, b]));
    // 2 frames of 12 elements with 10 substeps, or as many as are given.
    let with = |a: u128, b: u128| 2 * 12 * (a + b);
    assert_eq!(of(Vary::default()), with(10, 10));
    assert_eq!(of(Vary { stiffness: two(1.0, 0.5), ..Vary::default() }), with(10, 10));
    assert_eq!(of(Vary { stiffness: two(1.0, 2.0), ..Vary::default() }), with(10, 15));
    assert_eq!(of(Vary { bending: two(4.0, 4.0), ..Vary::default() }), with(20, 20));
    assert_eq!(of(Vary { mass: two(0.01, 1.0), ..Vary::default() }), with(1_077, 10));
    assert_eq!(of(Vary { damping: two(2.0, 1.0), ..Vary::default() }), with(20, 10));
    let most = Vary { damping: two(100.0, 1.0), mass: two(0.01, 1.0), ..Vary::default() };
    assert_eq!(of(most), with(MOST_SUBSTEPS.into(), 10));
}

#[test]
fn finer_substeps_are_enough_and_few_numbers() {
    let mut seen = std::collections::BTreeSet::new();
    for own in [1, 7, 154] {
        for needed in own..50 * own {
            let found = finer_substeps(own, needed.into());
            assert!(found >= needed && f64::from(found) <= 1.2 * f64::from(needed) + 1.0);
            seen.insert((own, found));
        }
    }
    assert!(seen.len() < 3 * 30, "{}", seen.len());
    assert_eq!(finer_substeps(154, 1e9), MOST_SUBSTEPS);
    assert_eq!(finer_substeps(200_000, 1e9), 200_000);
}

#[test]
fn every_kind_of_cost_passes() {
    let world = cases::sound_in_a_world(&TWIN);
    let force = |by| Kind::Force(Force { by: Some(by), limit_n: 2.0 });
    let nodes = Some(Tensor::pack(&[2], &[4u32, 0]));
    let cuboid = Some(Cuboid { low: vec![-1.0; 3], high: vec![1.0; 3] });
    let kinds = [
        Kind::Strain(Strain { limit: 0.1 }),
        force(By::Controls(All {})),
        force(By::Control(0)),
        force(By::Grasp(0)),
        force(By::Ground(All {})),
        force(By::Collider(0)),
        Kind::Height(Height::default()),
        Kind::Height(Height { plane: Some(Plane::default()), nodes: nodes.clone() }),
        Kind::Within(Within { cuboid, nodes }),
        Kind::Clearance(Clearance { collider: 0, margin_m: 0.01 }),
        Kind::ControlPath(ControlPath {}),
        Kind::ControlSpeed(ControlSpeed { limit_m_s: 0.5 }),
    ];
    let costs = kinds.into_iter().enumerate().map(|(i, kind)| Cost {
        // To be maximized, some of them.
        weight: Some([1.0, -1.0, 0.0][i % 3]),
        kind: Some(kind),
        ..Cost::default()
    });
    let request = RollOutRequest { costs: costs.collect(), ..world };
    assert_eq!(check_for(&request, &TWIN, &Limits::default(), 0).map(drop), Ok(()));
}

#[test]
fn a_fast_rollout_is_counted_with_its_own_substeps() {
    let fast = TwinShape { fast_substeps: Some(5), ..TWIN };
    let limits = Limits { work: 2 * (2 * 5 * 12 + 20), ..Limits::default() };
    let request = RollOutRequest { fidelity: 2, ..sound() };
    assert!(check_for(&request, &fast, &limits, 0).is_ok());
    assert!(check_for(&sound(), &fast, &limits, 0).is_err());
}

#[test]
fn a_rollout_of_a_planners_twin_is_counted_with_its_own_size() {
    let shape = PlannerShape { nodes: 2, springs: 1, triplets: 0, substeps: 5 };
    let planner = TwinShape { planner: Some(shape), ..TWIN };
    let request = RollOutRequest { fidelity: 3, ..sound() };
    let batch = check_for(&request, &planner, &Limits::default(), 0).unwrap();
    let work = |request: &RollOutRequest| work(request, &batch, &planner);
    assert!(work(&request) < work(&sound()));
    let refused = refused(&request, &TWIN, &Limits::default());
    assert_eq!(refused, Error::NoPlannersTwin { twin: request.twin });
}

proptest! {
    /// Any bytes and shapes: an answer or a refusal, never a panic.
    #[test]
    fn no_tensor_panics(
        dtype in -1i32..8,
        shape in prop::collection::vec(prop_oneof![0u64..4, Just(u64::MAX), Just(1 << 40)], 0..6),
        data in prop::collection::vec(any::<u8>(), 0..200),
        interpolation in -1i32..5,
        frames in 0u32..20,
        as_poses in any::<bool>(),
        controls in 0u64..3,
    ) {
        let tensor = Tensor { dtype, shape, data: data.into(), ..Tensor::default() };
        let given = GivenState {
            positions: Some(tensor.clone()),
            velocities: Some(tensor.clone()),
            twists: Some(tensor.clone()),
            ..GivenState::default()
        };
        let actions = if as_poses {
            Actions::Poses(GripperPoses {
                poses: Some(tensor.clone()), gripper_of_control: Some(tensor.clone()), interpolation,
            })
        } else {
            Actions::Trajectories(ControlTrajectories { positions: Some(tensor.clone()), interpolation })
        };
        let twin = TwinShape { controls, ..TWIN };
        let bare = RollOutRequest { actions: Some(actions), frames, ..RollOutRequest::default() };
        let returns = Some(Returns { nodes: Some(tensor), every_frames: 1, ..Returns::default() });
        let initial = Some(InitialState { state: Some(State::Given(given)) });
        for request in [
            bare,
            RollOutRequest { initial, ..sound() },
            RollOutRequest { returns, ..sound() },
        ] {
            if let Ok(batch) = check_for(&request, &twin, &Limits::default(), 0) {
                prop_assert!(batch.instances > 0 && batch.knots > 1 && batch.frames > 0);
            }
        }
    }
}

#[test]
fn points_of_the_skin_are_counted_where_the_twin_tells() {
    let list = |point: u32| Some(Tensor::pack(&[1], &[point]));
    let returns = |point: u32| Returns {
        every_frames: 1,
        point_set: PointSet::Skin.into(),
        skin_points: list(point),
        ..Returns::default()
    };
    let keypoints = |point: u32| Keypoints {
        skin_points: list(point),
        targets: Some(Tensor::pack_points(&[1], &[[0.0; 3]])),
        ..Keypoints::default()
    };
    let passes = |point: u32, twin: &TwinShape| {
        let costs = vec![Cost { kind: Some(Kind::Keypoints(keypoints(point))), ..Cost::default() }];
        let recording = RollOutRequest { returns: Some(returns(point)), ..sound() };
        [recording, RollOutRequest { costs, ..sound() }]
            .map(|request| check_for(&request, twin, &Limits::default(), 0).map(drop))
    };
    // More than there are nodes.
    assert_eq!(passes(8, &TWIN), [Ok(()), Ok(())]);
    for refused in passes(9, &TWIN) {
        let text = refused.unwrap_err().to_string();
        assert!(text.contains("names skin point 9, the twin has 9 (counted from 0)"), "{text}");
    }
    // A server that does not know leaves it to the worker.
    assert_eq!(passes(9, &TwinShape { skin_points: None, ..TWIN }), [Ok(()), Ok(())]);
}

#[test]
fn a_twin_without_surface_has_no_skin() {
    let bare = TwinShape { skin_points: Some(0), ..TWIN };
    let cloud = |point_set: PointSet| {
        let points = Some(Tensor::pack_points(&[1], &[[0.0; 3]]));
        let cloud = TargetCloud { points, point_set: point_set.into() };
        let costs = vec![Cost { kind: Some(Kind::TargetCloud(cloud)), ..Cost::default() }];
        RollOutRequest { costs, ..sound() }
    };
    let limits = Limits::default();
    assert!(check_for(&cloud(PointSet::Nodes), &bare, &limits, 0).is_ok());
    let refused = refused(&cloud(PointSet::Unspecified), &bare, &limits).to_string();
    assert!(refused.contains("`costs[0].target_cloud.point_set`"), "{refused}");
    let point_set = PointSet::Skin.into();
    let returns = Some(Returns { every_frames: 1, point_set, ..Returns::default() });
    let request = RollOutRequest { returns, ..sound() };
    assert!(check_for(&request, &TWIN, &limits, 0).is_ok());
    assert!(check_for(&request, &bare, &limits, 0).is_err());
}
