use super::*;
use crate::{GripperPoses, TwinId};

const POSE: [f32; 7] = [0.0, 0.0, 0.1, 0.0, 0.0, 0.0, 1.0];

#[test]
fn a_search_of_places_is_sent_and_its_update_is_read() {
    let poses = GripperPoses { shape: [1, 2, 2], poses: vec![POSE; 4], ..GripperPoses::default() };
    let rollout = Rollout::of(TwinId::generate()).poses(poses).frames(9);
    let places = [[POSE, POSE], [POSE, POSE], [POSE, POSE]];
    let planning = Planning::of(rollout.grasp_force_limit(5.0)).grasping([0, 2], &places);
    let request = planning.into_request().unwrap();
    let search = request.grasp_search.unwrap();
    assert_eq!(search.grippers, [0, 2]);
    let (shape, poses) = search.poses.unwrap().unpack::<f32>("poses").unwrap();
    assert_eq!((shape, &poses[35..]), (vec![3, 2, 7], &POSE[..]));
    let limits = request.rollout.unwrap().plausibility.unwrap();
    assert_eq!((limits.grasp_force_n, limits.strain), (Some(5.0), None));

    let update = PlanUpdate::try_from(v1::PlanUpdate {
        grasp: Some(2),
        grasp_costs: Some(Tensor::pack(&[3], &[1.0, f64::INFINITY, 0.5])),
        grasp_force_n: Some(4.0),
        ..v1::PlanUpdate::default()
    })
    .unwrap();
    assert_eq!((update.grasp, update.grasp_costs), (Some(2), vec![1.0, f64::INFINITY, 0.5]));
    assert_eq!((update.grasp_force_n, update.grasp_force_limit_n), (Some(4.0), None));
    let plain = PlanUpdate::try_from(v1::PlanUpdate::default()).unwrap();
    assert_eq!((plain.grasp, plain.grasp_costs), (None, Vec::new()));
}
