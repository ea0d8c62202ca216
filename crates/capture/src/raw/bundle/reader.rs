//! Reads a raw bundle.

use std::sync::Arc;

use bendtwin_core::Finding;

use super::section::{
    AlignmentEntry, CameraEntry, DepthEntry, DistortionEntry, MeshEntry, Section,
};
use crate::{
    Error, Limits, Sources,
    bundle::{MARKER, Manifest},
    files::{Files, at_most, is_plain},
    frame::{self, Frame},
    npy,
    raw::{
        Alignment, Camera, Distortion, MeshFile, Pose, Recording, Source,
        clock::retimed::{Clock, Retimed},
        decode::{DepthUnit, unit_fault},
        gripper,
        numbering::{self, Images},
        realign::{DepthCamera, Lens},
        stored::{
            CameraFiles, DepthNames, MAX_MESH, MAX_PARTS, MaskFiles, Names, Place, StoredFrames,
            TrackFiles, probe,
        },
        validity,
    },
};

/// Reads the bundle at the root of `files`, but none of its frames.
pub(in crate::raw) fn read(mut files: Files<'static>) -> Result<Recording, Error> {
    let manifest = Manifest::parse(&files.read_document(MARKER)?)?;
    let frame = manifest.frame()?;
    let environment = manifest.environment(&frame)?;
    let source_to_world = manifest.source_to_world(&frame)?;
    let name = if manifest.name.is_empty() { files.name.clone() } else { manifest.name };
    let Some(section) = manifest.raw else {
        return Err(wrong(
            "it has no `raw` section: this bundle holds points and no images".into(),
        ));
    };
    let Section { frame_count, train_frame_count, cameras: entries, .. } = &section;
    let (frame_count, train_frame_count) = (*frame_count, *train_frame_count);
    validity::count(entries.len(), frame_count, &files.limits)?;
    let clocks = clocks(entries, manifest.fps)?;
    // Images of a camera that began early are numbered beyond the recording's frames.
    let early = clocks.iter().flatten().map(|clock| clock.offset.min(0).unsigned_abs());
    let image_count = frame_count.saturating_add(early.max().unwrap_or(0) as usize);
    validity::count(entries.len(), image_count, &files.limits)?;
    let mut cameras = Vec::with_capacity(entries.len());
    let mut stored = Vec::with_capacity(entries.len());
    for (index, entry) in entries.iter().enumerate() {
        let camera = camera(&mut files, entry, index, frame_count, manifest.fps, &frame)?;
        stored.push(camera_files(entry, &camera, &frame, &files.limits)?);
        cameras.push(camera);
    }
    let is_counted = clocks.is_none();
    let mut notes =
        find_images(&mut files, &cameras, entries, (image_count, is_counted), &mut stored)?;
    notes.extend(crate::format::taken(&files.list("")));
    let mut sources = Sources::default();
    let mut truth = Vec::new();
    if let Some(at) = &section.truth_tracks {
        sources.take("clean tracks", None, at, "");
        let bytes = files.read(plain(at)?)?;
        let array = npy::read(at, &bytes)?;
        match array.shape.as_slice() {
            &[frames, count, 3] if frames == frame_count => {
                at_most("ground-truth tracks", count, files.limits.points)?;
            }
            _ => return Err(array.wrong_shape(&format!("[{frame_count}, K, 3]"))),
        }
        truth = array.points(&mut files.budget)?;
        frame.apply(&mut truth);
    }
    let mesh = section.mesh.as_ref().map(|entry| {
        let form = if entry.to_world.is_some() { "in the world" } else { "not aligned" };
        sources.take("mesh", None, &entry.file, form);
        read_mesh(&mut files, entry, &frame)
    });
    let mesh = mesh.transpose()?;
    // Poses of grippers are in metres for any unit of the bundle's points.
    let turned = Frame { metres: 1.0, ..frame };
    let times_s = gripper::times_s(frame_count, manifest.fps);
    let setting = gripper::Setting { times_s: &times_s, frame: &turned, motion: None };
    let grippers = gripper::find(&mut files, &setting, &mut sources)?;
    let chosen = probe::chosen_turn(section.image_orientation.as_deref(), MARKER)?;
    let mut stored = StoredFrames::new(files.fork(), image_count, stored)?;
    let forms = probe::look(&mut stored, &cameras, chosen, &mut notes)?;
    let from = |entry: &CameraEntry| {
        let tracks = entry.tracks.as_ref().map(|tracks| tracks.points.clone()).unwrap_or_default();
        [entry.color.clone(), entry.depth.files.clone(), tracks]
    };
    let from: Vec<[String; 3]> = entries.iter().map(from).collect();
    probe::tell(&mut sources, &cameras, &forms, &from);
    sources.take("lens", None, MARKER, "");
    sources.take("pose", None, MARKER, "camera to world");
    let stored: Arc<dyn Source> = Arc::new(stored);
    let source = match clocks {
        None => stored,
        Some(clocks) => {
            let by_frame = clocks.iter().map(|clock| clock.by_frame(image_count, frame_count));
            Arc::new(Retimed::new(stored, by_frame.collect(), &files.limits)?)
        }
    };
    Ok(Recording {
        name,
        fps: manifest.fps,
        frame_count,
        train_frame_count,
        environment,
        source_to_world,
        cameras,
        mesh,
        truth_tracks: truth,
        mass_kg: manifest.mass_kg,
        notes,
        grippers,
        sources,
        source,
    })
}

/// The cameras' clocks, if their images are not numbered by the frames of the recording.
fn clocks(entries: &[CameraEntry], fps: f64) -> Result<Option<Vec<Clock>>, Error> {
    let rates: Vec<f64> = entries.iter().map(|entry| entry.fps.unwrap_or(fps)).collect();
    if let Some(rate) = rates.iter().find(|rate| **rate > fps) {
        return Err(wrong(format!(
            "a camera has {rate} frames per second and the recording `fps` {fps}: give the highest rate as the recording's"
        )));
    }
    let offsets: Vec<i64> = entries.iter().map(|entry| entry.frame_offset.unwrap_or(0)).collect();
    // The recording's rate counts as one of them.
    let all =
        Clock::of(&[rates.as_slice(), &[fps]].concat(), &[offsets.as_slice(), &[0]].concat())?;
    Ok(all.map(|(_, mut clocks)| {
        clocks.pop();
        clocks
    }))
}

fn camera(
    files: &mut Files<'static>,
    entry: &CameraEntry,
    index: usize,
    frame_count: usize,
    fps: f64,
    frame: &Frame,
) -> Result<Camera, Error> {
    let name = if entry.name.is_empty() { index.to_string() } else { entry.name.clone() };
    let [width, height] = entry.size;
    let poses = match (&entry.pose, &entry.poses) {
        (Some(pose), None) => vec![Pose::from(pose)],
        (None, Some(at)) => {
            let bytes = files.read(plain(at)?)?;
            let array = npy::read(at, &bytes)?;
            let rows = match array.shape.as_slice() {
                &[frames, rows @ (3 | 4), 4] if frames == frame_count => rows,
                _ => return Err(array.wrong_shape(&format!("[{frame_count}, 4, 4]"))),
            };
            let flat = array.doubles(&mut files.budget)?;
            let matrices = flat.as_chunks::<4>().0.chunks_exact(rows);
            matrices.map(|m| Pose::from_rows(&name, m)).collect::<Result<_, _>>()?
        }
        _ => {
            return Err(wrong(format!(
                "camera `{name}` must have either `pose`, if it stands, or `poses`"
            )));
        }
    };
    let times_s = match &entry.times {
        None => Vec::new(),
        Some(at) => {
            let bytes = files.read(plain(at)?)?;
            let array = npy::read(at, &bytes)?;
            if array.shape != [frame_count] {
                return Err(array.wrong_shape(&format!("[{frame_count}]")));
            }
            array.doubles(&mut files.budget)?
        }
    };
    let distortion = entry.distortion.read().ok_or_else(|| {
        wrong(format!("camera `{name}`: brown_conrady has 4, 5 or 8 coefficients"))
    })?;
    Ok(Camera {
        name,
        width,
        height,
        intrinsics: (&entry.intrinsics).into(),
        distortion,
        poses: poses.iter().map(|pose| pose.turned(frame)).collect(),
        times_s,
        fps: entry.fps.filter(|own| *own != fps),
    })
}

fn camera_files(
    entry: &CameraEntry,
    camera: &Camera,
    frame: &Frame,
    limits: &Limits,
) -> Result<CameraFiles, Error> {
    at_most("masks of a camera", entry.masks.object.len(), MAX_PARTS)?;
    at_most("masks of a camera", entry.masks.manipulator.len(), MAX_PARTS)?;
    let unit_m = entry.depth.unit_m;
    let unit = DepthUnit::declared(unit_m).ok_or_else(|| wrong(unit_fault("unit_m", unit_m)))?;
    let all = |patterns: &[String]| {
        patterns.iter().map(|p| names(p).map(MaskFiles::of)).collect::<Result<_, _>>()
    };
    let tracks = match &entry.tracks {
        None => None,
        Some(tracks) => Some(TrackFiles::Npy {
            points: plain(&tracks.points)?.to_owned(),
            visible: tracks.visible.as_deref().map(plain).transpose()?.map(str::to_owned),
        }),
    };
    Ok(CameraFiles {
        size: entry.size,
        color: names(&entry.color)?,
        turn: Default::default(),
        depth: Some(DepthNames {
            names: names(&entry.depth.files)?,
            unit,
            camera: depth_camera(&entry.depth, camera, frame, limits)?.map(Arc::new),
        }),
        object: all(&entry.masks.object)?,
        manipulator: all(&entry.masks.manipulator)?,
        tracks,
        span: None,
    })
}

/// The camera that measured depth, if it is not the one of colour.
fn depth_camera(
    entry: &DepthEntry,
    camera: &Camera,
    frame: &Frame,
    limits: &Limits,
) -> Result<Option<DepthCamera>, Error> {
    let Some(intrinsics) = &entry.intrinsics else {
        if entry.pose.is_some() || entry.distortion.is_some() {
            return Err(wrong(
                "depth has `pose` or `distortion` and no `intrinsics`: give these, if it is not aligned to colour \
                 (docs/use/cameras.md#depth)"
                    .into(),
            ));
        }
        return Ok(None);
    };
    let distortion =
        entry.distortion.as_ref().map_or(Some(Distortion::None), DistortionEntry::read);
    let distortion = distortion.ok_or_else(|| {
        wrong(format!("camera `{}`: brown_conrady has 4, 5 or 8 coefficients", camera.name))
    })?;
    let size = entry.size.unwrap_or([camera.width, camera.height]);
    let mut pose = entry.pose.as_ref().map_or(Pose::IDENTITY, Pose::from);
    pose.translation = pose.translation.map(|x| x * frame.metres_per_unit());
    let lens = Lens { size, intrinsics: intrinsics.into(), distortion };
    validity::depth_camera(camera, lens, &pose, limits).map(Some)
}

/// Finds the images of all patterns, so that their numbers may begin anywhere and have any number
/// of zeros before them. With the number of images, and whether that is the number of frames.
fn find_images(
    files: &mut Files<'static>,
    cameras: &[Camera],
    entries: &[CameraEntry],
    (count, is_counted): (usize, bool),
    stored: &mut [CameraFiles],
) -> Result<Vec<Finding>, Error> {
    let mut found = Vec::with_capacity(stored.len());
    for ((of, camera), entry) in stored.iter().zip(cameras).zip(entries) {
        let depth = of.depth.as_ref().map(|depth| find(files, &depth.names)).transpose()?.flatten();
        let images = [find(files, &of.color)?, depth];
        let patterns = [("colour images", &entry.color), ("depth images", &entry.depth.files)];
        for (images, (what, pattern)) in images.iter().zip(patterns) {
            if images.as_ref().is_some_and(Images::is_empty) {
                let folder = pattern.rsplit_once('/').map_or("", |(folder, _)| folder);
                let wanted = format!("`{pattern}`");
                return Err(numbering::missing(files, &camera.name, what, wanted, folder));
            }
        }
        found.push(images);
    }
    let all: Vec<&Images> = found.iter().flatten().flatten().collect();
    let declared = format!("`frame_count` of {MARKER}");
    if is_counted {
        numbering::expect_end(&all, &declared, count)?;
    }
    let numbering = numbering::align(&all, Some((&declared, count)), &files.limits)?;
    let mut notes = Vec::new();
    for (index, (of, [color, depth])) in stored.iter_mut().zip(found).enumerate() {
        for part in of.object.iter_mut().chain(&mut of.manipulator) {
            let Place::Each(names) = &mut part.place else { continue };
            if let Some(images) = find(files, names)? {
                notes.extend(images.note_missing(files, index));
                if let (true, Some(color)) = (numbering.first > 0, &color) {
                    images.expect_within(numbering, color)?;
                }
                *names = images.names(numbering);
            }
        }
        if let Some(images) = color {
            of.color = images.names(numbering);
        }
        if let (Some(images), Some(of)) = (depth, &mut of.depth) {
            of.names = images.names(numbering);
        }
    }
    notes.extend(numbering.note());
    Ok(notes)
}

/// The images that a pattern names.
fn find(files: &mut Files<'static>, names: &Names) -> Result<Option<Images>, Error> {
    match names {
        Names::Numbered { before, after, .. } => Images::of_pattern(files, before, after),
        Names::Listed(_) | Names::Found(_) => Ok(None),
    }
}

/// A pattern such as `left/color/{frame:06}.png`.
fn names(pattern: &str) -> Result<Names, Error> {
    plain(pattern)?;
    let parts = pattern.split_once("{frame").and_then(|(before, rest)| {
        let (format, after) = rest.split_once('}')?;
        let digits = match format.strip_prefix(":0") {
            Some(digits) => digits.parse().ok().filter(|n| (1..=9).contains(n))?,
            None if format.is_empty() => 1,
            None => return None,
        };
        let rest_is_plain = !before.contains(['{', '}']) && !after.contains(['{', '}']);
        rest_is_plain.then(|| Names::Numbered {
            before: before.into(),
            digits,
            after: after.into(),
        })
    });
    parts.ok_or_else(|| {
        wrong(format!("the pattern `{pattern}` must have {{frame}} or {{frame:06}} in it, once"))
    })
}

fn read_mesh(
    files: &mut Files<'static>,
    entry: &MeshEntry,
    frame: &Frame,
) -> Result<MeshFile, Error> {
    let at = plain(&entry.file)?;
    let bytes =
        files.find_within(at, MAX_MESH)?.ok_or_else(|| Error::MissingFile(at.to_owned()))?;
    let to_world = entry.to_world.as_ref().map(|entry| alignment(entry, frame)).transpose()?;
    let name = at.rsplit('/').next().unwrap_or(at).to_owned();
    Ok(MeshFile { name, bytes, to_world })
}

fn alignment(entry: &AlignmentEntry, frame: &Frame) -> Result<Alignment, Error> {
    let sound = frame::is_rotation(&entry.rotation)
        && entry.scale.is_finite()
        && entry.scale > 0.0
        && entry.translation.iter().all(|x| x.is_finite());
    if !sound {
        return Err(wrong(
            "the mesh's `to_world` must have a rotation (orthonormal rows, determinant 1), a scale above 0 and a \
             finite translation"
                .into(),
        ));
    }
    Ok(Alignment {
        rotation: frame::compose(&frame.rotation, &entry.rotation),
        scale: entry.scale * frame.metres,
        translation: frame.turn(entry.translation).map(|x| x * frame.metres),
    })
}

fn plain(name: &str) -> Result<&str, Error> {
    if name.is_empty() || !is_plain(name) {
        return Err(wrong(format!("`{name}` is no plain path inside the bundle")));
    }
    Ok(name)
}

fn wrong(fault: String) -> Error {
    Error::Document { at: MARKER.to_owned(), fault }
}
