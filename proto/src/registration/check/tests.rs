use bendtwin_core::{Category, Problem as _};

use super::*;
use crate::{
    registration::cases,
    v1::{CorrectOptions, InitialState, RegisterOptions, initial_state::Settled},
};

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
    has_capture: false,
};

#[test]
fn each_fault_is_refused_and_named() {
    for case in cases::malformed(&TWIN) {
        let error = check_registration(&case.request, &TWIN, &Limits::default()).unwrap_err();
        assert!(error.to_string().contains(case.names), "{}: {error}", case.what);
        assert_eq!(error.category(), Category::InvalidArgument, "{}", case.what);
        if case.names.contains("observation") {
            assert_eq!(error.reason(), "INVALID_OBSERVATION", "{}", case.what);
        }
    }
}

#[test]
fn what_is_right_passes() {
    let settled = InitialState { state: Some(State::Settled(Settled {})) };
    let sound = RegisterStateRequest {
        initial: Some(settled),
        controls: Some(Tensor::pack_points(&[1], &[[0.0; 3]])),
        ..cases::sound()
    };
    check_registration(&sound, &TWIN, &Limits::default()).unwrap();
    let observation = cases::sound().observation;
    let correction = CorrectSessionRequest { observation, ..CorrectSessionRequest::default() };
    check_correction(&correction, &TWIN, &Limits::default()).unwrap();
    let blind = CorrectSessionRequest { observation: None, ..correction };
    let error = check_correction(&blind, &TWIN, &Limits::default()).unwrap_err();
    assert_eq!(error.reason(), "INVALID_OBSERVATION");
}

#[test]
fn a_carried_share_is_one() {
    let with = |carry| CorrectSessionRequest {
        observation: cases::sound().observation,
        options: Some(CorrectOptions { carry, ..CorrectOptions::default() }),
        ..CorrectSessionRequest::default()
    };
    assert_eq!(carry(&with(None)), 1.0);
    for sound in [None, Some(0.0), Some(0.5), Some(1.0)] {
        check_correction(&with(sound), &TWIN, &Limits::default()).unwrap();
    }
    for wrong in [-0.1, 1.5, f64::NAN] {
        let error = check_correction(&with(Some(wrong)), &TWIN, &Limits::default()).unwrap_err();
        assert_eq!(error.reason(), "INVALID_OBSERVATION");
        assert!(error.to_string().contains("options.carry"), "{error}");
    }
}

#[test]
fn limits_of_work_memory_and_reply_hold() {
    let tight = [
        Limits { work: 1000, ..Limits::default() },
        Limits { memory_bytes: 1000, ..Limits::default() },
        Limits { reply_bytes: 100, ..Limits::default() },
    ];
    for limits in tight {
        let error = check_registration(&cases::sound(), &TWIN, &limits).unwrap_err();
        assert_eq!(error.reason(), "ROLLOUT_TOO_LARGE", "{error}");
    }
    let options = Some(RegisterOptions { settle_frames: Some(1000), ..Default::default() });
    let long = RegisterStateRequest { options, ..cases::sound() };
    let work = |request| registration_work(request, &TWIN);
    assert_eq!(work(&long) - work(&cases::sound()), (1000 - 12) * 10 * 12);
}
