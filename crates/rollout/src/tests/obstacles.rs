//! Corrections and registrations beside obstacles, and slots that are lost.

use bendtwin_core::{Plane, Point, Skin};
use bendtwin_proto::v1::{
    Capsule, Collider, CorrectOptions, Cuboid, GripperPoses, Observation, RegisterStateRequest,
    World, collider::Carrier, collider::Shape, corrected_session::Correction,
    initial_state::SessionSlots, world::GroundChoice,
};

use super::*;
use crate::{
    register::register_state,
    request::initial::Start,
    session::{
        Begun, Session, Sessions,
        correct::{CorrectionInput, corrected},
    },
    tests::registration::{at_rest, session_in, tracked},
};

fn slab(low: [f32; 3], high: [f32; 3]) -> Collider {
    let shape = Some(Shape::Cuboid(Cuboid { low: low.to_vec(), high: high.to_vec() }));
    Collider { shape, ..Collider::default() }
}

fn world(colliders: Vec<Collider>) -> World {
    World { colliders, ..World::default() }
}

/// Corrects slot 0 by observed nodes.
fn correct(
    bench: &Bench,
    session: &Session,
    there: &[Point],
    options: CorrectOptions,
) -> Result<Correction, Error> {
    correct_by(bench, session, tracked(there), options)
}

fn correct_by(
    bench: &Bench,
    session: &Session,
    observation: Option<Observation>,
    options: CorrectOptions,
) -> Result<Correction, Error> {
    let backend = &bench.backend;
    let seen = CorrectionInput::new(&bench.warm, backend, &session.setup, observation, options)?;
    let done = corrected(session, &[0], &seen, Vec::new(), &CancelToken::default())?;
    Ok(done.into_iter().next().unwrap())
}

fn nodes(session: &Session) -> Vec<Point> {
    session.states(&[0]).0.remove(0).state.positions.clone()
}

fn shifted(by: Point) -> Vec<Point> {
    let rest = twin().graph.rest_positions;
    rest.iter().map(|p| std::array::from_fn(|i| p[i] + by[i])).collect()
}

#[test]
fn nodes_stay_out_of_the_colliders_of_the_session() {
    let bench = Bench::new();
    // The chain hangs 2 mm beside a slab; what is seen is 10 mm inside of it.
    let beside = world(vec![slab([0.002, -0.5, -1.0], [0.5, 0.5, 2.0])]);
    let session = session_in(&bench, 1, Some(beside));
    let done = correct(&bench, &session, &shifted([0.012, 0.0, 0.0]), Default::default()).unwrap();
    for (i, x) in nodes(&session).iter().enumerate() {
        assert!(x[0] <= 0.002, "{x:?}");
        assert!(i == 0 || x[0] > 0.0015, "{x:?}");
    }
    // The reply has the current state.
    let state = done.state.unwrap();
    let positions = state.positions.unwrap().unpack_points("positions").unwrap();
    assert_eq!(positions, (vec![4], nodes(&session)));
    assert_eq!(state.controls.unwrap().shape, [1, 3]);
    assert!(state.grasping.is_none() && state.twists.is_none());
    let omitted = CorrectOptions { omit_state: true, ..CorrectOptions::default() };
    let done = correct(&bench, &session, &shifted([0.0; 3]), omitted).unwrap();
    assert!(done.state.is_none() && !done.tracking.unwrap().lost);

    // Another world of the request is the one that counts.
    let nothing = CorrectOptions { world: Some(World::default()), ..CorrectOptions::default() };
    correct(&bench, &session, &shifted([0.012, 0.0, 0.0]), nothing).unwrap();
    assert!(nodes(&session)[3][0] > 0.004, "{:?}", nodes(&session));
}

/// A session that is advanced by a gripper with a slab, from x = 0.3 to 0.02, in two frames.
async fn advanced_with_a_slab(bench: &Bench) -> Arc<Session> {
    let carrier = Some(Carrier::Gripper(1));
    let slab = Collider { carrier, ..slab([0.0, -0.5, -1.0], [0.1, 0.5, 2.0]) };
    let sessions = Sessions::default();
    let session = sessions.add(session_in(bench, 1, Some(world(vec![slab])))).unwrap();
    let slots = SessionSlots { session: session.id.to_string(), slots: vec![0] };
    let pose = |x: f32, z: f32| [x, 0.0, z, 0.0, 0.0, 0.0, 1.0];
    let rows = [[pose(0.0, 0.6), pose(0.3, 0.0)], [pose(0.0, 0.6), pose(0.02, 0.0)]];
    let poses = Tensor::pack(&[1, 2, 2, 7], rows.as_flattened().as_flattened());
    let poses = GripperPoses { poses: Some(poses), ..GripperPoses::default() };
    let mut request = RollOutRequest {
        initial: Some(InitialState { state: Some(State::Session(slots)) }),
        actions: Some(Actions::Poses(poses)),
        frames: 2,
        ..RollOutRequest::default()
    };
    let begun = Begun::new(&sessions, &mut request, vec![0]).await.unwrap().unwrap();
    let starts = begun.starts();
    let (plan, _) = bench.plan(request, 16).unwrap();
    let execution = Execution {
        plan: &plan,
        starts: &starts,
        backend: &bench.backend,
        cancel: &CancelToken::default(),
        until: None,
        arrived: Instant::now(),
        worker: "w",
        keeps_states: true,
    };
    let states = execution.run(|_| Ok(())).unwrap();
    begun.commit(states, plan.frames).unwrap();
    session
}

#[tokio::test]
async fn what_a_gripper_carries_is_where_the_last_advance_left_it() {
    let bench = Bench::new();
    let session = advanced_with_a_slab(&bench).await;
    let right = |session: &Session| nodes(session)[3][0];
    let there = || shifted([0.035, 0.0, 0.0]);
    correct(&bench, &session, &there(), CorrectOptions::default()).unwrap();
    assert!((0.015..=0.02).contains(&right(&session)), "{:?}", nodes(&session));
    // Forked slots know it too; the request may know better, where the gripper is at x = 0.03.
    let pose = |x: f32| [x, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0];
    let rows = [pose(0.0), pose(0.03)];
    let grippers = Some(Tensor::pack(&[2, 7], rows.as_flattened()));
    let options = CorrectOptions { grippers, ..CorrectOptions::default() };
    correct(&bench, &session, &there(), options).unwrap();
    assert!((0.024..=0.03).contains(&right(&session)), "{:?}", nodes(&session));
    // After a reset the place of the gripper is unknown.
    session.reset(&[0], None);
    correct(&bench, &session, &there(), CorrectOptions::default()).unwrap();
    correct(&bench, &session, &there(), CorrectOptions::default()).unwrap();
    assert!(right(&session) > 0.03, "{:?}", nodes(&session));
}

#[test]
fn a_slot_that_is_elsewhere_is_lost_and_registered_on_request() {
    let bench = Bench::new();
    let session = session_in(&bench, 2, None);
    // The hand holds the chain where it is, so no correction explains an object 2 m away.
    let away = shifted([2.0, 0.0, 0.0]);
    let strict = || CorrectOptions { max_residual_m: Some(0.02), ..CorrectOptions::default() };
    let reason = |options: CorrectOptions| {
        correct(&bench, &session, &away, options).unwrap_err().reason().to_owned()
    };
    assert_eq!(reason(strict()), "OBSERVATION_NOT_EXPLAINED");
    assert_eq!(reason(strict()), "OBSERVATION_NOT_EXPLAINED");
    assert!(session.describe("").lost.is_empty());
    assert_eq!(reason(strict()), "OBJECT_LOST");
    assert_eq!(session.describe("").lost, [0]);
    let error = correct(&bench, &session, &away, strict()).unwrap_err();
    assert_eq!(error.category(), Category::FailedPrecondition);
    assert!(error.to_string().contains("slot 0 is lost (4 obs"), "{error}");
    for _ in 0..6 {
        assert_eq!(reason(strict()), "OBJECT_LOST");
    }
    // Copies are as lost, other states are not.
    session.fork(0, &[1]);
    assert_eq!(session.describe("").lost, [0, 1]);
    session.reset(&[1], None);
    assert_eq!(session.describe("").lost, [0]);

    // The object is where its hand is, in another shape; in the way is a wall.
    let mut there = shifted([0.0; 3]);
    for (i, x) in there.iter_mut().enumerate() {
        *x = [0.1 * i as f32, 0.0, 0.5];
    }
    let wall = slab([-0.5, 0.003, -1.0], [0.5, 0.1, 1.0]);
    let options = CorrectOptions {
        register_if_lost: true,
        world: Some(World { gravity: vec![0.0; 3], ..world(vec![wall]) }),
        max_residual_m: Some(0.04),
        ..CorrectOptions::default()
    };
    let done = correct(&bench, &session, &there, options.clone()).unwrap();
    assert!(done.registered, "{done:?}");
    assert!(!done.tracking.unwrap().lost && session.describe("").lost.is_empty());
    assert!(done.before.unwrap().median_mm > 150.0 && done.after.unwrap().median_mm < 40.0);
    let start = session.states(&[0]).0.remove(0);
    assert_eq!(*start.controls, twin().graph.control_rest);
    assert!(start.rest.is_none() && start.state.velocities == [[0.0; 3]; 4]);
    assert!(start.state.positions.iter().all(|x| x[1] <= 0.003));
    // One that is not lost is only corrected.
    let done = correct(&bench, &session, &there, options).unwrap();
    assert!(!done.registered);
}

#[test]
fn a_registered_state_is_outside_of_all_obstacles() {
    let bench = Bench::new();
    let there = shifted([0.3, -0.1, 0.2]);
    // The points are 5 mm inside of a post, and the last one is below the ground.
    let post = Collider {
        shape: Some(Shape::Capsule(Capsule {
            from: vec![0.3, -0.115, 0.0],
            to: vec![0.3, -0.115, 1.0],
            radius_m: 0.02,
        })),
        ..Collider::default()
    };
    let plane = bendtwin_proto::v1::Plane { normal: Vec::new(), offset_m: 0.405 };
    let world = World { ground_choice: Some(GroundChoice::Ground(plane)), ..world(vec![post]) };
    for frames in [0, 12] {
        let options = bendtwin_proto::v1::RegisterOptions {
            settle_frames: Some(frames),
            ..Default::default()
        };
        let request = RegisterStateRequest {
            observation: tracked(&there),
            world: Some(world.clone()),
            options: Some(options),
            ..RegisterStateRequest::default()
        };
        let (start, cancel) = (at_rest(&bench), CancelToken::default());
        let found = register_state(&bench.warm, start, request, &bench.backend, &cancel).unwrap();
        let positions = found.state.unwrap().positions.unwrap();
        for x in positions.unpack_points("positions").unwrap().1 {
            let away = ((x[0] - 0.3).powi(2) + (x[1] + 0.115).powi(2)).sqrt();
            assert!(away >= 0.02 && x[2] >= 0.405, "{frames} {x:?}");
        }
    }
}

/// A loop in which the real chain is another one: a fifth of it is seen with 3 mm of noise every
/// 0.1 s while its hand swings over the ground. The session must not count as lost, and nothing may
/// be in the ground.
#[test]
fn a_healthy_loop_is_not_lost() {
    let count = 25;
    let chain = |stiffness: f32| {
        let mut twin = twin();
        let x = |i: usize| [0.02 * i as f32, 0.0, 0.02];
        twin.graph.rest_positions = (0..count).map(x).collect();
        twin.graph.kinds = vec![NodeKind::Observed; count];
        twin.graph.masses = vec![1.0; count];
        twin.graph.object_ids = vec![0; count];
        twin.graph.observed_points = (0..count as u32).collect();
        twin.graph.control_rest = vec![[-0.02, 0.0, 0.02]];
        let next = (1..count as u32).map(|i| [i, i - 1]);
        twin.graph.springs = [[0, count as u32]].into_iter().chain(next).collect();
        twin.graph.triplets = (2..count as u32).map(|i| [i - 2, i - 1, i]).collect();
        twin.params.spring_stiffness = vec![stiffness; count];
        twin.params.spring_dashpot = vec![2.0; count];
        twin.params.rest_lengths_m = vec![0.02; count];
        twin.params.bend_stiffness = vec![0.02; count - 2];
        twin.params.bend_damping = vec![0.0; count - 2];
        twin.params.rest_angles_rad = vec![std::f32::consts::PI; count - 2];
        twin.skin = Skin::of_nodes(&twin.graph);
        twin.environment.ground = Some(Plane { normal: [0.0, 0.0, 1.0], offset_m: 0.0 });
        twin
    };
    let [real, bench] =
        [1500.0, 900.0].map(|k| Bench::of(chain(k), bendtwin_engine::cpu_with_threads(2)));
    let [truth, session] = [&real, &bench].map(|of| session_in(of, 1, None));
    let mut seed = 5u32;
    let mut uniform = || {
        seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (seed >> 8) as f32 / (1 << 23) as f32 - 1.0
    };
    let mut worst = 0.0f64;
    for step in 0..40 {
        for (of, session) in [(&real, &truth), (&bench, &session)] {
            swing(of, session, step);
        }
        let seen: Vec<Point> = nodes(&truth).into_iter().step_by(5).collect();
        // Uniform, of a deviation of 3 mm.
        let mut noisy = |p: Point| p.map(|x| x + 0.003 * 1.73 * uniform());
        let seen: Vec<Point> = seen.into_iter().map(&mut noisy).collect();
        let points = Some(Tensor::pack_points(&[seen.len()], &seen));
        let observation = Some(Observation { points, ..Observation::default() });
        match correct_by(&bench, &session, observation, CorrectOptions::default()) {
            Ok(done) => {
                worst = worst.max(done.tracking.unwrap().misfit);
                assert!(nodes(&session).iter().all(|x| x[2] >= 0.0), "step {step}");
            }
            Err(error) => assert_eq!(error.reason(), "OBSERVATION_NOT_EXPLAINED", "{error}"),
        }
        assert!(session.describe("").lost.is_empty(), "step {step}");
    }
    assert!(worst < 0.9, "{worst}");
}

/// Three frames in which the hand continues along a circle.
fn swing(bench: &Bench, session: &Session, step: usize) {
    let at = |step: usize| {
        let t = step as f32 * 0.15;
        [-0.02 + 0.15 * (1.0 - t.cos()), 0.1 * t.sin(), 0.02 + 0.1 * t.sin().abs()]
    };
    let positions = Tensor::pack_points(&[1, 2, 1], &[at(step), at(step + 1)]);
    let request = RollOutRequest {
        actions: Some(Actions::Trajectories(ControlTrajectories {
            positions: Some(positions),
            interpolation: 0,
        })),
        frames: 3,
        ..RollOutRequest::default()
    };
    let (plan, _) = bench.plan(request, 16).unwrap();
    let start: Start = session.states(&[0]).0.remove(0);
    let execution = Execution {
        plan: &plan,
        starts: &Starts::Shared(start),
        backend: &bench.backend,
        cancel: &CancelToken::default(),
        until: None,
        arrived: Instant::now(),
        worker: "w",
        keeps_states: true,
    };
    let states = execution.run(|_| Ok(())).unwrap();
    let states: Vec<Start> = states.into_iter().map(Option::unwrap).collect();
    session.commit(&[0], states, 3);
}
