use prost::Message as _;

use super::*;
use crate::{
    rollout::{TwinShape, cases},
    v1::{
        Cost, PlanRequest, Returns, RollOutRequest, StepSessionRequest, Tensor,
        cost::{Keypoints, Kind},
    },
};

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
