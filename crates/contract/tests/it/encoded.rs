//! The check of encoded requests.

use bendtwin_contract::rollout::{Encoded, Limits, TwinShape, check, check_encoded};
use bendtwin_contract_kit::rollout as cases;
use bendtwin_proto::{
    tensor::MOST_DIMENSIONS,
    v1::{
        AdvanceSessionRequest, ControlTrajectories, Cost, InitialState, PlanRequest, Returns,
        RollOutRequest, StepSessionRequest, Tensor,
        cost::{Keypoints, Kind},
        initial_state::{GivenState, State},
        roll_out_request::Actions,
    },
};
use prost::Message as _;

fn encoded(change: impl FnOnce(&mut RollOutRequest)) -> Vec<u8> {
    let twin = TwinShape { nodes: 5, controls: 2, ..TwinShape::default() };
    let mut request = cases::sound(&twin);
    change(&mut request);
    request.encode_to_vec()
}

#[test]
fn costs_are_counted_before_they_are_decoded() {
    let limits = Limits::default();
    let with = |count: usize| {
        let request = encoded(|r| r.costs = vec![Cost::default(); count]);
        let rollout = RollOutRequest::decode(&*request).unwrap();
        let search = Some(PlanRequest { rollout: Some(rollout), ..PlanRequest::default() });
        let step = StepSessionRequest { search, ..StepSessionRequest::default() }.encode_to_vec();
        let found = check_encoded(Encoded::RollOut, &request, &limits);
        assert_eq!(check_encoded(Encoded::Step, &step, &limits), found);
        found
    };
    assert_eq!(with(256), Ok(()));
    let refused = with(257).unwrap_err().to_string();
    assert!(refused.contains("number of costs would be 257"), "{refused}");
}

/// The first kilobyte of a batch tells how large it is.
#[test]
fn instances_are_counted_before_their_actions_have_come() {
    let limits = Limits { instances: 1_000, ..Limits::default() };
    let positions = |count: usize| {
        let values = vec![0.5f32; count * 2 * 3];
        Some(Tensor::pack(&[count, 2, 1, 3], &values))
    };
    let trajectories = |count: usize| {
        let positions = positions(count);
        let actions = ControlTrajectories { positions, ..ControlTrajectories::default() };
        RollOutRequest {
            twin: "twins/0".into(),
            actions: Some(Actions::Trajectories(actions)),
            ..RollOutRequest::default()
        }
    };
    let look = |request: &RollOutRequest| {
        let bytes = request.encode_to_vec();
        assert!(bytes.len() > 20_000);
        check_encoded(Encoded::RollOut, &bytes[..1_000], &limits)
    };
    assert_eq!(look(&trajectories(1_000)), Ok(()));
    let refused = look(&trajectories(1_001)).unwrap_err();
    assert_eq!(refused, check(&trajectories(1_001), &limits).unwrap_err());
    assert!(refused.to_string().contains("split the batch"), "{refused}");
    let advance = AdvanceSessionRequest {
        name: "sessions/0".into(),
        rollout: Some(trajectories(1_001)),
        ..AdvanceSessionRequest::default()
    };
    let bytes = advance.encode_to_vec();
    assert_eq!(check_encoded(Encoded::Advance, &bytes[..1_000], &limits), Err(refused));
}

#[test]
fn a_tensor_has_few_dimensions_wherever_it_stands() {
    let flat = |dimensions: usize| {
        Some(Tensor { dtype: 1, shape: vec![0; dimensions], ..Tensor::default() })
    };
    let limits = Limits::default();
    let with = |dimensions: usize| {
        let returns = Some(Returns { nodes: flat(dimensions), ..Returns::default() });
        check_encoded(Encoded::RollOut, &encoded(|r| r.returns = returns), &limits)
    };
    assert_eq!(with(MOST_DIMENSIONS), Ok(()));
    assert!(with(10_000).is_err());
    let returns = Some(Returns { skin_points: flat(100), ..Returns::default() });
    assert!(check_encoded(Encoded::RollOut, &encoded(|r| r.returns = returns), &limits).is_err());
    let keypoints = Keypoints { skin_points: flat(100), ..Keypoints::default() };
    let cost = Cost { kind: Some(Kind::Keypoints(keypoints)), ..Cost::default() };
    assert!(check_encoded(Encoded::RollOut, &encoded(|r| r.costs = vec![cost]), &limits).is_err());
    let state = State::Given(GivenState { commanded_controls: flat(100), ..GivenState::default() });
    let initial = Some(InitialState { state: Some(state) });
    assert!(check_encoded(Encoded::RollOut, &encoded(|r| r.initial = initial), &limits).is_err());
    let plan = PlanRequest { sigma: flat(100), ..PlanRequest::default() }.encode_to_vec();
    assert!(check_encoded(Encoded::Plan, &plan, &limits).is_err());
    // One by one, not packed, as old encoders write them.
    let one_by_one = [&[0x3a, 203, 1, 0x12, 200, 1][..], &[0x10, 0].repeat(100)[..]].concat();
    let decoded = RollOutRequest::decode(&*one_by_one).unwrap();
    assert_eq!(decoded.returns.unwrap().nodes.unwrap().shape.len(), 100);
    assert!(check_encoded(Encoded::RollOut, &one_by_one, &limits).is_err());
}

#[test]
fn requests_that_are_accepted_otherwise_pass() {
    let twin = TwinShape { nodes: 5, controls: 2, ..TwinShape::default() };
    for case in cases::malformed(&twin) {
        let found =
            check_encoded(Encoded::RollOut, &case.request.encode_to_vec(), &Limits::default());
        let counted = ["257 costs", "33 colliders", "33 grasps"].contains(&case.what);
        assert_eq!(found.is_err(), counted, "{}: {found:?}", case.what);
    }
    let unknown = [0x78, 0].repeat(1_000_001);
    assert!(check_encoded(Encoded::RollOut, &unknown, &Limits::default()).is_err());
    assert_eq!(check_encoded(Encoded::RollOut, b"no message at all", &Limits::default()), Ok(()));
    assert_eq!(check_encoded(Encoded::RollOut, &[0x32, 0xff, 0xff], &Limits::default()), Ok(()));
}
