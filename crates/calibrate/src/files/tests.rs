use bendtwin_capture::raw::Camera;
use bendtwin_synth::{FilmOptions, Scene, film};

use super::*;

const KALIBR: &str = "cam0:
  cam_overlaps: [1]
  camera_model: pinhole
  distortion_coeffs: [0.1, -0.2, 0.001, 0.002]
  distortion_model: radtan
  intrinsics: [460.8, 460.8, 211.5, 119.5]
  resolution: [424, 240]
  rostopic: /made0/color/image_raw
cam1:
  T_cn_cnm1:
  - [0.0, -1.0, 0.0, 0.1]
  - [1.0, 0.0, 0.0, 0.2]
  - [0.0, 0.0, 1.0, 0.3]
  - [0.0, 0.0, 0.0, 1.0]
  camera_model: pinhole
  distortion_coeffs: [0.1, 0.2, 0.3, 0.4]
  distortion_model: equidistant
  intrinsics: [461.0, 462.0, 210.0, 120.0]
  resolution: [424, 240]
  rostopic: /made1/color/image_raw
";

const OPENCV: &str = "%YAML:1.0
---
calibration_time: \"Fri 27 Nov 2026\"
image_width: 640
image_height: 480
camera_matrix: !!opencv-matrix
   rows: 3
   cols: 3
   dt: d
   data: [ 6.0e+02, 0., 3.195e+02, 0., 6.01e+02, 2.395e+02, 0., 0., 1. ]
distortion_coefficients: !!opencv-matrix
   rows: 5
   cols: 1
   dt: d
   data: [ 1.0e-01, -2.0e-01, 0., 0., 5.0e-02 ]
";

const XML: &str = r#"<?xml version="1.0"?>
<opencv_storage>
<left>
  <camera_matrix type_id="opencv-matrix"><rows>3</rows><cols>3</cols><dt>d</dt>
    <data>600. 0. 319.5 0. 601. 239.5 0. 0. 1.</data></camera_matrix>
  <distortion_coefficients type_id="opencv-matrix"><rows>1</rows><cols>4</cols><dt>d</dt>
    <data>0.1 0.2 0. 0.</data></distortion_coefficients>
  <rvec type_id="opencv-matrix"><rows>3</rows><cols>1</cols><dt>d</dt><data>0. 0. 1.5707963267948966</data></rvec>
  <tvec type_id="opencv-matrix"><rows>3</rows><cols>1</cols><dt>d</dt><data>1. 2. 3.</data></tvec>
</left>
</opencv_storage>
"#;

const ROS: &str = "image_width: 640
image_height: 480
camera_name: left
camera_matrix:
  rows: 3
  cols: 3
  data: [600, 0, 319.5, 0, 601, 239.5, 0, 0, 1]
distortion_model: rational_polynomial
distortion_coefficients:
  rows: 1
  cols: 8
  data: [0.1, 0.2, 0, 0, 0.3, 0.4, 0.5, 0.6]
rectification_matrix:
  rows: 3
  cols: 3
  data: [1, 0, 0, 0, 1, 0, 0, 0, 1]
projection_matrix:
  rows: 3
  cols: 4
  data: [600, 0, 319.5, 0, 0, 601, 239.5, 0, 0, 0, 1, 0]
";

#[track_caller]
fn near(a: [f64; 3], b: [f64; 3]) {
    assert!((0..3).all(|k| (a[k] - b[k]).abs() < 1e-12), "{a:?} {b:?}");
}

#[test]
fn a_chain_of_kalibr_is_read_from_its_first_camera() {
    let found = parse("camchain.yaml", KALIBR.as_bytes()).unwrap();
    assert_eq!((found.source, found.cameras.len()), ("kalibr", 2));
    let [first, second] = [&found.cameras[0], &found.cameras[1]];
    assert_eq!(first.pose, Some(Pose::IDENTITY));
    assert_eq!(first.size, Some([424, 240]));
    assert!(matches!(first.distortion, Some(Distortion::BrownConrady([0.1, -0.2, 0.001, ..]))));
    assert!(matches!(second.distortion, Some(Distortion::KannalaBrandt([0.1, 0.2, 0.3, 0.4]))));
    // The centre of the second camera: R x + t = 0.
    near(second.pose.unwrap().translation, [-0.2, 0.1, -0.3]);
}

#[test]
fn files_of_opencv_and_ros_are_read_in_their_spellings() {
    let found = parse("left.yml", OPENCV.as_bytes()).unwrap();
    let camera = &found.cameras[0];
    assert_eq!((camera.name.as_str(), camera.size), ("left", Some([640, 480])));
    assert_eq!(camera.intrinsics, Some(Intrinsics { fx: 600.0, fy: 601.0, cx: 319.5, cy: 239.5 }));
    assert!(matches!(
        camera.distortion,
        Some(Distortion::BrownConrady([0.1, -0.2, 0.0, 0.0, 0.05, ..]))
    ));
    assert_eq!(camera.pose, None);
    let found = parse("all.xml", XML.as_bytes()).unwrap();
    let camera = &found.cameras[0];
    assert_eq!(camera.name, "left");
    // x_camera = R x_world + T with a quarter turn about z: the camera stands at -R^T T.
    near(camera.pose.unwrap().translation, [-2.0, 1.0, -3.0]);
    let found = parse("left.yaml", ROS.as_bytes()).unwrap();
    assert_eq!(found.source, "ros");
    assert_eq!(found.cameras[0].pose, None, "R of ROS rectifies");
    assert!(matches!(found.cameras[0].distortion, Some(Distortion::BrownConrady([.., 0.6]))));
    let json = r#"{"cameras": [{"name": "a", "K": [[600,0,320],[0,600,240],[0,0,1]], "dist": [0,0,0,0,0],
        "extrinsics": [[1,0,0,0.5],[0,1,0,0],[0,0,1,0]]}]}"#;
    let found = parse("cameras.json", json.as_bytes()).unwrap();
    near(found.cameras[0].pose.unwrap().translation, [-0.5, 0.0, 0.0]);
    let stereo = "%YAML:1.0\nM1: [[600,0,320],[0,600,240],[0,0,1]]\nD1: [0,0,0,0]\nM2: [[600,0,320],[0,600,240],[0,0,1]]\n\
                  D2: [0,0,0,0]\nR: [[1,0,0],[0,1,0],[0,0,1]]\nT: [-0.1, 0, 0]\n";
    let found = parse("stereo.yml", stereo.as_bytes()).unwrap();
    near(found.cameras[1].pose.unwrap().translation, [0.1, 0.0, 0.0]);
}

#[test]
fn what_is_not_read_is_named() {
    let omni = KALIBR.replacen("pinhole", "omni", 1);
    let fov = KALIBR.replacen("radtan", "fov", 1);
    let alone = KALIBR.replace("T_cn_cnm1", "T_cam_imu");
    let tilted = OPENCV
        .replace("rows: 5", "rows: 14")
        .replace("1.0e-01, -2.0e-01, 0., 0., 5.0e-02", "0,0,0,0,0,0,0,0,0,0,0,0,0.1,0");
    let deep = "[".repeat(100);
    let many = format!("a: [{}]", "1,".repeat(200_001));
    for (text, fault) in [
        (omni.as_str(), "`cam0` has the camera model `omni`"),
        (&fov, "the distortion `fov`"),
        (&alone, "has no T_cn_cnm1"),
        (&tilted, "14 coefficients"),
        (&deep, "nested deeper than"),
        (&many, "more than 200000 values"),
        ("a: &x [1]\nb: *x", "an alias"),
        ("a: [1", "no YAML"),
        ("", "empty"),
        ("hello: world", "no camera matrix"),
        ("<a><b></a>", "no XML"),
        ("<!DOCTYPE a [<!ENTITY b \"c\">]><a>&b;</a>", "document type"),
    ] {
        let error = parse("file", text.as_bytes()).unwrap_err().to_string();
        assert!(error.contains(fault), "{fault}: {error}");
    }
    let more = "camera_matrix: [[600,0,320],[0,600,240],[0,0,1]]\nR: [1, 2]\nT: [1, 2, 3]\n";
    assert!(parse("file", more.as_bytes()).is_err());
}

fn toy() -> Recording {
    let options = FilmOptions { frames: 4, cameras: 2, size: [424, 240], ..FilmOptions::tiny(5) };
    film(Scene::Toy, &options).unwrap()
}

/// Kalibr's chain of two cameras, as it would measure them.
fn chain(cameras: &[Camera]) -> Cameras {
    let first = cameras[0].pose(0).inverse();
    let described = cameras.iter().map(|camera| Described {
        name: format!("/{}/color/image_raw", camera.name),
        size: Some([camera.width, camera.height]),
        intrinsics: Some(camera.intrinsics),
        distortion: Some(Distortion::None),
        pose: Some(first.after(camera.pose(0))),
    });
    Cameras { source: "kalibr", cameras: described.collect() }
}

#[test]
fn a_chain_stands_on_the_ground_of_the_recording() {
    let truth = toy();
    let mut recording = truth.clone();
    recording.cameras.iter_mut().for_each(|camera| camera.poses.clear());
    // Files name cameras: their order does not matter.
    let mut chain = chain(&truth.cameras);
    chain.cameras.reverse();
    let cancel = CancelToken::default();
    let found = calibration(&recording, &[chain], Unit::Metres, &cancel).unwrap();
    found.calibration.apply(&mut recording).unwrap();
    for (camera, truth) in recording.cameras.iter().zip(&truth.cameras) {
        let [height, true_height] = [camera, truth].map(|c| c.pose(0).translation[2]);
        assert!((height - true_height).abs() < 0.004, "{height} {true_height}");
    }
    let codes: Vec<&str> = found.findings.iter().map(|f| f.code.as_str()).collect();
    assert_eq!(codes, ["GROUND_DETECTED"]);
}

#[test]
fn files_of_other_cameras_are_refused() {
    let recording = toy();
    let cancel = CancelToken::default();
    let failed = |cameras: Cameras, unit: Unit| {
        calibration(&recording, &[cameras], unit, &cancel).unwrap_err().to_string()
    };
    let good = chain(&recording.cameras);
    let mut three = good.clone();
    three.cameras.push(Described::default());
    three.cameras.iter_mut().for_each(|camera| camera.name.clear());
    assert!(failed(three, Unit::Metres).contains("it has 3 cameras"));
    let mut large = good.clone();
    large.cameras[1].size = Some([1280, 720]);
    assert!(failed(large, Unit::Metres).contains("calibrated at 1280 x 720"));
    let mut millimetres = good.clone();
    for camera in &mut millimetres.cameras {
        camera.pose = camera.pose.map(|mut pose| {
            pose.translation = pose.translation.map(|x| 1000.0 * x);
            pose
        });
    }
    assert!(failed(millimetres.clone(), Unit::Metres).contains("--unit mm"));
    assert!(calibration(&recording, &[millimetres], Unit::Millimetres, &cancel).is_ok());
    let mut lenses = good.clone();
    lenses.cameras.iter_mut().for_each(|camera| camera.pose = None);
    let found = calibration(&recording, &[lenses], Unit::Metres, &cancel).unwrap();
    assert_eq!(found.findings[0].code, "CALIBRATION_WITHOUT_POSES");
    let mut partly = good;
    partly.cameras[1].pose = None;
    assert!(failed(partly, Unit::Metres).contains("only 1 of 2 cameras"));
}
