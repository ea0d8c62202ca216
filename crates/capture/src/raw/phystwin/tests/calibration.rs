//! Cases without a calibration, and with a `calibration.json`.

use super::*;
use crate::raw::{CALIBRATION_FILE, Calibration, Pose};

type Case = std::collections::BTreeMap<String, Vec<u8>>;

fn opened(case: &Case) -> Result<Recording, Error> {
    raw::open(folder(case).path(), &Limits::default())
}

fn with(calibration: &Calibration) -> Case {
    let mut case = case();
    case.insert(CALIBRATION_FILE.to_owned(), calibration.to_json().into_bytes());
    case
}

#[test]
fn a_case_without_a_calibration_has_cameras_without_poses() {
    let mut case = case();
    case.remove("calibrate.pkl");
    let recording = opened(&case).unwrap();
    assert!(recording.cameras.iter().all(|camera| camera.poses.is_empty()));
    assert_eq!(*recording.cameras[0].pose(0), Pose::IDENTITY);
}

#[test]
fn a_calibration_of_its_own_replaces_that_of_the_case() {
    let before = opened(&case()).unwrap();
    let mut calibration = Calibration::of(&before, "board");
    for camera in &mut calibration.cameras {
        camera.pose = Some(Pose { translation: [0.5, 0.0, 2.0], ..Pose::IDENTITY });
        camera.distortion = Some(Distortion::BrownConrady([0.1; 8]));
    }
    let recording = opened(&with(&calibration)).unwrap();
    // It has z up, against what the case says.
    assert_eq!(recording.cameras[1].poses[0].translation, [0.5, 0.0, 2.0]);
    assert_eq!(recording.cameras[1].distortion, Distortion::BrownConrady([0.1; 8]));
    assert!(recording.sources.lines().any(|line| line.contains("calibration.json (board)")));
    let mut alone = with(&calibration);
    alone.remove("calibrate.pkl");
    assert_eq!(opened(&alone).unwrap().cameras, recording.cameras);
}

#[test]
fn intrinsics_may_stand_in_the_calibration_only() {
    let before = opened(&case()).unwrap();
    let calibration = Calibration::of(&before, "board");
    let mut case = with(&calibration);
    case.remove("calibrate.pkl");
    let mut metadata: serde_json::Value = serde_json::from_slice(&case["metadata.json"]).unwrap();
    metadata.as_object_mut().unwrap().remove("intrinsics");
    case.insert("metadata.json".to_owned(), metadata.to_string().into_bytes());
    assert_eq!(opened(&case).unwrap().cameras, before.cameras);
    let mut without = calibration;
    without.cameras.iter_mut().for_each(|camera| camera.intrinsics = None);
    case.insert(CALIBRATION_FILE.to_owned(), without.to_json().into_bytes());
    let error = opened(&case).unwrap_err().to_string();
    assert!(error.contains("has its intrinsics"), "{error}");
    case.remove(CALIBRATION_FILE);
    assert!(opened(&case).is_err());
}

#[test]
fn what_lies_in_the_case_moves_with_a_calibration() {
    let before = opened(&case()).unwrap();
    let mut calibration = Calibration::of(&before, "board");
    let lift = Pose { translation: [0.0, 0.0, 0.5], ..Pose::IDENTITY };
    for camera in &mut calibration.cameras {
        camera.pose = camera.pose.map(|pose| lift.after(&pose));
    }
    let gripper = r#"{"format": "bendtwin-grippers", "version": 1, "grippers": [{"poses":
        [[0, 0, -1, 0, 0, 0, 1], [0, 0, -1, 0, 0, 0, 1], [0, 0, -1, 0, 0, 0, 1], [0, 0, -1, 0, 0, 0, 1]]}]}"#;
    let mut files = with(&calibration);
    files.insert("grippers.json".to_owned(), gripper.as_bytes().to_vec());
    let height = |recording: &Recording| recording.grippers[0].poses[0].unwrap().translation[2];
    let near = |a: f64, b: f64| (a - b).abs() < 1e-6;
    let moved = opened(&files).unwrap();
    let to_world = moved.mesh.as_ref().unwrap().to_world.unwrap();
    assert!(near(f64::from(to_world.translation[2]), 0.5), "{to_world:?}");
    // One metre above the ground in the case's world, whose z points down.
    assert!(near(height(&moved), 1.5), "{}", height(&moved));
    // Without poses of the case the calibration's world is that of the grippers.
    files.insert("calibrate.pkl".to_owned(), b"no pickle".to_vec());
    assert!(near(height(&opened(&files).unwrap()), -1.0));
    files.remove("calibrate.pkl");
    assert!(near(height(&opened(&files).unwrap()), -1.0));
}

#[test]
fn a_calibration_of_lenses_keeps_the_poses() {
    let before = opened(&case()).unwrap();
    let mut calibration = Calibration::of(&before, "opencv");
    for camera in &mut calibration.cameras {
        camera.pose = None;
        camera.intrinsics = camera.intrinsics.map(|i| Intrinsics { fx: 12.0, ..i });
    }
    calibration.ground = None;
    let recording = opened(&with(&calibration)).unwrap();
    assert_eq!(recording.cameras[1].poses, before.cameras[1].poses);
    assert_eq!(recording.cameras[1].intrinsics.fx, 12.0);
    assert_eq!(recording.environment, before.environment);
    let lines: Vec<String> = recording.sources.lines().collect();
    assert!(lines.contains(&"lens: calibration.json (opencv)".to_owned()), "{lines:?}");
    assert!(lines.iter().any(|line| line.starts_with("pose: calibrate.pkl")), "{lines:?}");
    let mut broken = with(&calibration);
    broken.insert("calibrate.pkl".to_owned(), b"no pickle".to_vec());
    assert!(opened(&broken).is_err());
}

#[test]
fn a_file_of_another_program_is_no_calibration() {
    for text in ["{\"cameras\": []}", "{\"format\": \"other\"}", "[1, 2]", "no JSON"] {
        let mut files = case();
        files.insert(CALIBRATION_FILE.to_owned(), text.as_bytes().to_vec());
        let recording = opened(&files).unwrap();
        assert_eq!(recording.sources.left_out[0].from, CALIBRATION_FILE, "{text}");
    }
    let mut files = with(&Calibration::of(&opened(&case()).unwrap(), "board"));
    files.get_mut(CALIBRATION_FILE).unwrap().pop();
    files.get_mut(CALIBRATION_FILE).unwrap().pop();
    assert!(opened(&files).is_err(), "a broken one");
}

#[test]
fn a_calibration_of_other_cameras_is_refused() {
    let before = opened(&case()).unwrap();
    let mut calibration = Calibration::of(&before, "board");
    calibration.cameras.truncate(1);
    calibration.cameras[0].name = "other".to_owned();
    let error = opened(&with(&calibration)).unwrap_err().to_string();
    assert!(error.contains("1 cameras (`other`)"), "{error}");
}
