//! A PhysTwin case as its cameras recorded it: colour, depth, masks, tracks and calibration beside
//! each other. Its world has z pointing down and the ground at z = 0, as that of a processed case,
//! unless it says otherwise.

mod labels;
mod masks;
mod writer;

use std::{collections::BTreeSet, sync::Arc};

use bendtwin_core::{Environment, Finding};
use serde::Deserialize;

use self::{labels::Labels, masks::Masks};
use super::{
    Alignment, Camera, Distortion, Intrinsics, MeshFile, Pose, Recording,
    decode::DepthUnit,
    gripper,
    numbering::{self, Images, Numbering},
    stored::{CameraFiles, DepthNames, MAX_MESH, StoredFrames, TrackFiles},
    validity,
};
use crate::{
    Error, Limits, Sources,
    files::{Files, at_most},
    frame::Frame,
    phystwin::{json, split, truth},
    pickle,
};

pub use writer::{export_case, write_case};

pub(super) const MARKER: &str = "metadata.json";
const CALIBRATION: &str = "calibrate.pkl";

/// The calibration, where it was not written by Python.
const CALIBRATION_JSON: &str = "calibrate.json";

/// PhysTwin stores millimetres.
const DEPTH_UNIT_M: f64 = 0.001;

#[derive(Deserialize)]
struct Metadata {
    intrinsics: Vec<[[f64; 3]; 3]>,
    #[serde(rename = "WH")]
    size: [usize; 2],
    fps: f64,
    frame_num: Option<usize>,
    #[serde(default)]
    serial_numbers: Vec<String>,
    up_axis: Option<String>,
    #[serde(alias = "depth_scale")]
    depth_unit_m: Option<f64>,
    #[serde(default)]
    object_labels: Vec<String>,
}

/// Reads the case at the root of `files`, but none of its frames.
pub(super) fn read(mut files: Files<'static>) -> Result<Recording, Error> {
    let metadata: Metadata = json(&files.read_document(MARKER)?, MARKER)?;
    let up = metadata.up_axis.as_deref().unwrap_or("-z");
    let frame = Frame::from_up(up).ok_or_else(|| {
        Error::Axes(format!("`up_axis` is `{up}`: it must be one of +x, -x, +y, -y, +z, -z"))
    })?;
    validity::count(metadata.intrinsics.len(), metadata.frame_num.unwrap_or(1), &files.limits)?;
    let cameras = cameras(&mut files, &metadata, &frame)?;
    let images = images(&mut files, &cameras)?;
    let numbering = numbering(&images, metadata.frame_num, &files.limits)?;
    let frame_count = numbering.frame_count;
    let masks = masks::find(&mut files, cameras.len())?;
    let all = masks.iter().flat_map(Masks::labels).map(str::to_owned).collect::<BTreeSet<_>>();
    let labels = Labels::sort(&all, &metadata.object_labels)?;
    let mut notes: Vec<Finding> = numbering.note().into_iter().chain(labels.note()).collect();
    let unit = depth_unit(metadata.depth_unit_m)?;
    let mut stored = Vec::with_capacity(cameras.len());
    let mut sources = Sources::default();
    for (index, ([color, depth], masks)) in images.into_iter().zip(masks).enumerate() {
        notes.extend(masks.note(index));
        for (part, kind) in [("colour", "color"), ("depth", "depth")] {
            sources.take(part, Some(&cameras[index].name), format!("{kind}/{index}"), "");
        }
        let [object, manipulator] = masks.names(&labels, numbering, &color)?;
        stored.push(CameraFiles {
            size: metadata.size,
            color: color.names(numbering),
            depth: Some(DepthNames { names: depth.names(numbering), unit }),
            object,
            manipulator,
            tracks: Some(TrackFiles::Npz(format!("cotracker/{index}.npz"))),
        });
    }
    let mut ignored = Vec::new();
    let mut truth_tracks = truth(&mut files, frame_count, &mut ignored)?;
    frame.apply(&mut truth_tracks);
    let train_frame_count = split(&mut files, frame_count, &mut ignored)?;
    let mesh = mesh(&mut files, &frame)?;
    let grippers = gripper::find(&mut files, frame_count, &frame, &mut sources)?;
    notes.extend(crate::format::taken(&files.list("")));
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
        grippers,
        notes,
        sources,
        source: Arc::new(StoredFrames::new(files.fork(), frame_count, stored)?),
    })
}

fn cameras(
    files: &mut Files<'static>,
    metadata: &Metadata,
    frame: &Frame,
) -> Result<Vec<Camera>, Error> {
    let camera_count = metadata.intrinsics.len();
    let (at, poses) = poses(files)?;
    for (what, count) in [(at, poses.len()), ("`serial_numbers`", metadata.serial_numbers.len())] {
        if count != camera_count && !(what == "`serial_numbers`" && count == 0) {
            return Err(Error::Lengths(format!(
                "{MARKER} has intrinsics of {camera_count} cameras, but {what} has {count}: one each"
            )));
        }
    }
    let mut cameras = Vec::with_capacity(camera_count);
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
            poses: vec![pose.turned(frame)],
            times_s: Vec::new(),
        });
    }
    Ok(cameras)
}

/// Colour and depth of each camera.
fn images(files: &mut Files<'_>, cameras: &[Camera]) -> Result<Vec<[Images; 2]>, Error> {
    let kinds =
        [("colour images", "color", numbering::COLOR), ("depth images", "depth", numbering::DEPTH)];
    let mut of = |index: usize, camera: &Camera| -> Result<[Images; 2], Error> {
        let mut found = [Images::default(), Images::default()];
        for (images, (what, kind, extensions)) in found.iter_mut().zip(kinds) {
            let folder = format!("{kind}/{index}");
            *images = Images::in_folder(files, &folder, extensions)?;
            if images.is_empty() {
                let wanted = format!("`{folder}/NUMBER.{}`", extensions.join("` or `."));
                return Err(numbering::missing(files, &camera.name, what, wanted, &folder));
            }
        }
        Ok(found)
    };
    cameras.iter().enumerate().map(|(index, camera)| of(index, camera)).collect()
}

/// Frames of all images, which must be as many as the description says.
fn numbering(
    images: &[[Images; 2]],
    declared: Option<usize>,
    limits: &Limits,
) -> Result<Numbering, Error> {
    let all: Vec<&Images> = images.iter().flatten().collect();
    let at = format!("`frame_num` of {MARKER}");
    if let Some(count) = declared {
        numbering::expect_all(&all, &at, count)?;
    }
    let numbering = numbering::align(&all, declared.map(|count| (at.as_str(), count)), limits)?;
    validity::count(1, numbering.frame_count, limits)?;
    Ok(numbering)
}

fn depth_unit(declared: Option<f64>) -> Result<DepthUnit, Error> {
    match declared {
        None => Ok(DepthUnit::Usual),
        Some(unit_m) if unit_m.is_finite() && unit_m > 0.0 => Ok(DepthUnit::Declared(unit_m)),
        Some(unit_m) => {
            let fault = format!("`depth_unit_m` is {unit_m}: 0.001 for millimetres");
            Err(Error::Document { at: MARKER.to_owned(), fault })
        }
    }
}

/// Camera-to-world matrices, in the case's own world, and the file that they come from.
fn poses(files: &mut Files<'static>) -> Result<(&'static str, Vec<Pose>), Error> {
    let pose = |(index, rows): (usize, &[[f64; 4]])| Pose::from_rows(&index.to_string(), rows);
    let Some(bytes) = files.find(CALIBRATION)? else {
        let Some(bytes) = files.find_document(CALIBRATION_JSON)? else {
            return Err(Error::MissingFile(format!("{CALIBRATION} (or {CALIBRATION_JSON})")));
        };
        let matrices: Vec<Vec<[f64; 4]>> = json(&bytes, CALIBRATION_JSON)?;
        let poses = matrices.iter().map(Vec::as_slice).enumerate().map(pose);
        return Ok((CALIBRATION_JSON, poses.collect::<Result<_, _>>()?));
    };
    let data = pickle::read(CALIBRATION, &bytes, &files.limits, &mut files.budget)?;
    let mut poses = Vec::new();
    for array in data.arrays()? {
        let rows = match array.shape.as_slice() {
            &[rows @ (3 | 4), 4] | &[_, rows @ (3 | 4), 4] => rows,
            _ => return Err(array.wrong_shape("[4, 4] or [3, 4] for each camera")),
        };
        let count = poses.len() + array.len() / (4 * rows);
        at_most("cameras", count, files.limits.cameras)?;
        let flat = array.doubles(&mut files.budget)?;
        for matrix in flat.as_chunks::<4>().0.chunks_exact(rows) {
            poses.push(pose((poses.len(), matrix))?);
        }
    }
    Ok((CALIBRATION, poses))
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

/// The completed shape: already in the case's world, or as it was generated.
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
