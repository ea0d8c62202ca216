//! A PhysTwin case as its cameras recorded it: colour, depth, masks, tracks and calibration beside
//! each other. Its world has z pointing down and the ground at z = 0, as that of a processed case,
//! unless it says otherwise.

mod labels;
mod layout;
mod masks;
mod metadata;
mod poses;
mod timing;
mod writer;

use std::sync::Arc;

use bendtwin_core::{Environment, geometry::IDENTITY};

pub(super) use self::layout::is_case;
use self::{layout::Folders, metadata::Metadata, poses::Poses};
use super::{
    Alignment, Calibration, Camera, Distortion, Intrinsics, MeshFile, Recording, gripper,
    numbering::{self, Images},
    stored::{CameraFiles, DepthNames, MAX_MESH, StoredFrames, TrackFiles, probe},
    validity,
};
use crate::{
    Error, Sources,
    files::Files,
    frame::Frame,
    phystwin::{json, split, truth},
};

pub(crate) use labels::names_manipulator;
pub use writer::{export_case, write_case};

pub(super) const MARKER: &str = "metadata.json";

/// PhysTwin stores millimetres.
const DEPTH_UNIT_M: f64 = 0.001;

/// Reads the case at the root of `files`, but none of its frames. Lenses are those of a calibration
/// beside it as far as it has them; poses are the case's own, which the calibration replaces later, and
/// moves what lies in the world along. Without either, cameras have no poses.
pub(super) fn read(
    mut files: Files<'static>,
    calibration: Option<&Calibration>,
) -> Result<Recording, Error> {
    let mut metadata: Metadata = json(&files.read_document(MARKER)?, MARKER)?;
    metadata.camera_count = match (metadata.intrinsics.len(), calibration) {
        (0, Some(calibration)) => calibration.cameras.len(),
        (count, _) => count,
    };
    let up = metadata.up_axis.as_deref().unwrap_or("-z");
    let frame = Frame::of_up_axis(up)?;
    validity::count(metadata.camera_count, metadata.frame_num.unwrap_or(1), &files.limits)?;
    let mut sources = Sources::default();
    let mut notes = Vec::new();
    let mut cameras = cameras(&mut files, &metadata, &frame, calibration, &mut sources)?;
    let names: Vec<String> = cameras.iter().map(|camera| camera.name.clone()).collect();
    let depth_folder = metadata.depth_folder.as_deref();
    let folders = layout::find(&files, &names, depth_folder, &mut sources, &mut notes)?;
    let images = images(&mut files, &cameras, &folders)?;
    let timing = timing::Timing::of(&metadata, &images, &files.limits)?;
    let numbering = timing.numbering;
    notes.extend(timing.notes.iter().cloned());
    let colors: Vec<&Images> = images.iter().map(|[color, _]| color).collect();
    let masks = masks::find(&mut files, &cameras, numbering.frame_count)?;
    let masks = masks.sort(
        &metadata.object_labels,
        &cameras,
        numbering,
        &colors,
        &mut notes,
        &mut sources,
    )?;
    let units = metadata.depth_units()?;
    let depth_cameras = metadata.depth_cameras(&cameras, &files.limits)?;
    let mut stored = Vec::with_capacity(cameras.len());
    let parts = images.into_iter().zip(masks).zip(units.into_iter().zip(depth_cameras));
    for (index, (([color, depth], masks), (unit, camera))) in parts.enumerate() {
        let [object, manipulator] = masks;
        stored.push(CameraFiles {
            size: metadata.size,
            span: color.span(numbering),
            color: color.names(numbering),
            turn: Default::default(),
            depth: Some(DepthNames {
                names: depth.names(numbering),
                unit,
                camera: camera.map(Arc::new),
            }),
            object,
            manipulator,
            tracks: Some(TrackFiles::Npz(folders[index].tracks.clone())),
        });
    }
    let chosen = probe::chosen_turn(metadata.image_orientation.as_deref(), MARKER)?;
    let mut stored = StoredFrames::new(files.fork(), numbering.frame_count, stored)?;
    let forms = probe::look(&mut stored, &cameras, chosen, &mut notes)?;
    let from = |of: &Folders| [of.color.clone(), of.depth.clone(), of.tracks.clone()];
    let from: Vec<[String; 3]> = folders.iter().map(from).collect();
    probe::tell(&mut sources, &cameras, &forms, &from);
    let mut ignored = Vec::new();
    let mut truth_tracks = truth(&mut files, numbering.frame_count, &mut ignored)?;
    frame.apply(&mut truth_tracks);
    let train_frame_count = split(&mut files, numbering.frame_count, &mut ignored)?;
    for (part, name) in [("clean tracks", "gt_track_3d.pkl"), ("split", "split.json")] {
        if files.has(name) {
            sources.take(part, None, name, "");
        }
    }
    let mesh = mesh(&mut files, &frame, &mut sources)?;
    // Where the calibration alone says where the cameras are, its world is that of the grippers.
    let is_placed = cameras.iter().any(|camera| !camera.poses.is_empty());
    let gives_poses =
        calibration.is_some_and(|given| given.cameras.iter().any(|camera| camera.pose.is_some()));
    let world =
        if gives_poses && !is_placed { Frame { rotation: IDENTITY, metres: 1.0 } } else { frame };
    let times_s = gripper::times_s(numbering.frame_count, timing.fps);
    let setting = gripper::Setting { times_s: &times_s, frame: &world, motion: None };
    let grippers = gripper::find(&mut files, &setting, &mut sources)?;
    notes.extend(crate::format::taken(&files.list("")));
    let mut recording = Recording {
        name: files.name.clone(),
        fps: timing.fps,
        frame_count: numbering.frame_count,
        train_frame_count,
        environment: Environment::Z_UP,
        source_to_world: frame.rotation,
        cameras: Vec::new(),
        mesh,
        truth_tracks,
        mass_kg: None,
        grippers,
        notes,
        sources,
        source: Arc::new(stored),
    };
    let has_split = files.has("split.json");
    timing.apply(&mut recording, &mut cameras, has_split, &files.limits)?;
    recording.cameras = cameras;
    Ok(recording)
}

fn cameras(
    files: &mut Files<'static>,
    metadata: &Metadata,
    frame: &Frame,
    calibration: Option<&Calibration>,
    sources: &mut Sources,
) -> Result<Vec<Camera>, Error> {
    let camera_count = metadata.camera_count;
    let serials = &metadata.serial_numbers;
    let names: Vec<String> = match calibration {
        Some(calibration) if serials.is_empty() && metadata.intrinsics.is_empty() => {
            calibration.cameras.iter().map(|camera| camera.name.clone()).collect()
        }
        _ => {
            let unnamed = (serials.len()..camera_count).map(|index| index.to_string());
            serials.iter().map(|serial| serial.name()).chain(unnamed).collect()
        }
    };
    let is_replaced =
        calibration.is_some_and(|given| given.cameras.iter().all(|camera| camera.pose.is_some()));
    let own = match poses::read(files, &names) {
        // The calibration has all that a damaged file could say.
        Err(_) if is_replaced => None,
        own => own?.filter(|own| !is_replaced || own.poses.len() == camera_count),
    };
    let counts = own.iter().map(|own| (own.at, own.poses.len()));
    let serials = (!serials.is_empty()).then_some(("`serial_numbers`", serials.len()));
    for (what, count) in counts.chain(serials) {
        if count != camera_count {
            return Err(Error::Lengths(format!(
                "{MARKER} has intrinsics of {camera_count} cameras, but {what} has {count}: one each"
            )));
        }
    }
    if !metadata.intrinsics.is_empty() {
        sources.take("lens", None, MARKER, "pinholes");
    }
    if let Some(Poses { at, form, .. }) = &own {
        sources.take("pose", None, *at, *form);
    }
    let calibrated = match calibration {
        Some(calibration) => calibration.of_cameras(names.iter().map(String::as_str))?,
        None => vec![None; camera_count],
    };
    let mut cameras = Vec::with_capacity(camera_count);
    for (index, (name, calibrated)) in names.into_iter().zip(calibrated).enumerate() {
        validity::check_size(&name, metadata.size, &files.limits)?;
        let given = calibrated.and_then(|camera| camera.intrinsics);
        let intrinsics = match (metadata.intrinsics.get(index), given) {
            (_, Some(given)) => given,
            (Some(matrix), None) => intrinsics(&name, matrix)?,
            (None, None) => {
                let fault = "neither metadata.json nor calibration.json has its intrinsics";
                return Err(Error::Camera { camera: name, fault: fault.to_owned() });
            }
        };
        let pose = own.as_ref().and_then(|own| own.poses.get(index));
        cameras.push(Camera {
            intrinsics,
            name,
            width: metadata.size[0],
            height: metadata.size[1],
            distortion: calibrated.and_then(|camera| camera.distortion).unwrap_or(Distortion::None),
            poses: pose.map(|pose| pose.turned(frame)).into_iter().collect(),
            times_s: Vec::new(),
            fps: None,
        });
    }
    Ok(cameras)
}

/// Colour and depth of each camera.
fn images(
    files: &mut Files<'_>,
    cameras: &[Camera],
    folders: &[Folders],
) -> Result<Vec<[Images; 2]>, Error> {
    let mut of = |camera: &Camera, folders: &Folders| -> Result<[Images; 2], Error> {
        let kinds = [
            ("colour images", &folders.color, numbering::COLOR),
            ("depth images", &folders.depth, numbering::DEPTH),
        ];
        let mut found = [Images::default(), Images::default()];
        for (images, (what, folder, extensions)) in found.iter_mut().zip(kinds) {
            *images = Images::in_folder(files, folder, extensions)?;
            if images.is_empty() {
                let wanted = format!("`{folder}/NUMBER.{}`", extensions.join("` or `."));
                return Err(numbering::missing(files, &camera.name, what, wanted, folder));
            }
        }
        Ok(found)
    };
    cameras.iter().zip(folders).map(|(camera, folders)| of(camera, folders)).collect()
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
fn mesh(
    files: &mut Files<'static>,
    frame: &Frame,
    sources: &mut Sources,
) -> Result<Option<MeshFile>, Error> {
    let aligned = Alignment { rotation: frame.rotation, scale: 1.0, translation: [0.0; 3] };
    for (at, to_world) in
        [("shape/matching/final_mesh.glb", Some(aligned)), ("shape/object.glb", None)]
    {
        if let Some(bytes) = files.find_within(at, MAX_MESH)? {
            sources.take(
                "mesh",
                None,
                at,
                if to_world.is_some() { "in the world" } else { "not aligned" },
            );
            let name = at.rsplit('/').next().unwrap_or(at).to_owned();
            return Ok(Some(MeshFile { name, bytes, to_world }));
        }
    }
    Ok(None)
}

#[cfg(test)]
mod tests;
