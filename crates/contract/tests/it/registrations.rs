//! The check of registrations and corrections.

use bendtwin_contract::{
    registration::{carry, check_correction, check_registration, registration_work},
    rollout::Limits,
};
use bendtwin_contract_kit::registration as cases;
use bendtwin_core::{Category, Problem as _};
use bendtwin_proto::v1::{
    Collider, CorrectOptions, CorrectSessionRequest, InitialState, RegisterOptions,
    RegisterStateRequest, Sphere, Tensor, World,
    collider::{Carrier, Shape},
    initial_state::{Settled, State},
};

use crate::TWIN;

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
    check_correction(&correction, 1, 0, &TWIN, &Limits::default()).unwrap();
    let blind = CorrectSessionRequest { observation: None, ..correction };
    let error = check_correction(&blind, 1, 0, &TWIN, &Limits::default()).unwrap_err();
    assert_eq!(error.reason(), "INVALID_OBSERVATION");
}

#[test]
fn a_carried_share_is_one() {
    let with = |carry| CorrectSessionRequest {
        observation: cases::sound().observation,
        options: Some(CorrectOptions { carry, ..CorrectOptions::default() }),
        ..CorrectSessionRequest::default()
    };
    assert_eq!(carry(&CorrectOptions::default()), 1.0);
    for sound in [None, Some(0.0), Some(0.5), Some(1.0)] {
        check_correction(&with(sound), 1, 0, &TWIN, &Limits::default()).unwrap();
    }
    for wrong in [-0.1, 1.5, f64::NAN] {
        let error =
            check_correction(&with(Some(wrong)), 1, 0, &TWIN, &Limits::default()).unwrap_err();
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

#[test]
fn a_correction_of_many_slots_fits_the_reply_or_leaves_states_out() {
    let with = |options| CorrectSessionRequest {
        observation: cases::sound().observation,
        options: Some(options),
        ..CorrectSessionRequest::default()
    };
    let check = |options: CorrectOptions, slots, limits: &Limits| {
        check_correction(&with(options), slots, 2, &TWIN, limits)
    };
    let tight = Limits { reply_bytes: 4000, ..Limits::default() };
    check(CorrectOptions::default(), 1, &tight).unwrap();
    let error = check(CorrectOptions::default(), 15, &tight).unwrap_err();
    assert!(error.to_string().contains("omit_state"), "{error}");
    check(CorrectOptions { omit_state: true, ..CorrectOptions::default() }, 15, &tight).unwrap();

    let lost = CorrectOptions { register_if_lost: true, ..CorrectOptions::default() };
    let few = Limits { work: 500_000, ..Limits::default() };
    check(lost.clone(), 2, &few).unwrap();
    let error = check(lost, 20, &few).unwrap_err();
    assert!(error.to_string().contains("register_if_lost"), "{error}");
}

#[test]
fn surroundings_of_a_correction_are_those_of_a_world_and_of_grippers() {
    let with = |world, grippers| {
        let options = CorrectOptions { world, grippers, ..CorrectOptions::default() };
        let request = CorrectSessionRequest {
            observation: cases::sound().observation,
            options: Some(options),
            ..CorrectSessionRequest::default()
        };
        check_correction(&request, 1, 0, &TWIN, &Limits::default())
    };
    let ball = Collider {
        shape: Some(Shape::Sphere(Sphere { radius_m: 0.1, ..Sphere::default() })),
        carrier: Some(Carrier::Gripper(1)),
        ..Collider::default()
    };
    let world = World { colliders: vec![ball], ..World::default() };
    let poses = |count: usize| {
        let pose = [0.0f32, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0];
        Some(Tensor::pack(&[count, 7], &pose.repeat(count)))
    };
    with(Some(world.clone()), poses(2)).unwrap();
    with(Some(world.clone()), None).unwrap();
    for wrong in [poses(33), Some(Tensor::pack(&[1, 6], &[0.5f32; 6]))] {
        let error = with(Some(world.clone()), wrong).unwrap_err();
        assert!(error.to_string().contains("options.grippers"), "{error}");
    }
    let shapeless = World { colliders: vec![Collider::default()], ..World::default() };
    let error = with(Some(shapeless), None).unwrap_err();
    assert!(error.to_string().contains("world.colliders[0].shape"), "{error}");
}
