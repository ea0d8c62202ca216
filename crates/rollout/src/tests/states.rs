//! Whole states: the final state of a rollout starts the next, bit for bit.

use bendtwin_proto::v1::{self, GripperPoses};

use super::*;

/// Poses of a gripper that swings and turns, at every frame of 0..=12, shape [B, 13, 1, 7].
fn swing(instances: usize) -> Vec<[f32; 7]> {
    let pose = |b: usize, frame: usize| {
        let (t, b) = (frame as f32 / 12.0, b as f32);
        let (sine, cosine) = (0.3 * t * (1.0 + b)).sin_cos();
        [0.1 * t * b, 0.05 * t, 0.65 + 0.02 * t, 0.0, sine, 0.0, cosine]
    };
    (0..instances).flat_map(|b| (0..=12).map(move |frame| pose(b, frame))).collect()
}

fn carried(instances: usize, rows: std::ops::RangeInclusive<usize>) -> RollOutRequest {
    let (knots, all) = (rows.end() - rows.start() + 1, swing(instances));
    let chosen: Vec<[f32; 7]> =
        all.chunks(13).flat_map(|instance| instance[rows.clone()].to_vec()).collect();
    let poses = Tensor::pack(&[instances, knots, 1, 7], chosen.as_flattened());
    RollOutRequest {
        actions: Some(Actions::Poses(GripperPoses {
            poses: Some(poses),
            ..GripperPoses::default()
        })),
        returns: Some(Returns { final_state: true, ..Returns::default() }),
        ..RollOutRequest::default()
    }
}

/// The final state of a reply as an initial one.
fn going_on(part: RollOutResponse) -> Option<InitialState> {
    let given = GivenState {
        positions: part.final_positions,
        velocities: part.final_velocities,
        twists: part.final_twists,
        controls: part.final_controls,
        commanded_controls: part.final_commanded_controls,
        grasping: part.final_grasping,
    };
    Some(InitialState { state: Some(State::Given(given)) })
}

/// The twin's control point pins no node, as all of a recording with depth.
#[test]
fn poses_resume_from_a_state_bit_for_bit() {
    let bench = Bench::new();
    assert!(bench.warm.twin.graph.pins.is_empty());
    let whole = bench.run(carried(3, 0..=12), 0).unwrap().remove(0);
    for split in [1, 5, 11] {
        let first = bench.run(carried(3, 0..=split), 0).unwrap().remove(0);
        let mut second = carried(3, split..=12);
        second.initial = going_on(first);
        let second = bench.run(second, 0).unwrap().remove(0);
        assert_eq!(second.final_positions, whole.final_positions, "split at {split}");
        assert_eq!(second.final_velocities, whole.final_velocities);
        assert_eq!(second.final_controls, whole.final_controls);
    }
    // And it has moved.
    let (_, controls) = whole.final_controls.unwrap().unpack_points("c").unwrap();
    assert!((controls[2][0] - 0.0).abs() > 0.05, "{controls:?}");
}

/// A gripper dives into the ground, turns there and comes up again.
#[test]
fn stopped_grippers_resume_from_a_state_bit_for_bit() {
    let bench = Bench::new();
    let dive = |frame: usize| {
        let (t, turn) = (frame as f32 / 12.0, 0.04 * frame as f32);
        [0.1 * t, 0.0, 0.65 - 0.5 * t * (1.0 - t), 0.0, turn.sin(), 0.0, turn.cos()]
    };
    let request = |rows: std::ops::RangeInclusive<usize>| {
        let poses: Vec<[f32; 7]> = rows.map(dive).collect();
        let poses = Some(Tensor::pack(&[1, poses.len(), 1, 7], poses.as_flattened()));
        let ground = v1::Plane { normal: Vec::new(), offset_m: 0.55 };
        RollOutRequest {
            actions: Some(Actions::Poses(GripperPoses { poses, ..GripperPoses::default() })),
            world: Some(v1::World {
                ground_choice: Some(v1::world::GroundChoice::Ground(ground)),
                ..v1::World::default()
            }),
            returns: Some(Returns { final_state: true, diagnostics: true, ..Returns::default() }),
            ..RollOutRequest::default()
        }
    };
    let whole = bench.run(request(0..=12), 0).unwrap().remove(0);
    assert!(whole.diagnostics[0].stopped_hand_m > 0.05, "{:?}", whole.diagnostics);
    for split in [1, 6, 11] {
        let first = bench.run(request(0..=split), 0).unwrap().remove(0);
        let is_held = first.final_controls != first.final_commanded_controls;
        assert_eq!(is_held, split == 6);
        let mut second = request(split..=12);
        second.initial = going_on(first);
        let second = bench.run(second, 0).unwrap().remove(0);
        assert_eq!(second.final_positions, whole.final_positions, "split at {split}");
        assert_eq!(second.final_velocities, whole.final_velocities);
        assert_eq!(second.final_controls, whole.final_controls);
        assert_eq!(second.final_commanded_controls, whole.final_commanded_controls);
    }
}

#[test]
fn a_state_of_one_starts_all_instances() {
    let bench = Bench::new();
    let mut first = bench.run(carried(1, 0..=6), 0).unwrap().remove(0);
    let single = |tensor: &mut Option<Tensor>| {
        let tensor = tensor.as_mut().unwrap();
        tensor.shape.remove(0);
    };
    single(&mut first.final_positions);
    single(&mut first.final_velocities);
    single(&mut first.final_controls);
    single(&mut first.final_commanded_controls);
    let mut second = carried(2, 6..=12);
    second.initial = going_on(first);
    let (plan, wanted) = bench.plan(second, 0).unwrap();
    let Wanted::Ready(starts) = wanted else { panic!("a given state") };
    let controls = |i| plan.instance(i, &starts).controls[0];
    assert_eq!(controls(0), controls(1));
    assert_ne!(controls(0), bench.warm.twin.graph.control_rest[0]);
}

#[test]
fn control_points_that_are_not_given_are_assumed_at_rest_and_the_gap_is_known() {
    let bench = Bench::new();
    let graph = &bench.warm.twin.graph;
    let moved: Vec<_> = graph.rest_positions.iter().map(|p| [p[0] + 0.2, p[1], p[2]]).collect();
    let with = |controls: Option<Tensor>| {
        let positions = Some(Tensor::pack_points(&[4], &moved));
        let given = GivenState { positions, controls, ..GivenState::default() };
        let mut request = carried(1, 0..=12);
        request.initial = Some(InitialState { state: Some(State::Given(given)) });
        let (plan, wanted) = bench.plan(request, 0).unwrap();
        let Wanted::Ready(starts) = wanted else { panic!("a given state") };
        let controls = plan.instance(0, &starts).controls;
        (controls[0], starts.of(0).gap_m(&controls[..1]))
    };
    let (assumed, gap) = with(None);
    assert_eq!(assumed, graph.control_rest[0]);
    assert!((gap - 0.2).abs() < 1e-6, "{gap}");
    let given = [0.21, 0.0, 0.6];
    assert_eq!(with(Some(Tensor::pack_points(&[1], &[given]))), (given, 0.0));
}

#[test]
fn knots_have_separate_times() {
    let bench = Bench::new();
    let with = |at: &[f32], interpolation: i32| {
        let mut request = request(1);
        let knots: Vec<_> = at.iter().map(|t| [0.3 * t * t, 0.0, 0.6]).collect();
        request.actions = Some(Actions::Trajectories(ControlTrajectories {
            positions: Some(Tensor::pack_points(&[1, at.len(), 1], &knots)),
            interpolation,
        }));
        let times = Times::AtS(Tensor::pack(&[at.len()], at));
        request.knot_times = Some(KnotTimes { times: Some(times) });
        let (plan, wanted) = bench.plan(request, 0).unwrap();
        let Wanted::Ready(starts) = wanted else { panic!("at rest") };
        plan.instance(0, &starts).controls.iter().map(|p| p[0]).collect::<Vec<_>>()
    };
    // 6 frames at 30 a second; knots in frames 0, 3 and 4.5.
    let held = with(&[0.0, 0.1, 0.15], 3);
    let expected = [0.0, 0.0, 0.0, 0.003, 0.003, 0.00675, 0.00675f32];
    assert!(held.iter().zip(expected).all(|(x, e)| (x - e).abs() < 1e-7), "{held:?}");
    let linear = with(&[0.0, 0.1, 0.15], 1);
    assert!((linear[1] - 0.001).abs() < 1e-7 && (linear[4] - 0.0055).abs() < 1e-7, "{linear:?}");
}
