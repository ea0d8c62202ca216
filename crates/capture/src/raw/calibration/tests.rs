use std::sync::Arc;

use bendtwin_core::{Environment, geometry::IDENTITY};

use super::*;
use crate::raw::{Alignment, Camera, Frames, MeshFile, Source};

#[derive(Debug)]
struct Nothing;

impl Source for Nothing {
    fn frames(&self, camera: usize) -> Result<Box<dyn Frames + '_>, Error> {
        Err(Error::NoCamera(camera))
    }
}

fn camera(name: &str, poses: Vec<Pose>) -> Camera {
    Camera {
        name: name.to_owned(),
        width: 640,
        height: 480,
        intrinsics: Intrinsics { fx: 600.0, fy: 600.0, cx: 320.0, cy: 240.0 },
        distortion: Distortion::None,
        poses,
        times_s: Vec::new(),
        fps: None,
    }
}

fn at(x: f64) -> Pose {
    Pose { translation: [x, 0.0, 1.0], ..Pose::IDENTITY }
}

fn recording(cameras: Vec<Camera>) -> Recording {
    Recording {
        name: "test".to_owned(),
        fps: 30.0,
        frame_count: 2,
        train_frame_count: 1,
        environment: Environment::Z_UP,
        source_to_world: IDENTITY,
        cameras,
        mesh: None,
        truth_tracks: Vec::new(),
        mass_kg: None,
        grippers: Vec::new(),
        notes: Vec::new(),
        sources: crate::Sources::default(),
        source: Arc::new(Nothing),
    }
}

fn three(names: [&str; 3]) -> Recording {
    let cameras = names.iter().enumerate().map(|(i, name)| camera(name, vec![at(i as f64)]));
    recording(cameras.collect())
}

#[test]
fn a_document_is_read_as_it_was_written() {
    let mut calibration = Calibration::of(&three(["a", "b", "c"]), "board");
    calibration.cameras[1].distortion = Some(Distortion::KannalaBrandt([0.1, 0.2, 0.3, 0.4]));
    calibration.cameras[1].reprojection_px = Some(0.25);
    calibration.cameras[2].pose = None;
    calibration.cameras[2].intrinsics = None;
    let read = Calibration::read(calibration.to_json().as_bytes(), &Limits::default()).unwrap();
    assert_eq!(read, calibration);
}

#[test]
fn rules_are_checked_one_by_one() {
    let good = Calibration::of(&three(["a", "b", "c"]), "board").to_json();
    let broken = |from: &str, to: &str| {
        assert!(good.contains(from), "{from}: {good}");
        let text = good.replacen(from, to, 1);
        Calibration::read(text.as_bytes(), &Limits::default()).unwrap_err().to_string()
    };
    for (from, to, fault) in [
        ("bendtwin-calibration", "other", "its format is `other`"),
        ("\"version\": 1", "\"version\": 2", "it has version 2"),
        ("\"name\": \"b\"", "\"name\": \"a\"", "two of its cameras are called `a`"),
        ("\"fx\": 600.0", "\"fx\": 0.0", "focal lengths"),
        ("640", "0", "0 x 480"),
        ("\"normal\"", "\"up\"", "up"),
        ("\"source\"", "\"origin\"", "origin"),
        ("1.0,\n            0.0", "2.0,\n            0.0", "orthonormal"),
    ] {
        let error = broken(from, to);
        assert!(error.contains(fault), "{fault}: {error}");
    }
    let few = Limits { cameras: 2, ..Limits::default() };
    assert!(matches!(Calibration::read(good.as_bytes(), &few), Err(Error::TooMany { .. })));
    let none = r#"{"format":"bendtwin-calibration","version":1,"cameras":[]}"#;
    assert!(Calibration::read(none.as_bytes(), &Limits::default()).is_err());
}

#[test]
fn cameras_are_matched_by_name_and_otherwise_by_order() {
    let calibration = Calibration::of(&three(["a", "b", "c"]), "board");
    let mut turned = three(["c", "b", "a"]);
    calibration.apply(&mut turned).unwrap();
    assert_eq!(turned.cameras[0].poses, [at(2.0)]);
    let mut unnamed = three(["0", "1", "2"]);
    unnamed.cameras.iter_mut().for_each(|camera| camera.poses.clear());
    calibration.apply(&mut unnamed).unwrap();
    assert_eq!(unnamed.cameras[2].poses, [at(2.0)]);
    let mut two = recording(vec![camera("0", vec![]), camera("1", vec![])]);
    let error = calibration.apply(&mut two).unwrap_err().to_string();
    assert!(error.contains("3 cameras (`a`, `b`, `c`)"), "{error}");
    let mut larger = three(["a", "b", "c"]);
    larger.cameras[1].width = 1280;
    let error = calibration.apply(&mut larger).unwrap_err().to_string();
    assert!(error.contains("calibrated for 640 x 480"), "{error}");
    let mut partly = recording(vec![camera("a", vec![]), camera("d", vec![])]);
    let error = calibration.apply(&mut partly).unwrap_err().to_string();
    assert!(error.contains("camera `d`") && error.contains("no pose"), "{error}");
}

#[test]
fn what_lies_in_the_world_moves_with_most_cameras() {
    let mut before = three(["a", "b", "c"]);
    before.truth_tracks = vec![[0.0; 3], [1.0, 0.0, 0.0]];
    let alignment = Alignment { rotation: IDENTITY, scale: 1.0, translation: [0.0; 3] };
    before.mesh =
        Some(MeshFile { name: "a.obj".to_owned(), bytes: Vec::new(), to_world: Some(alignment) });
    // One camera is corrected: the world stays.
    let mut corrected = before.clone();
    let mut calibration = Calibration::of(&before, "correction");
    calibration.cameras[0].pose = Some(at(0.1));
    calibration.apply(&mut corrected).unwrap();
    assert_eq!(corrected.truth_tracks, before.truth_tracks);
    assert_eq!(corrected.mesh, before.mesh);
    // All are moved: so is the world.
    let lift = Pose { translation: [0.0, 0.0, 0.5], ..Pose::IDENTITY };
    let mut lifted = before;
    for camera in &mut calibration.cameras {
        camera.pose = camera.pose.map(|pose| lift.after(&pose));
    }
    calibration.apply(&mut lifted).unwrap();
    assert_eq!(lifted.truth_tracks[1], [1.0, 0.0, 0.5]);
    assert_eq!(lifted.mesh.unwrap().to_world.unwrap().translation, [0.0, 0.0, 0.5]);
}

#[test]
fn ground_and_gravity_change_where_the_world_does() {
    let mut before = three(["a", "b", "c"]);
    before.environment = Environment { gravity: [0.0, 0.0, -1.6], ground: None };
    let mut calibration = Calibration::of(&before, "correction");
    calibration.cameras[0].pose = Some(at(0.1));
    let applied = |calibration: &Calibration| {
        let mut recording = before.clone();
        calibration.apply(&mut recording).unwrap();
        recording.environment
    };
    assert_eq!(applied(&calibration), before.environment);
    let plane = Plane { normal: [0.0, 0.0, 1.0], offset_m: -0.25 };
    calibration.ground = Some(plane);
    assert_eq!(applied(&calibration), Environment { ground: Some(plane), ..before.environment });
    let lift = Pose { translation: [0.0, 0.0, 0.5], ..Pose::IDENTITY };
    for camera in &mut calibration.cameras {
        camera.pose = camera.pose.map(|pose| lift.after(&pose));
    }
    assert_eq!(applied(&calibration), Environment { ground: Some(plane), ..Environment::Z_UP });
    calibration.ground = None;
    assert_eq!(applied(&calibration), Environment::Z_UP);
}

#[test]
fn what_it_has_is_listed_in_place_of_what_it_replaces() {
    let mut calibration = Calibration::of(&three(["a", "b", "c"]), "board");
    let taken_of = |calibration: &Calibration| {
        let mut sources = Sources::default();
        sources.take("lens", None, "metadata.json", "");
        sources.take("pose", Some("a"), "calibrate.pkl", "");
        sources.take("pose", Some("b"), "calibrate.pkl", "");
        calibration.tell(&mut sources, "calibration.json");
        sources.lines().collect::<Vec<_>>()
    };
    let all = ["lens: calibration.json (board)", "pose: calibration.json (board)"];
    assert_eq!(taken_of(&calibration), all);
    for camera in &mut calibration.cameras {
        (camera.intrinsics, camera.distortion) = (None, None);
    }
    calibration.cameras[0].pose = None;
    calibration.cameras.truncate(2);
    let some =
        ["lens: metadata.json", "pose of a: calibrate.pkl", "pose of b: calibration.json (board)"];
    assert_eq!(taken_of(&calibration), some);
}

#[test]
fn a_camera_that_moves_keeps_its_motion() {
    let mut moving = recording(vec![camera("a", vec![at(0.0), at(0.5)])]);
    let mut calibration = Calibration::of(&moving, "ground");
    calibration.cameras[0].pose = Some(Pose { translation: [0.0, 0.0, 2.0], ..Pose::IDENTITY });
    calibration.apply(&mut moving).unwrap();
    assert_eq!(moving.cameras[0].poses[1].translation, [0.5, 0.0, 2.0]);
}
