use bendtwin_proto::v1::Tensor;
use jiff::Timestamp;

use super::*;

fn preview() -> FitPreview {
    FitPreview {
        stage: "refine".into(),
        variant: "bending".into(),
        iteration: 3,
        frames: Some(Tensor::pack(&[2], &[0_u32, 9])),
        positions: Some(Tensor::pack_points_i16(&[2, 1], &[[0.0; 3], [0.0, 0.0, 1.0]])),
        measure: "track".into(),
        error_m: 0.008,
        held_back_m: Some(0.009),
        baseline_m: 0.041,
        ..FitPreview::default()
    }
}

#[test]
fn a_preview_is_kept_as_it_came_with_the_time_of_the_server() {
    let content = encode(&preview()).unwrap();
    let created = Timestamp::from_second(7).unwrap();
    let read = decode("fits/x", StoredPreview { content, created }).unwrap();
    assert_eq!(read.create_time.unwrap().seconds, 7);
    assert_eq!(FitPreview { create_time: None, ..read }, preview());
    let content = "no base64".to_owned();
    assert!(decode("fits/x", StoredPreview { content, created }).is_err());
}

#[test]
fn what_is_no_preview_is_refused() {
    let points = |frames: usize, count: usize| {
        Some(Tensor::pack_points_i16(&[frames, count], &vec![[0.0; 3]; frames * count]))
    };
    let scaled = |scale: f32| Some(Tensor { scale, ..points(2, 1).unwrap() });
    let wrong: [(FitPreview, &str); 13] = [
        (FitPreview { stage: "evaluate".into(), ..preview() }, "stage"),
        (FitPreview { stage: "x".into(), ..preview() }, "stage"),
        (FitPreview { variant: "v".repeat(65), ..preview() }, "variant"),
        (FitPreview { measure: "loss".into(), ..preview() }, "measure"),
        (FitPreview { error_m: f64::NAN, ..preview() }, "no distance"),
        (FitPreview { baseline_m: -1.0, ..preview() }, "no distance"),
        (FitPreview { frames: None, ..preview() }, "frames"),
        (FitPreview { frames: Some(Tensor::pack(&[2], &[9_u32, 9])), ..preview() }, "ascending"),
        (FitPreview { positions: None, ..preview() }, "positions"),
        (FitPreview { positions: points(1, 2), ..preview() }, "positions"),
        (FitPreview { positions: points(2, 0), ..preview() }, "positions"),
        (FitPreview { positions: scaled(f32::INFINITY), ..preview() }, "positions"),
        (FitPreview { positions: points(2, 6000), ..preview() }, "65536"),
    ];
    for (wrong, fault) in wrong {
        let error = encode(&wrong).unwrap_err().to_string();
        assert!(error.contains(fault), "{error} does not name {fault}");
    }
}
