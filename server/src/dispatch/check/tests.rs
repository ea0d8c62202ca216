use bendtwin_proto::v1::{
    ControlTrajectories, Cost, InitialState, Returns, RollOutRequest, Tensor,
    initial_state::{GivenState, State},
    roll_out_request::Actions,
};
use bendtwin_store::TwinFacts;

use super::check;
use crate::options::Limits;

/// 2 instances of 4 rows for a twin of 5 nodes and 1 control point.
fn sound() -> RollOutRequest {
    let positions = Some(Tensor::pack(&[2, 4, 1, 3], &[0.0f32; 24]));
    RollOutRequest {
        actions: Some(Actions::Trajectories(ControlTrajectories { positions, interpolation: 0 })),
        ..RollOutRequest::default()
    }
}

fn refused(request: &RollOutRequest, limits: &Limits) -> Option<String> {
    let twin = TwinFacts { node_count: 5, control_count: 1, ..TwinFacts::default() };
    check(request, &twin, limits).err().map(|e| e.to_string())
}

#[test]
fn sound_requests_pass() {
    assert_eq!(refused(&sound(), &Limits::default()), None);
    let given = |shape: &[usize]| {
        let values = vec![0.0f32; shape.iter().product()];
        let positions = Some(Tensor::pack(shape, &values));
        let given = GivenState { positions, velocities: None, twists: None };
        let initial = Some(InitialState { state: Some(State::Given(given)) });
        RollOutRequest { initial, ..sound() }
    };
    assert_eq!(refused(&given(&[5, 3]), &Limits::default()), None);
    assert_eq!(refused(&given(&[2, 5, 3]), &Limits::default()), None);
    assert!(refused(&given(&[3, 5, 3]), &Limits::default()).is_some());
}

#[test]
fn shapes_and_bytes_must_agree() {
    let with = |tensor: Tensor| {
        let t = ControlTrajectories { positions: Some(tensor), interpolation: 0 };
        RollOutRequest { actions: Some(Actions::Trajectories(t)), ..RollOutRequest::default() }
    };
    let base = Tensor::pack(&[2, 4, 1, 3], &[0.0f32; 24]);
    let broken = [
        Tensor::default(),
        Tensor { shape: vec![1 << 40, 1 << 40, 1, 3], ..base.clone() },
        Tensor { shape: vec![2, 4, 3], ..base.clone() },
        Tensor { dtype: 99, ..base.clone() },
        Tensor { data: base.data.slice(1..), ..base },
        Tensor::pack(&[2, 4, 1, 3], &[0u32; 24]),
        Tensor::pack(&[2, 2, 2, 3], &[0.0f32; 24]),
        Tensor::pack(&[8, 1, 1, 3], &[0.0f32; 24]),
        Tensor::pack(&[0, 4, 1, 3], &[0.0f32; 0]),
    ];
    for tensor in broken {
        assert!(refused(&with(tensor.clone()), &Limits::default()).is_some(), "{tensor:?}");
    }
    assert!(refused(&RollOutRequest::default(), &Limits::default()).is_some());
}

#[test]
fn limits_hold() {
    let limits = Limits { rollout_instances: 1, ..Limits::default() };
    assert!(refused(&sound(), &limits).unwrap().contains("split"));
    let long = RollOutRequest { frames: 100_001, ..sound() };
    assert!(refused(&long, &Limits::default()).is_some());
    let limits = Limits { rollout_points: 29, ..Limits::default() };
    assert!(refused(&sound(), &limits).is_some());
    let returns = Returns { every_frames: 1, ..Returns::default() };
    let large = RollOutRequest { returns: Some(returns), ..sound() };
    let limits = Limits { rollout_bytes: 359, ..Limits::default() };
    assert!(refused(&large, &limits).unwrap().contains("360 bytes"));
    let costs = vec![Cost { weight: f64::NAN, ..Cost::default() }];
    assert!(refused(&RollOutRequest { costs, ..sound() }, &Limits::default()).is_some());
}
