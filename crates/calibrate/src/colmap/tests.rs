//! Models of a made scene in another gauge: turned, moved and scaled.

mod made;

use bendtwin_capture::raw::Recording;
use bendtwin_core::Severity;
use bendtwin_synth::{FilmOptions, Scene, film};

use self::made::{Gauge, Made};
use super::*;

fn toy() -> Recording {
    let options = FilmOptions { frames: 4, cameras: 3, size: [424, 240], ..FilmOptions::tiny(5) };
    film(Scene::Toy, &options).unwrap()
}

fn imported(model: &Model, recording: &Recording) -> Imported {
    calibration(model, recording, &CancelToken::default()).unwrap()
}

/// Largest error of the distances between cameras, as a share, and of their heights [m].
fn errors(calibration: &Calibration, truth: &Recording) -> [f64; 2] {
    let mut worst = [0.0_f64; 2];
    let place = |i: usize| calibration.cameras[i].pose.unwrap().translation;
    let distance =
        |a: [f64; 3], b: [f64; 3]| (0..3).map(|k| (a[k] - b[k]).powi(2)).sum::<f64>().sqrt();
    for a in 0..truth.cameras.len() {
        let true_place = |i: usize| truth.cameras[i].pose(0).translation;
        worst[1] = worst[1].max((place(a)[2] - true_place(a)[2]).abs());
        for b in 0..a {
            let ratio = distance(place(a), place(b)) / distance(true_place(a), true_place(b));
            worst[0] = worst[0].max((ratio - 1.0).abs());
        }
    }
    worst
}

#[test]
fn a_scene_in_any_gauge_gets_its_scale_and_its_ground() {
    let recording = toy();
    for (seed, gauge) in Gauge::SOME.iter().enumerate() {
        let made = Made::of(&recording, gauge, seed as u64);
        let found = imported(&made.model(), &recording);
        let [scale, height] = errors(&found.calibration, &recording);
        println!("scale off by {:.3} %, height by {:.2} mm", 100.0 * scale, 1e3 * height);
        assert!(scale < 0.005 && height < 0.01, "{scale} {height}");
        let warning = found.findings.iter().find(|f| f.severity != Severity::Info);
        assert!(warning.is_none(), "{warning:?}");
    }
}

#[test]
fn binary_and_text_forms_say_the_same() {
    let made = Made::of(&toy(), &Gauge::SOME[0], 1);
    let model = made.model();
    let [cameras, images, points] = made.binary();
    assert_eq!(parse(&cameras, &images, &points, true).unwrap(), model);
    let [cameras, images, points] = made.text();
    assert_eq!(
        parse(cameras.as_bytes(), images.as_bytes(), points.as_bytes(), false).unwrap(),
        model
    );
    let folder = tempfile::tempdir().unwrap();
    let sparse = folder.path().join("sparse/0");
    std::fs::create_dir_all(&sparse).unwrap();
    assert!(!is_model(folder.path()));
    for (name, bytes) in ["cameras.bin", "images.bin", "points3D.bin"].iter().zip(made.binary()) {
        std::fs::write(sparse.join(name), bytes).unwrap();
    }
    assert!(is_model(folder.path()) && is_model(&sparse));
    assert_eq!(open(folder.path()).unwrap(), model);
}

#[test]
fn a_model_without_observations_is_measured_at_its_points() {
    let recording = toy();
    let mut model = Made::of(&recording, &Gauge::SOME[1], 2).model();
    model.images.iter_mut().for_each(|image| image.points.clear());
    let [scale, _] = errors(&imported(&model, &recording).calibration, &recording);
    assert!(scale < 0.01, "{scale}");
}

#[test]
fn what_is_missing_is_named() {
    let recording = toy();
    let model = Made::of(&recording, &Gauge::SOME[0], 3).model();
    let failed = |model: &Model, recording: &Recording| {
        calibration(model, recording, &CancelToken::default()).unwrap_err().to_string()
    };
    let mut one = model.clone();
    one.images.truncate(2);
    let error = failed(&one, &recording);
    assert!(error.contains("2 images"), "{error}");
    let mut far = model.clone();
    far.points.clear();
    let error = failed(&far, &recording);
    assert!(error.contains("record depth"), "{error}");
    let mut focal = model;
    focal.cameras.iter_mut().for_each(|camera| camera.parameters[0] *= 1.1);
    let codes: Vec<String> =
        imported(&focal, &recording).findings.into_iter().map(|f| f.code).collect();
    assert!(codes.iter().any(|code| code == "COLMAP_FOCAL_DIFFERS"), "{codes:?}");
}

#[test]
fn files_that_lie_about_their_size_are_refused() {
    let made = Made::of(&toy(), &Gauge::SOME[0], 1);
    let [cameras, images, points] = made.binary();
    let damaged = |which: usize, change: &dyn Fn(&mut Vec<u8>)| {
        let mut all = [cameras.clone(), images.clone(), points.clone()];
        change(&mut all[which]);
        parse(&all[0], &all[1], &all[2], true).unwrap_err().to_string()
    };
    for which in 0..3 {
        let error = damaged(which, &|bytes| bytes[..8].fill(0xff));
        assert!(error.contains("there is room for"), "{error}");
        let error = damaged(which, &|bytes| bytes.truncate(bytes.len() - 3));
        assert!(error.contains("ends early") || error.contains("room for"), "{error}");
    }
    let error = damaged(0, &|bytes| bytes[12] = 99);
    assert!(error.contains("camera model 99"), "{error}");
    for text in ["1 NEW_MODEL 10 10 1", "1 PINHOLE 10 10 1 2 3", "1 PINHOLE 10 10 inf 1 1 1"] {
        assert!(parse(text.as_bytes(), b"", b"", false).is_err(), "{text}");
    }
}
