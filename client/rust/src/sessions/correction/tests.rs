use bendtwin_proto::v1::{self, Tensor, initial_state::GivenState};

use super::*;

#[test]
fn a_correction_is_sent_and_its_reply_is_read() {
    let name = SessionId::generate();
    let seen = Observation::nodes(&[[0.0, 0.0, 1.0]], &[2]);
    let ball = crate::Collider::new(crate::Shape::sphere([0.0; 3], 0.1));
    let request = Correction::by(seen).give(0.1).max_residual_m(0.02).carry(0.5);
    let request = request.world(World::default().collider(ball)).grippers(&[[0.0; 7]; 2]);
    let request = request.register_if_lost().omit_state();
    let request = request.into_request(name, &[1]);
    assert_eq!((request.name, request.slots), (name.to_string(), vec![1]));
    assert!(request.observation.unwrap().points.is_some());
    let options = request.options.unwrap();
    assert_eq!((options.give, options.noise_m), (Some(0.1), None));
    assert_eq!(options.carry, Some(0.5));
    assert_eq!(options.max_residual_m, Some(0.02));
    assert_eq!(options.world.unwrap().colliders.len(), 1);
    assert_eq!(options.grippers.unwrap().shape, [2, 7]);
    assert!(options.register_if_lost && options.omit_state);

    let after = Some(v1::Residual { mean_mm: 2.0, ..v1::Residual::default() });
    let wire = Wire { slot: 1, after, moved_mm: 3.0, ..Wire::default() };
    let corrected = Corrected::try_from(wire.clone()).unwrap();
    assert_eq!((corrected.slot, corrected.after.mean_mm, corrected.moved_mm), (1, 2.0, 3.0));
    assert_eq!(corrected.before, Residual::default());
    assert_eq!((corrected.state, corrected.tracking), (None, Tracking::default()));
    let positions = Some(Tensor::pack_points(&[1], &[[0.5; 3]]));
    let state = Some(GivenState { positions, ..GivenState::default() });
    let tracking = Some(v1::Tracking { lost: true, misfit: 1.25, unexplained: 4 });
    let wire = Wire { state, tracking, registered: true, ..wire };
    let corrected = Corrected::try_from(wire).unwrap();
    assert_eq!(corrected.state.unwrap().positions, [[0.5; 3]]);
    assert!(corrected.tracking.lost && corrected.registered);
}
