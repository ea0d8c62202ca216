use bendtwin_proto::v1;

use super::*;

#[test]
fn a_correction_is_sent_and_its_reply_is_read() {
    let name = SessionId::generate();
    let seen = Observation::nodes(&[[0.0, 0.0, 1.0]], &[2]);
    let request = Correction::by(seen).give(0.1).max_residual_m(0.02).carry(0.5);
    let request = request.into_request(name, &[1]);
    assert_eq!((request.name, request.slots), (name.to_string(), vec![1]));
    assert!(request.observation.unwrap().points.is_some());
    let options = request.options.unwrap();
    assert_eq!((options.give, options.noise_m), (Some(0.1), None));
    assert_eq!(options.carry, Some(0.5));
    assert_eq!(options.max_residual_m, Some(0.02));

    let after = Some(v1::Residual { mean_mm: 2.0, ..v1::Residual::default() });
    let corrected = Corrected::from(Wire { slot: 1, after, moved_mm: 3.0, ..Wire::default() });
    assert_eq!((corrected.slot, corrected.after.mean_mm, corrected.moved_mm), (1, 2.0, 3.0));
    assert_eq!(corrected.before, Residual::default());
}
