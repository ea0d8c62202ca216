use bendtwin_proto::v1::{ControlTrajectories, cost::TargetCloud, roll_out_request::Actions};

use super::*;
use crate::rollout::{Limits, TwinShape, check_for};

/// 5 nodes that hang from a control point.
const TWIN: TwinShape = TwinShape {
    nodes: 5,
    springs: 4,
    triplets: 3,
    controls: 1,
    skin_points: Some(9),
    rods: Some(0),
    substeps: 10,
    fast_substeps: None,
    planner: None,
    has_capture: false,
};

/// Two instances of three knots.
fn sound() -> RollOutRequest {
    let positions = Some(Tensor::pack(&[2, 3, 1, 3], &[0.0f32; 18]));
    let actions = ControlTrajectories { positions, ..ControlTrajectories::default() };
    RollOutRequest { actions: Some(Actions::Trajectories(actions)), ..RollOutRequest::default() }
}

#[test]
fn targets_may_differ_by_frame_and_instance() {
    let limits = Limits::default();
    let with = |shape: &[usize], when: When, temperature: f64| {
        let points = Some(Tensor::pack(shape, &vec![0.0f32; shape.iter().product()]));
        let kind = Some(Kind::TargetCloud(TargetCloud { points, point_set: 0 }));
        let cost = Cost { when: when.into(), temperature, kind, ..Cost::default() };
        RollOutRequest { costs: vec![cost], ..sound() }
    };
    let total = |request: &RollOutRequest| {
        let batch = check_for(request, &TWIN, &limits, 0).unwrap();
        [
            targets(&request.costs, &batch),
            own_targets(&request.costs, &batch, false),
            own_targets(&request.costs, &batch, true),
        ]
    };
    // 2 instances, 2 frames, and 16 for each list.
    assert_eq!(total(&with(&[7, 3], When::LastFrame, 0.0)), [23, 0, 23]);
    assert_eq!(total(&with(&[2, 7, 3], When::EveryFrame, 0.0)), [46, 0, 46]);
    assert_eq!(total(&with(&[2, 1, 7, 3], When::LastFrame, 0.0)), [46, 23, 23]);
    assert_eq!(total(&with(&[2, 1, 7, 3], When::EveryFrame, 0.0)), [92, 46, 46]);
    assert_eq!(total(&with(&[2, 2, 7, 3], When::SoftMin, 0.1)), [92, 46, 46]);
}
