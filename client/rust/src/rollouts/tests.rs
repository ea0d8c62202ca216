use bendtwin_contract::rollout::{Limits, TwinShape, check_for};
use bendtwin_core::ids::TwinId;
use bendtwin_proto::v1::{RollOutResponse, Tensor, roll_out_request::Actions, roll_out_response};

use super::*;

#[test]
fn a_builder_makes_the_request_it_describes() {
    let request = Rollout::of(TwinId::generate())
        .trajectories([2, 3, 1], vec![[0.0; 3]; 6])
        .cubic()
        .frames(20)
        .cost(Cost::keypoints("tip", 2.0, &[4], &[[1.0, 2.0, 3.0]]).squared().every_frame())
        .record_every(5)
        .best(1)
        .into_request()
        .unwrap();
    assert!(matches!(request.actions, Some(Actions::Trajectories(_))));
    assert_eq!((request.frames, request.costs.len()), (20, 1));
    assert_eq!(request.returns.unwrap().every_frames, 5);
}

#[test]
fn what_the_builder_makes_passes_the_check() {
    let skin_points = Some(9);
    let twin =
        TwinShape { nodes: 5, skin_points, controls: 1, rods: Some(1), ..TwinShape::default() };
    let points = [[0.0; 3]; 5];
    let pose = [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0];
    let line = Line::Axis { point: [0.1; 3], direction: [0.0, 0.0, 1.0] };
    let costs = |rollout: Rollout| {
        rollout
            .cost(Cost::target_cloud("cloud", 1.0, &points[..2]))
            .cost(Cost::keypoints("tip", 0.0, &[4], &points[..1]).squared())
            .cost(Cost::target_cloud("nodes", 1.0, &points[..2]).at_nodes())
            .cost(Cost::skin_keypoints("skin", 1.0, &[8], &points[..1]))
            .cost(Cost::smoothness("", 0.5))
            .cost(Cost::strain("strain", -1.0, 0.1).every_frame())
            .cost(Cost::force("force", 1.0, ForceBy::Control(0), 2.0).soft_min(0.1))
            .cost(Cost::force("weight", 1.0, ForceBy::Ground, 2.0))
            .cost(Cost::height("height", 1.0, [0.0, 0.0, 1.0], 0.1).of_nodes(&[1]))
            .cost(Cost::within("within", 1.0, [0.0; 3], [1.0; 3]))
            .cost(Cost::control_path("path", 1.0))
            .cost(Cost::control_speed("speed", 1.0, 0.5))
            .cost(Cost::order("order", 1.0, &[0, 1, 2], [0.0, 1.0, 0.0], 0.01).success_at_most(0.0))
            .cost(Cost::order("skin order", 1.0, &[], [0.0, 1.0, 0.0], 0.0).at_skin_points(&[8, 0]))
            .cost(Cost::winding("winding", 1.0, &[0, 4], line, -1.5))
            .cost(Cost::coverage("covered", 0.0, &points, 0.02).at_nodes().success_at_most(0.1))
            .control_gradients()
            .initial_gradients()
            .gradient_norms()
            .frame_costs()
            .executed_controls()
    };
    let trajectories = Rollout::of(TwinId::generate())
        .trajectories([2, 3, 1], vec![[0.0; 3]; 6])
        .from_state(&points, &points)
        .twisted(&[0.1])
        .record_every(1)
        .velocities()
        .cost(Cost::target_cloud("paths", 1.0, &[[0.0; 3]; 12]).shaped(&[2, 2, 3]).every_frame())
        .record_nodes(&[0, 4])
        .int16();
    let poses =
        GripperPoses { shape: [1, 2, 1], poses: vec![pose; 2], gripper_of_control: vec![0] };
    let poses = Rollout::of(TwinId::generate()).poses(poses).cubic().best(1).final_state();
    let poses = poses.record_every(1).record_skin_points(&[8, 0]);
    for rollout in [costs(trajectories), costs(poses)] {
        let request = rollout.into_request().unwrap();
        check_for(&request, &twin, &Limits::default(), 0).unwrap();
    }
}

#[test]
fn what_surrounds_an_object_passes_the_check() {
    let twin = TwinShape { nodes: 5, controls: 1, rods: Some(0), ..TwinShape::default() };
    let pose = [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0];
    let poses =
        GripperPoses { shape: [1, 2, 1], poses: vec![pose; 2], gripper_of_control: Vec::new() };
    let corners = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let world = World::default()
        .gravity([0.0, 0.0, -1.6])
        .ground([0.0, 0.0, 1.0], 0.1)
        .ground_surface(0.8, 0.0)
        .collider(Collider::new(Shape::sphere([0.0; 3], 0.1)).surface(0.3, 0.1).margin(0.01))
        .collider(Collider::new(Shape::capsule([0.0; 3], [1.0, 0.0, 0.0], 0.1)).at(pose))
        .collider(Collider::new(Shape::cuboid([0.0; 3], [1.0; 3])).on_gripper(0))
        .collider(Collider::new(Shape::convex(&corners)).along(&[pose; 2]));
    let request = Rollout::of(TwinId::generate())
        .poses(poses)
        .world(world)
        .grasp(Grasp::sphere(0, [0.0; 3], 0.03).closed(&[true, false]).max_force(2.0))
        .grasp(Grasp::cuboid(0, [0.0; 3], [1.0; 3]).springs(0.0, 0.0))
        .grasp(Grasp::nodes(0, &[1, 2]))
        .grasp(Grasp::hand(0, 0))
        .vary(Vary { mass: vec![1.0, 2.0], ..Vary::default() })
        .ensemble(2, Statistic::Cvar(0.5))
        .cost(Cost::smoothness("", 1.0))
        .cost(Cost::winding("around", 1.0, &[0, 1, 2], Line::Capsule(1), 1.0))
        .gradient(15, 0.001)
        .control_gradients()
        .refuse_implausible()
        .forces()
        .into_request()
        .unwrap();
    check_for(&request, &twin, &Limits::default(), 0).unwrap();
    let of_mean = Statistic::MeanPrediction.of(3);
    assert_eq!((of_mean.members, of_mean.statistic().as_str_name()), (3, "MEAN_PREDICTION"));
    assert_eq!((request.grasps.len(), request.world.unwrap().colliders.len()), (4, 4));
}

#[test]
fn a_wrong_shape_is_refused_before_it_is_sent() {
    let rollout = Rollout::of(TwinId::generate()).trajectories([2, 3, 1], vec![[0.0; 3]; 5]);
    let error = rollout.into_request().unwrap_err();
    assert!(error.message().contains("5 elements"), "{error}");
    let huge = Rollout::of(TwinId::generate()).trajectories([usize::MAX, 3, 1], Vec::new());
    assert!(huge.into_request().is_err());
}

#[test]
fn a_reply_unpacks() {
    let reply = Reply::try_from(RollOutResponse {
        first_instance: 8,
        costs: Some(Tensor::pack(&[3], &[2.0, 1.0, f64::INFINITY])),
        instances: Some(Tensor::pack(&[1], &[9u32])),
        frames: Some(Tensor::pack(&[2], &[5u32, 10])),
        forces: Some(roll_out_response::Forces {
            grasps: Some(Tensor::pack(&[1, 1, 1, 6], &[0.5f32; 6])),
            ..roll_out_response::Forces::default()
        }),
        implausible: vec![roll_out_response::Implausible {
            reason: "STRAIN".into(),
            ..roll_out_response::Implausible::default()
        }],
        positions: Some(Tensor::pack_points(&[1, 2, 1], &[[1.0; 3], [2.0; 3]])),
        velocities: Some(Tensor::pack_points(&[1, 2, 1], &[[3.0; 3], [4.0; 3]])),
        gradient_exploded: Some(Tensor::pack(&[1], &[1u32])),
        frame_costs: Some(Tensor::pack(&[1, 2, 1], &[0.5, 0.25])),
        successes: Some(Tensor::pack(&[3], &[1.0f32, 0.5, 0.0])),
        ..RollOutResponse::default()
    })
    .unwrap();
    assert_eq!(reply.best(), Some(9));
    assert_eq!(reply.forces.as_ref().unwrap().grasps, [0.5; 6]);
    assert_eq!(reply.implausible[0].reason, "STRAIN");
    assert_eq!(reply.recorded(0, 1), Some(&[[2.0; 3]][..]));
    assert_eq!(reply.recorded(0, 2), None);
    assert_eq!(reply.recorded(1, 0), None);
    assert_eq!(reply.velocities, [[3.0; 3], [4.0; 3]]);
    assert_eq!(reply.successes, [1.0, 0.5, 0.0]);
    assert_eq!((reply.gradient_exploded, reply.frame_costs), (vec![true], vec![0.5, 0.25]));
}

#[test]
fn a_state_that_comes_out_goes_in_again() {
    let twin = TwinShape { nodes: 2, controls: 1, rods: Some(1), ..TwinShape::default() };
    let row = |x: f32| vec![[x; 3], [x + 0.5; 3]];
    let wire = RollOutResponse {
        instances: Some(Tensor::pack(&[2], &[0u32, 1])),
        final_positions: Some(Tensor::pack_points(&[2, 2], &[row(0.0), row(1.0)].concat())),
        final_velocities: Some(Tensor::pack_points(&[2, 2], &[row(2.0), row(3.0)].concat())),
        final_twists: Some(Tensor::pack(&[2, 1], &[0.1f32, 0.2])),
        final_controls: Some(Tensor::pack_points(&[2, 1], &[[4.0; 3], [5.0; 3]])),
        final_commanded_controls: Some(Tensor::pack_points(&[2, 1], &[[6.0; 3], [7.0; 3]])),
        ..RollOutResponse::default()
    };
    let reply = Reply::try_from(wire).unwrap();
    let state = reply.state(1).unwrap();
    assert_eq!((&state.positions, &state.velocities), (&row(1.0), &row(3.0)));
    assert_eq!((&state.twists[..], &state.controls[..]), (&[0.2][..], &[[5.0; 3]][..]));
    assert_eq!(state.commanded_controls, [[7.0; 3]]);
    assert_eq!(reply.state(2), None);
    let request = Rollout::of(TwinId::generate())
        .trajectories([2, 3, 1], vec![[0.0; 3]; 6])
        .zero()
        .period_s(0.1)
        .frames(9)
        .going_on(&state)
        .into_request()
        .unwrap();
    check_for(&request, &twin, &Limits::default(), 0).unwrap();
}
