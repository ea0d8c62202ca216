//! A PhysTwin case as its cameras recorded it: colour, depth, masks, tracks and calibration beside
//! each other. Its world has z pointing down and the ground at z = 0, as that of a processed case.

mod writer;

use std::sync::Arc;

use bendtwin_core::Environment;
use serde::Deserialize;

use super::{
    Alignment, Camera, Distortion, Intrinsics, MeshFile, Pose, Recording,
    stored::{CameraFiles, DepthNames, MAX_MESH, MAX_PARTS, Names, StoredFrames, TrackFiles},
    validity,
};
use crate::{
    Error,
    files::{Files, at_most},
    frame::Frame,
    phystwin::{json, split, truth},
    pickle,
};

pub use writer::{export_case, write_case};

pub(super) const MARKER: &str = "metadata.json";
const CALIBRATION: &str = "calibrate.pkl";

/// PhysTwin stores millimetres.
const DEPTH_UNIT_M: f64 = 0.001;

/// Names of masks that show what moves the object.
const MANIPULATORS: [&str; 8] =
    ["hand", "hands", "controller", "controllers", "gripper", "grippers", "finger", "robot"];

#[derive(Deserialize)]
struct Metadata {
    intrinsics: Vec<[[f64; 3]; 3]>,
    #[serde(rename = "WH")]
    size: [usize; 2],
    fps: f64,
    frame_num: usize,
    #[serde(default)]
    serial_numbers: Vec<String>,
}

/// Reads the case at the root of `files`, but none of its frames.
pub(super) fn read(mut files: Files<'static>) -> Result<Recording, Error> {
    let Some(frame) = Frame::from_up("-z") else {
        return Err(Error::Axes("the case's axes are unknown".to_owned()));
    };
    let metadata: Metadata = json(&files.read_document(MARKER)?, MARKER)?;
    let camera_count = metadata.intrinsics.len();
    let frame_count = metadata.frame_num;
    validity::count(camera_count, frame_count, &files.limits)?;
    let poses = poses(&mut files)?;
    for (what, count) in
        [(CALIBRATION, poses.len()), ("`serial_numbers`", metadata.serial_numbers.len())]
    {
        if count != camera_count && !(what == "`serial_numbers`" && count == 0) {
            return Err(Error::Lengths(format!(
                "{MARKER} has intrinsics of {camera_count} cameras, but {what} has {count}: one each"
            )));
        }
    }
    let mut cameras = Vec::with_capacity(camera_count);
    let mut stored = Vec::with_capacity(camera_count);
    for (index, (matrix, pose)) in metadata.intrinsics.iter().zip(&poses).enumerate() {
        let serial = metadata.serial_numbers.get(index);
        let name = serial.cloned().unwrap_or_else(|| index.to_string());
        validity::check_size(&name, metadata.size, &files.limits)?;
        cameras.push(Camera {
            intrinsics: intrinsics(&name, matrix)?,
            name,
            width: metadata.size[0],
            height: metadata.size[1],
            distortion: Distortion::None,
            poses: vec![pose.turned(&frame)],
            times_s: Vec::new(),
        });
        stored.push(camera_files(&mut files, index, metadata.size)?);
    }
    let mut notes = Vec::new();
    let mut truth_tracks = truth(&mut files, frame_count, &mut notes)?;
    frame.apply(&mut truth_tracks);
    let train_frame_count = split(&mut files, frame_count, &mut notes)?;
    let mesh = mesh(&mut files, &frame)?;
    Ok(Recording {
        name: files.name.clone(),
        fps: metadata.fps,
        frame_count,
        train_frame_count,
        environment: Environment::Z_UP,
        source_to_world: frame.rotation,
        cameras,
        mesh,
        truth_tracks,
        mass_kg: None,
        source: Arc::new(StoredFrames::new(files.fork(), frame_count, stored)?),
    })
}

/// Camera-to-world matrices, in the case's own world.
fn poses(files: &mut Files<'static>) -> Result<Vec<Pose>, Error> {
    let bytes = files.read(CALIBRATION)?;
    let data = pickle::read(CALIBRATION, &bytes, &files.limits, &mut files.budget)?;
    let mut flat = Vec::new();
    for array in data.arrays()? {
        match array.shape.as_slice() {
            [4, 4] | [_, 4, 4] => {}
            _ => return Err(array.wrong_shape("[4, 4] for each camera")),
        }
        at_most("cameras", flat.len() / 16 + array.len() / 16, files.limits.cameras)?;
        flat.extend(array.doubles(&mut files.budget)?);
    }
    let matrices = flat.as_chunks::<4>().0.as_chunks::<4>().0;
    matrices.iter().enumerate().map(|(index, m)| Pose::from_matrix(&index.to_string(), m)).collect()
}

fn intrinsics(camera: &str, m: &[[f64; 3]; 3]) -> Result<Intrinsics, Error> {
    let pinhole = m[0][1].abs() < 1e-6 && m[1][0].abs() < 1e-6 && m[2] == [0.0, 0.0, 1.0];
    if !pinhole {
        return Err(Error::Camera {
            camera: camera.to_owned(),
            fault: format!("its intrinsics {m:?} are not [[fx, 0, cx], [0, fy, cy], [0, 0, 1]]"),
        });
    }
    Ok(Intrinsics { fx: m[0][0], fy: m[1][1], cx: m[0][2], cy: m[1][2] })
}

fn camera_files(
    files: &mut Files<'static>,
    index: usize,
    size: [usize; 2],
) -> Result<CameraFiles, Error> {
    let mut masks = CameraFiles {
        size,
        color: Names::numbered(format!("color/{index}/"), ".png"),
        depth: Some(DepthNames {
            names: Names::numbered(format!("depth/{index}/"), ".npy"),
            unit_m: DEPTH_UNIT_M,
        }),
        object: Vec::new(),
        manipulator: Vec::new(),
        tracks: Some(TrackFiles::Npz(format!("cotracker/{index}.npz"))),
    };
    let at = format!("mask/mask_info_{index}.json");
    if let Some(bytes) = files.find_document(&at)? {
        let parts: std::collections::BTreeMap<String, String> = json(&bytes, &at)?;
        at_most("masks of a camera", parts.len(), MAX_PARTS)?;
        for (id, name) in &parts {
            if !id.bytes().all(|b| b.is_ascii_digit()) || id.is_empty() {
                return Err(Error::Document {
                    at,
                    fault: format!("`{id}` is no number of a mask"),
                });
            }
            let names = Names::numbered(format!("mask/{index}/{id}/"), ".png");
            if is_manipulator(name) { &mut masks.manipulator } else { &mut masks.object }
                .push(names);
        }
    }
    Ok(masks)
}

/// `true` if a mask's name, such as `left_hand` or `gripper 2`, is that of what moves the object.
fn is_manipulator(name: &str) -> bool {
    name.to_lowercase()
        .split(|c: char| !c.is_ascii_alphabetic())
        .any(|word| MANIPULATORS.contains(&word))
}

/// The completed shape: brought into the case's world already, or as it was generated.
fn mesh(files: &mut Files<'static>, frame: &Frame) -> Result<Option<MeshFile>, Error> {
    let aligned = Alignment { rotation: frame.rotation, scale: 1.0, translation: [0.0; 3] };
    for (at, to_world) in
        [("shape/matching/final_mesh.glb", Some(aligned)), ("shape/object.glb", None)]
    {
        if let Some(bytes) = files.find_within(at, MAX_MESH)? {
            let name = at.rsplit('/').next().unwrap_or(at).to_owned();
            return Ok(Some(MeshFile { name, bytes, to_world }));
        }
    }
    Ok(None)
}

#[cfg(test)]
mod tests;
