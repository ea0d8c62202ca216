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
    // It has z up, whatever the case says.
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
fn a_calibration_of_other_cameras_is_refused() {
    let before = opened(&case()).unwrap();
    let mut calibration = Calibration::of(&before, "board");
    calibration.cameras.truncate(1);
    calibration.cameras[0].name = "other".to_owned();
    let error = opened(&with(&calibration)).unwrap_err().to_string();
    assert!(error.contains("1 cameras (`other`)"), "{error}");
}
