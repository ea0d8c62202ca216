//! The check of pictures.

use bendtwin_contract::{
    picture::{MAX_PIXELS, check_pictures, reply_bytes},
    rollout::{Encoded, Limits, check_encoded},
};
use bendtwin_contract_kit::picture as cases;
use bendtwin_core::{Category, Problem as _};
use bendtwin_proto::v1::{
    PictureCamera, Prop, RenderSessionRequest, RenderedSession, Tensor, rendered_session::Pictures,
};
use prost::Message as _;

#[test]
fn each_fault_is_refused_and_named() {
    for case in cases::malformed() {
        let error = check_pictures(&case.request, 3, &Limits::default()).unwrap_err();
        assert!(error.to_string().contains(case.names), "{}: {error}", case.what);
        assert_eq!(error.category(), Category::InvalidArgument, "{}", case.what);
        assert_eq!(error.reason(), "INVALID_PICTURE", "{}", case.what);
    }
}

#[test]
fn what_is_right_passes_for_all_slots_and_for_each() {
    let sound = cases::sound();
    for slots in [1, 3, 1024] {
        check_pictures(&sound, slots, &Limits::default()).unwrap();
    }
    let floats = |row: &[f32]| {
        let shape = [3, row.len()];
        let shape = if row.len() == 1 { &shape[..1] } else { &shape[..] };
        Some(Tensor::pack(shape, &row.repeat(3)))
    };
    let mut each = sound;
    let pose = [0.0, 0.0, 0.5, 0.0, 0.0, 1.0, 0.0];
    each.cameras[0].intrinsics = floats(&[9.0, 9.0, 7.5, 5.5]);
    each.cameras[0].pose = floats(&pose);
    each.props[0].pose = floats(&pose);
    each.props[0].color = Some(Tensor::pack(&[3, 3], &[7_u8; 9]));
    let light = each.light.as_mut().unwrap();
    (light.direction, light.ambient) = (floats(&[0.0, 0.0, 1.0]), floats(&[0.5]));
    for shape in [&[3][..], &[3, 3], &[12, 16, 3], &[3, 12, 16, 3]] {
        let background = vec![5_u8; shape.iter().product()];
        each.cameras[0].background = Some(Tensor::pack(shape, &background));
        check_pictures(&each, 3, &Limits::default()).unwrap();
    }
    let error = check_pictures(&each, 2, &Limits::default()).unwrap_err().to_string();
    assert!(error.contains("the 2 slots"), "{error}");
}

#[test]
fn pixels_slots_and_replies_are_bounded_together() {
    let camera = PictureCamera { width: 2048, height: 2048, ..cases::camera() };
    let request = RenderSessionRequest { cameras: vec![camera], ..RenderSessionRequest::default() };
    check_pictures(&request, 2, &Limits::default()).unwrap();
    let error = check_pictures(&request, 3, &Limits::default()).unwrap_err();
    assert!(error.to_string().contains(&MAX_PIXELS.to_string()), "{error}");
    assert_eq!(error.reason(), "ROLLOUT_TOO_LARGE");
    let tight = Limits { reply_bytes: 24 << 20, ..Limits::default() };
    let error = check_pictures(&request, 2, &tight).unwrap_err().to_string();
    assert!(error.contains("the size of the reply") && error.contains("smaller"), "{error}");
    let error = check_pictures(&cases::sound(), 1025, &Limits::default()).unwrap_err();
    assert!(error.to_string().contains("`slots`"), "{error}");
}

#[test]
fn replies_are_no_larger_than_expected() {
    for (slots, all) in [(1, true), (7, false), (300, true)] {
        let request = RenderSessionRequest {
            cameras: vec![cases::camera(); 2],
            depths: all,
            labels: all,
            ..RenderSessionRequest::default()
        };
        let size = [slots, 12, 16];
        let count = slots * 12 * 16;
        let pictures = Pictures {
            colors: Some(Tensor::pack(&[slots, 12, 16, 3], &vec![1_u8; 3 * count])),
            depths: all.then(|| Tensor::pack(&size, &vec![1.0_f32; count])),
            labels: all.then(|| Tensor::pack(&size, &vec![1_u8; count])),
        };
        let reply = RenderedSession { cameras: vec![pictures; 2], slots: vec![u32::MAX; slots] };
        let (bound, size) = (reply_bytes(&request, slots as u64), reply.encoded_len() as u64);
        assert!(size <= bound && bound <= 2 * size, "{size} {bound}");
    }
}

#[test]
fn cameras_and_props_are_counted_before_they_are_decoded() {
    let cameras = RenderSessionRequest {
        cameras: vec![PictureCamera::default(); 100_000],
        ..RenderSessionRequest::default()
    };
    let props = RenderSessionRequest {
        props: vec![Prop::default(); 100_000],
        ..RenderSessionRequest::default()
    };
    for (names, request) in [("`cameras`", cameras), ("`props`", props)] {
        let bytes = request.encode_to_vec();
        let error = check_encoded(Encoded::Render, &bytes, &Limits::default()).unwrap_err();
        assert!(error.to_string().contains(names), "{error}");
    }
    let sound = cases::sound().encode_to_vec();
    check_encoded(Encoded::Render, &sound, &Limits::default()).unwrap();
}
