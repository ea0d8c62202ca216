//! nerfstudio's `transforms.json`: one entry for every image of every camera. Its cameras look
//! along -z with y up (OpenGL), the centre of its first pixel is (0.5, 0.5), its world has z up.

mod document;
mod grouping;
mod writer;

use std::sync::Arc;

use bendtwin_core::{Environment, Finding, Plane};

pub use self::writer::write_nerfstudio;
use self::{
    document::{Document, FrameEntry, Lens},
    grouping::{Group, group},
};
use super::{
    Camera, Pose, Recording,
    decode::{DepthUnit, unit_fault},
    gripper, numbering,
    stored::{CameraFiles, DepthNames, MaskFiles, Names, StoredFrames, probe},
    validity,
};
use crate::{
    Error, Sources,
    files::{Files, is_plain},
    frame::Frame,
    phystwin::json,
};

pub(crate) const MARKER: &str = "transforms.json";

/// nerfstudio's default: depth images in millimetres.
const DEPTH_UNIT_M: f64 = 0.001;

/// Reads the recording at the root of `files`, but none of its frames.
pub(super) fn read(mut files: Files<'static>) -> Result<Recording, Error> {
    let mut document: Document = json(&files.read_document(MARKER)?, MARKER)?;
    document.settle_paths();
    let up = document.up_axis.as_deref().unwrap_or("+z");
    let frame = Frame::of_up_axis(up)?;
    let unit_m = document.depth_unit_scale_factor.unwrap_or(DEPTH_UNIT_M);
    let scale = document.applied_scale.unwrap_or(1.0);
    if !(scale.is_finite() && scale > 0.0) {
        return Err(wrong(format!("`applied_scale` is {scale}: it must be above 0")));
    }
    let unit = DepthUnit::declared(unit_m)
        .ok_or_else(|| wrong(unit_fault("depth_unit_scale_factor", unit_m)))?;
    let groups = group(&document, &files.limits)?;
    let frame_count = groups.frame_count;
    validity::count(groups.cameras.len(), frame_count, &files.limits)?;
    let mut cameras = Vec::with_capacity(groups.cameras.len());
    let mut stored = Vec::with_capacity(groups.cameras.len());
    for group in &groups.cameras {
        let (camera, of) = camera(&document, group, scale, &frame)?;
        validity::check_size(&camera.name, of.size, &files.limits)?;
        let depth = of.depth.as_ref().map(|depth| &depth.names);
        for (what, names) in [("colour images", Some(&of.color)), ("depth images", depth)] {
            expect_some(&files, &camera.name, what, names)?;
        }
        stored
            .push(CameraFiles { depth: of.depth.map(|depth| DepthNames { unit, ..depth }), ..of });
        cameras.push(camera);
    }
    let train = document.train_frame_count.unwrap_or((frame_count as f64 * 0.7).round() as usize);
    let ground = document.ground.as_ref().map(|ground| {
        let length = ground.normal.iter().map(|x| x * x).sum::<f32>().sqrt();
        let sound = length.is_finite() && length > 1e-6 && ground.offset.is_finite();
        sound
            .then(|| Plane {
                normal: frame.turn(ground.normal).map(|x| x / length),
                offset_m: ground.offset / length,
            })
            .ok_or_else(|| wrong("`ground` has no direction: give a unit normal".into()))
    });
    let mut notes: Vec<Finding> = crate::format::taken(&files.list("")).into_iter().collect();
    let chosen = probe::chosen_turn(document.image_orientation.as_deref(), MARKER)?;
    let mut stored = StoredFrames::new(files.fork(), frame_count, stored)?;
    let forms = probe::look(&mut stored, &cameras, chosen, &mut notes)?;
    let mut sources = Sources::default();
    let from = |of: &CameraFiles| {
        let depth = of.depth.as_ref().map(|depth| folder_of(&depth.names)).unwrap_or_default();
        [folder_of(&of.color), depth, String::new()]
    };
    let from: Vec<[String; 3]> = stored.cameras.iter().map(from).collect();
    probe::tell(&mut sources, &cameras, &forms, &from);
    sources.take("lens", None, MARKER, "");
    sources.take("pose", None, MARKER, "camera to world, OpenGL's axes");
    sources.take("frames", None, MARKER, groups.timed);
    let times_s = gripper::times_s(frame_count, groups.fps);
    let setting = gripper::Setting { times_s: &times_s, frame: &frame, motion: None };
    let grippers = gripper::find(&mut files, &setting, &mut sources)?;
    Ok(Recording {
        name: files.name.clone(),
        fps: groups.fps,
        frame_count,
        train_frame_count: train,
        environment: Environment { ground: ground.transpose()?, ..Environment::Z_UP },
        source_to_world: frame.rotation,
        cameras,
        mesh: None,
        truth_tracks: Vec::new(),
        mass_kg: None,
        grippers,
        notes,
        sources,
        source: Arc::new(stored),
    })
}

/// The folder of a list of images.
fn folder_of(names: &Names) -> String {
    let Names::Listed(names) = names else { return String::new() };
    let first = names.iter().flatten().next().map_or("", String::as_str);
    first.rsplit_once('/').map_or(first, |(folder, _)| folder).to_owned()
}

/// Refuses a list of images if all are missing.
fn expect_some(
    files: &Files<'_>,
    camera: &str,
    what: &'static str,
    names: Option<&Names>,
) -> Result<(), Error> {
    let Some(Names::Listed(names)) = names else { return Ok(()) };
    let mut names = names.iter().flatten();
    match names.next() {
        Some(first) if !files.has(first) && !names.any(|name| files.has(name)) => {
            let folder = first.rsplit_once('/').map_or("", |(folder, _)| folder);
            Err(numbering::missing(files, camera, what, format!("`{first}`"), folder))
        }
        _ => Ok(()),
    }
}

/// A camera and where its frames lie; the depth's unit is still to be filled in.
fn camera(
    document: &Document,
    group: &Group<'_>,
    scale: f64,
    frame: &Frame,
) -> Result<(Camera, CameraFiles), Error> {
    let fail =
        |fault: &str| Err(Error::Camera { camera: group.name.clone(), fault: fault.to_owned() });
    let mut lens: Option<Lens> = None;
    let mut poses: Vec<Option<Pose>> = Vec::with_capacity(group.frames.len());
    for entry in &group.frames {
        let Some(entry) = entry else {
            poses.push(None);
            continue;
        };
        let of = entry.lens.or(&document.lens);
        if lens.as_ref().is_some_and(|lens| *lens != of) {
            return fail(
                "its frames have different intrinsics: one camera has one lens; separate cameras by `camera_label`",
            );
        }
        lens = Some(of);
        let mut pose = Pose::from_rows(&group.name, &entry.transform_matrix)?;
        // From OpenGL's axes to OpenCV's: y and z of the camera change sign.
        for row in &mut pose.rotation {
            *row = [row[0], -row[1], -row[2]];
        }
        pose.translation = pose.translation.map(|x| x / scale);
        poses.push(Some(pose.turned(frame)));
    }
    let Some(lens) = lens else { return fail("it has no frame") };
    let [width, height] = lens.size(&group.name)?;
    let list = |name: fn(&FrameEntry) -> Option<&String>| -> Result<Names, Error> {
        let names = group.frames.iter().map(|entry| {
            let Some(name) = entry.and_then(name) else { return Ok(None) };
            let name = name.trim_start_matches("./");
            if name.is_empty() || !is_plain(name) {
                return Err(wrong(format!("`{name}` is no plain path beside `{MARKER}`")));
            }
            Ok(Some(name.to_owned()))
        });
        names.collect::<Result<_, _>>().map(Names::Listed)
    };
    let depth = list(|e| e.depth_file_path.as_ref())?;
    if matches!(&depth, Names::Listed(names) if names.iter().all(Option::is_none)) {
        return fail(
            "none of its frames has `depth_file_path`: BendTwin needs depth beside colour, and does not estimate it",
        );
    }
    let some = |names: Names| match &names {
        Names::Listed(list) if list.iter().all(Option::is_none) => Vec::new(),
        _ => vec![MaskFiles::of(names)],
    };
    let camera = Camera {
        name: group.name.clone(),
        width,
        height,
        intrinsics: lens.intrinsics(&group.name)?,
        distortion: lens.distortion(&group.name)?,
        poses: filled(&poses),
        times_s: group.times_s.clone(),
        fps: None,
    };
    let files = CameraFiles {
        size: [width, height],
        color: list(|e| Some(&e.file_path))?,
        turn: Default::default(),
        depth: Some(DepthNames::aligned(depth, DepthUnit::Declared(1.0))),
        object: some(list(|e| e.mask_path.as_ref())?),
        manipulator: some(list(|e| e.manipulator_mask_path.as_ref())?),
        tracks: None,
        span: None,
    };
    Ok((camera, files))
}

/// A pose for every frame: one for all if the camera stands, and the latest known where a frame is
/// missing.
fn filled(poses: &[Option<Pose>]) -> Vec<Pose> {
    let mut known = poses.iter().flatten();
    let Some(&first) = known.next() else { return Vec::new() };
    if known.all(|pose| *pose == first) {
        return vec![first];
    }
    let mut last = first;
    let at = |pose: &Option<Pose>| {
        last = pose.unwrap_or(last);
        last
    };
    poses.iter().map(at).collect()
}

fn wrong(fault: String) -> Error {
    Error::Document { at: MARKER.to_owned(), fault }
}

#[cfg(test)]
mod tests;
