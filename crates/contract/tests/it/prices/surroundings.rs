//! The formula beside the encoding of what surroundings add to a reply.

use bendtwin_contract::rollout::{Limits, TwinShape, check_for, memory, reply_bytes};
use bendtwin_contract_kit::rollout as cases;
use bendtwin_proto::v1::{
    Ensemble, Returns, RollOutRequest, Tensor, Vary, roll_out_response::Forces,
};
use prost::Message as _;

/// Memory of a set of parameters beside its arrays [bytes].
const SET: u64 = 4096;
const TWIN: TwinShape = TwinShape { controls: 2, ..crate::TWIN };

fn request(members: u32) -> RollOutRequest {
    let mass = Tensor::pack(&[members as usize], &vec![1.0f32; members as usize]);
    RollOutRequest {
        ensemble: Some(Ensemble { members, ..Ensemble::default() }),
        vary: Some(Vary { mass: Some(mass), ..Vary::default() }),
        ..cases::sound_in_a_world(&TWIN)
    }
}

fn size(request: &RollOutRequest) -> u64 {
    let batch = check_for(request, &TWIN, &Limits::default(), 0).unwrap();
    reply_bytes(request, &batch, &TWIN, 0)
}

#[test]
fn forces_are_counted_to_the_byte() {
    let mut asking = request(3);
    asking.returns = Some(Returns { diagnostics: true, ..Returns::default() });
    let without = size(&asking);
    asking.returns = Some(Returns { diagnostics: true, forces: true, ..Returns::default() });
    // 2 actions of 3 members over 2 frames, 2 control points, a grasp and a collider.
    let tensor = |shape: &[usize]| Some(Tensor::pack(shape, &vec![1.0f32; shape.iter().product()]));
    let reply = bendtwin_proto::v1::RollOutResponse {
        instances: Some(Tensor::pack(&[6], &[0u32; 6])),
        forces: Some(Forces {
            controls: tensor(&[6, 2, 2, 3]),
            grasps: tensor(&[6, 2, 1, 6]),
            ground: tensor(&[6, 2, 3]),
            colliders: tensor(&[6, 2, 1, 6]),
        }),
        ..bendtwin_proto::v1::RollOutResponse::default()
    };
    assert_eq!(size(&asking) - without, reply.encoded_len() as u64);
}

#[test]
fn members_and_their_parameters_take_memory() {
    let limits = Limits { memory_bytes: u64::MAX, reply_bytes: u64::MAX, ..Limits::default() };
    let of = |members| {
        let request = request(members);
        let batch = check_for(&request, &TWIN, &limits, 0).unwrap();
        memory(&request, &batch, &TWIN, 0).fixed
    };
    assert!(of(1000) > of(1) + 999 * SET);
}
