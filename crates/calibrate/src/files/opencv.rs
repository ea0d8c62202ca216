//! OpenCV's file storage, in which every program has its own keys, and ROS's `camera_info`.
//!
//! `R` and `T` take the world to the camera, as `solvePnP` and `stereoCalibrate` give them; in a file
//! of ROS `R` rectifies and is no pose.

use bendtwin_capture::raw::Pose;

use super::{
    Cameras, Described,
    matrix::{self, distortion, pinhole, rotation},
    value::Value,
};

const PINHOLE: [&str; 6] =
    ["camera_matrix", "cameraMatrix", "intrinsic_matrix", "intrinsics", "mtx", "K"];
const LENS: [&str; 8] = [
    "distortion_coefficients",
    "distCoeffs",
    "dist_coeffs",
    "distortion_coeffs",
    "distortion",
    "dist",
    "D",
    "coeffs",
];
const WIDTH: [&str; 3] = ["image_width", "width", "imageWidth"];
const HEIGHT: [&str; 3] = ["image_height", "height", "imageHeight"];
/// Matrices from the world to the camera.
const TO_CAMERA: [&str; 6] =
    ["extrinsic", "extrinsics", "extrinsic_matrix", "T_cam_world", "world2cam", "w2c"];
/// Matrices from the camera to the world.
const TO_WORLD: [&str; 6] =
    ["T_world_cam", "cam2world", "camera_to_world", "c2w", "pose", "camera_pose"];

pub(super) fn cameras(document: &Value) -> Result<Cameras, String> {
    if let Some(camera) = camera(document)? {
        let source = if is_ros(document) { "ros" } else { "opencv" };
        return Ok(Cameras { source, cameras: vec![camera] });
    }
    let stereo = stereo(document)?;
    if !stereo.is_empty() {
        return Ok(Cameras { source: "opencv", cameras: stereo });
    }
    // A map or list of cameras, possibly under one key.
    let mut cameras = nested(document)?;
    for (_, value) in document.entries() {
        if cameras.is_empty() {
            cameras = nested(value)?;
        }
    }
    Ok(Cameras { source: "opencv", cameras })
}

fn nested(value: &Value) -> Result<Vec<Described>, String> {
    let mut found = Vec::new();
    match value {
        Value::Map(entries) => {
            for (key, value) in entries {
                if let Some(camera) = camera(value)? {
                    let name =
                        if camera.name.is_empty() { key.clone() } else { camera.name.clone() };
                    found.push(Described { name, ..camera });
                }
            }
        }
        Value::List(list) => {
            for value in list {
                found.extend(camera(value)?);
            }
        }
        Value::Text(_) => {}
    }
    Ok(found)
}

fn is_ros(value: &Value) -> bool {
    value.get(&["projection_matrix", "P"]).is_some() && value.get(&["distortion_model"]).is_some()
}

/// The camera that a map describes; `None` if it has no camera matrix.
fn camera(value: &Value) -> Result<Option<Described>, String> {
    let Some(intrinsics) = value.get(&PINHOLE).and_then(pinhole) else { return Ok(None) };
    let model = value.get(&["distortion_model", "model"]).and_then(Value::text).unwrap_or_default();
    let flag = value.get(&["fisheye_model", "fisheye"]).and_then(Value::text);
    let fisheye = matches!(model, "equidistant" | "fisheye" | "kannala_brandt")
        || flag.is_some_and(|flag| matches!(flag.trim(), "1" | "true"));
    let numbers = value.get(&LENS).and_then(matrix::flat);
    let lens = numbers.map(|numbers| distortion(&numbers, fisheye)).transpose()?;
    let whole = |keys: &[&str]| value.get(keys)?.text()?.trim().parse::<usize>().ok();
    let name = value.get(&["camera_name", "name", "serial", "serial_number"]).and_then(Value::text);
    let pose = if is_ros(value) { None } else { pose(value)? };
    Ok(Some(Described {
        name: name.unwrap_or_default().to_owned(),
        size: whole(&WIDTH).zip(whole(&HEIGHT)).map(|(width, height)| [width, height]),
        intrinsics: Some(intrinsics),
        distortion: lens,
        pose,
    }))
}

/// The pose in a map, from the camera to the world.
fn pose(value: &Value) -> Result<Option<Pose>, String> {
    if let Some(matrix) = value.get(&TO_WORLD) {
        return matrix::motion(matrix).map(Some).ok_or_else(unusual);
    }
    if let Some(matrix) = value.get(&TO_CAMERA) {
        return matrix::motion(matrix).map(|m| Some(m.inverse())).ok_or_else(unusual);
    }
    let numbers = |keys: &[&str]| value.get(keys).and_then(matrix::flat);
    let turn = numbers(&["R", "rvec", "rotation", "rotation_matrix"]);
    let shift = numbers(&["T", "tvec", "t", "translation", "translation_vector"]);
    let (Some(turn), Some(shift)) = (turn, shift) else { return Ok(None) };
    let Ok(translation) = <[f64; 3]>::try_from(shift) else { return Err(unusual()) };
    let Some(rotation) = rotation(&turn) else { return Err(unusual()) };
    Ok(Some(Pose { rotation, translation }.inverse()))
}

fn unusual() -> String {
    "a pose is neither a matrix of 4 x 4 or 3 x 4, nor R (3 x 3, or a vector of 3) with T (3 numbers)"
        .to_owned()
}

/// The two cameras of `stereoCalibrate`: M1, D1, M2, D2, and R and T from the first to the second.
fn stereo(value: &Value) -> Result<Vec<Described>, String> {
    let Some(second) = value.get(&["M2", "K2", "cameraMatrix2", "camera_matrix_2"]) else {
        return Ok(Vec::new());
    };
    let Some(first) = value.get(&["M1", "K1", "cameraMatrix1", "camera_matrix_1"]) else {
        return Ok(Vec::new());
    };
    let moved = pose(value)?.ok_or_else(|| {
        "it has two cameras without R and T between them: put them into one file".to_owned()
    })?;
    let lenses = [["D1", "distCoeffs1", "dist_coeffs_1"], ["D2", "distCoeffs2", "dist_coeffs_2"]];
    let mut cameras = Vec::new();
    for ((matrix, lens), pose) in
        [first, second].into_iter().zip(lenses).zip([Pose::IDENTITY, moved])
    {
        let numbers = value.get(&lens).and_then(matrix::flat).unwrap_or_default();
        cameras.push(Described {
            intrinsics: Some(pinhole(matrix).ok_or("M1 and M2 must have 3 x 3 numbers")?),
            distortion: Some(distortion(&numbers, false)?),
            pose: Some(pose),
            ..Described::default()
        });
    }
    Ok(cameras)
}
