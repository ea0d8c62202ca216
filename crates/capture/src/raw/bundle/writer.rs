//! Writes a recording as a raw bundle, image by image.

use std::{
    io::{Seek, Write},
    path::Path,
};

use bendtwin_core::Point;
use zip::{CompressionMethod, ZipWriter, write::SimpleFileOptions};

use super::section::{CameraEntry, DepthEntry, MasksEntry, MeshEntry, Section, TracksEntry};
use crate::{
    Error,
    bundle::{Ground, MARKER, Manifest},
    npy,
    raw::{Frames, Recording, Region, Tracks, encode},
};

/// Options of writing a bundle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BundleOptions {
    /// Metres that one step of the 16-bit depth images means. Depth is rounded to it; what is
    /// beyond 65,535 steps counts as not measured.
    pub depth_unit_m: f64,
}

impl Default for BundleOptions {
    /// Millimetres, as most cameras give them.
    fn default() -> Self {
        Self { depth_unit_m: 0.001 }
    }
}

/// Writes a recording as a raw bundle ZIP at a path.
///
/// # Errors
/// If a frame cannot be read or the file cannot be written.
pub fn write_bundle(recording: &Recording, path: &Path) -> Result<(), Error> {
    let at = path.display().to_string();
    let file = std::fs::File::create(path).map_err(|e| failed(&at, e))?;
    let writer = std::io::BufWriter::new(file);
    let writer = write_bundle_to(recording, writer, &BundleOptions::default())?;
    writer.into_inner().map_err(|e| failed(&at, e.into_error()))?;
    Ok(())
}

/// Writes a recording as a raw bundle ZIP. Equal recordings give equal bytes.
///
/// # Errors
/// Those of [`write_bundle`].
pub fn write_bundle_to<W: Write + Seek>(
    recording: &Recording,
    writer: W,
    options: &BundleOptions,
) -> Result<W, Error> {
    let mut zip = Archive(ZipWriter::new(writer));
    let mut cameras = Vec::with_capacity(recording.cameras.len());
    for index in 0..recording.cameras.len() {
        cameras.push(write_camera(recording, index, &mut zip, options)?);
    }
    let mesh = match &recording.mesh {
        None => None,
        Some(mesh) => {
            let extension = mesh.name.rsplit_once('.').map_or("glb", |(_, e)| e);
            let file = format!("mesh.{extension}");
            zip.put(&file, &mesh.bytes, CompressionMethod::Deflated)?;
            Some(MeshEntry { file, to_world: mesh.to_world.map(Into::into) })
        }
    };
    let truth_tracks = if recording.truth_tracks.is_empty() || recording.frame_count == 0 {
        None
    } else {
        const NAME: &str = "truth_tracks.npy";
        let count = recording.truth_tracks.len() / recording.frame_count;
        let shape = [recording.frame_count, count, 3];
        zip.put(NAME, &points_npy(&shape, &recording.truth_tracks), CompressionMethod::Deflated)?;
        Some(NAME.to_owned())
    };
    let environment = &recording.environment;
    let manifest = Manifest {
        raw: Some(Section {
            frame_count: recording.frame_count,
            train_frame_count: recording.train_frame_count,
            cameras,
            mesh,
            truth_tracks,
            image_orientation: None,
        }),
        ..Manifest::in_world(
            &recording.name,
            recording.fps,
            environment.gravity,
            environment.ground.map(|g| Ground { normal: g.normal, offset: g.offset_m }),
            recording.source_to_world,
        )
    };
    let document = serde_json::to_vec_pretty(&manifest)
        .map_err(|e| Error::Document { at: MARKER.to_owned(), fault: e.to_string() })?;
    zip.put(MARKER, &document, CompressionMethod::Deflated)?;
    zip.0.finish().map_err(|e| failed("the archive's directory", e.into()))
}

fn write_camera<W: Write + Seek>(
    recording: &Recording,
    index: usize,
    zip: &mut Archive<W>,
    options: &BundleOptions,
) -> Result<CameraEntry, Error> {
    let Some(camera) = recording.cameras.get(index) else { return Err(Error::NoCamera(index)) };
    let mut frames = recording.source.frames(index)?;
    let folder = format!("cameras/{index}");
    let path = |name: &str| format!("{folder}/{name}");
    let image = |kind: &str, frame: usize| format!("{folder}/{kind}/{frame:06}.png");
    let pattern = |kind: &str| format!("{folder}/{kind}/{{frame:06}}.png");
    let mut masks = MasksEntry::default();
    for frame in 0..recording.frame_count {
        if let Some(color) = frames.color(frame)? {
            zip.put(&image("color", frame), &encode::color(&color)?, CompressionMethod::Stored)?;
        }
        if let Some(depth) = frames.depth(frame)? {
            let png = encode::depth(&depth, options.depth_unit_m)?;
            zip.put(&image("depth", frame), &png, CompressionMethod::Stored)?;
        }
        for (kind, region, patterns) in [
            ("object", Region::Object, &mut masks.object),
            ("manipulator", Region::Manipulator, &mut masks.manipulator),
        ] {
            if let Some(mask) = frames.mask(frame, region)? {
                zip.put(&image(kind, frame), &encode::mask(&mask)?, CompressionMethod::Stored)?;
                if patterns.is_empty() {
                    patterns.push(pattern(kind));
                }
            }
        }
    }
    let doubles = |values: &mut dyn Iterator<Item = f64>| -> Vec<u8> {
        values.flat_map(f64::to_le_bytes).collect()
    };
    let mut poses = None;
    if camera.poses.len() != 1 {
        let rows = camera.poses.iter().flat_map(|p| {
            let row = |i: usize| {
                let [a, b, c] = p.rotation[i];
                [a, b, c, p.translation[i]]
            };
            [row(0), row(1), row(2), [0.0, 0.0, 0.0, 1.0]]
        });
        let name = path("poses.npy");
        let array = npy::write("<f8", &[camera.poses.len(), 4, 4], &doubles(&mut rows.flatten()));
        zip.put(&name, &array, CompressionMethod::Deflated)?;
        poses = Some(name);
    }
    let mut times = None;
    if !camera.times_s.is_empty() {
        let name = path("times_s.npy");
        let values = doubles(&mut camera.times_s.iter().copied());
        let array = npy::write("<f8", &[camera.times_s.len()], &values);
        zip.put(&name, &array, CompressionMethod::Deflated)?;
        times = Some(name);
    }
    Ok(CameraEntry {
        name: camera.name.clone(),
        size: [camera.width, camera.height],
        intrinsics: camera.intrinsics.into(),
        distortion: camera.distortion.into(),
        pose: if poses.is_none() { camera.poses.first().map(Into::into) } else { None },
        poses,
        times,
        // Images are numbered by the recording's frames, and depth is aligned.
        fps: None,
        frame_offset: None,
        color: pattern("color"),
        depth: DepthEntry {
            files: pattern("depth"),
            unit_m: options.depth_unit_m,
            size: None,
            intrinsics: None,
            distortion: None,
            pose: None,
        },
        masks,
        tracks: write_tracks(frames.as_mut(), recording.frame_count, &folder, zip)?,
    })
}

fn write_tracks<W: Write + Seek>(
    frames: &mut dyn Frames,
    frame_count: usize,
    folder: &str,
    zip: &mut Archive<W>,
) -> Result<Option<TracksEntry>, Error> {
    let Some(Tracks { count, points, visible }) = frames.tracks()? else { return Ok(None) };
    let bytes: Vec<u8> = points.iter().flatten().flat_map(|x| x.to_le_bytes()).collect();
    let flags: Vec<u8> = visible.iter().map(|v| u8::from(*v)).collect();
    let entry = TracksEntry {
        points: format!("{folder}/tracks.npy"),
        visible: Some(format!("{folder}/tracks_visible.npy")),
    };
    let array = npy::write("<f4", &[frame_count, count, 2], &bytes);
    zip.put(&entry.points, &array, CompressionMethod::Deflated)?;
    if let Some(name) = &entry.visible {
        let array = npy::write("|b1", &[frame_count, count], &flags);
        zip.put(name, &array, CompressionMethod::Deflated)?;
    }
    Ok(Some(entry))
}

struct Archive<W: Write + Seek>(ZipWriter<W>);

impl<W: Write + Seek> Archive<W> {
    fn put(&mut self, name: &str, bytes: &[u8], method: CompressionMethod) -> Result<(), Error> {
        // No time: equal recordings give equal bytes.
        let options = SimpleFileOptions::default()
            .compression_method(method)
            .last_modified_time(zip::DateTime::default());
        self.0.start_file(name, options).map_err(|e| failed(name, e.into()))?;
        self.0.write_all(bytes).map_err(|e| failed(name, e))
    }
}

fn points_npy(shape: &[usize], points: &[Point]) -> Vec<u8> {
    let bytes: Vec<u8> = points.iter().flatten().flat_map(|x| x.to_le_bytes()).collect();
    npy::write("<f4", shape, &bytes)
}

fn failed(at: &str, source: std::io::Error) -> Error {
    Error::Io { at: at.to_owned(), source }
}
