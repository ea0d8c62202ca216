//! Motion capture of cables: an .npz of trajectories with its .json beside it,
//! in the layout of the DEFORM and DEFT data. Vertices become tracked points
//! with known edges; vertices that robots hold become pins on control points
//! that follow the recorded trajectories. The files of motion-capture programs are in [`markers`].

mod markers;

use std::{fs::File, io::Read, path::Path};

use bendtwin_core::{
    Capture, Environment, Plane, Point, Sequence,
    capture::{HeldPoint, Object},
};
use serde::Deserialize;

use crate::{
    Error, Limits,
    bundle::index_in,
    check::structure::validate,
    files::{Contents, Files, MAX_DOCUMENT},
    frame::Frame,
    npy,
    phystwin::json,
};

pub use markers::described;
pub(crate) use markers::{
    files_of as files_of_markers, has as has_markers, is_file as is_markers,
    read_file as read_markers, read_in as read_markers_in, read_packed as read_packed_markers,
};

/// Lowest height that both datasets record [m]: their floor, to which DEFORM clips.
const FLOOR_M: f32 = 0.002_001;

/// The part of the description that is read; the rest is for people.
#[derive(Deserialize)]
struct Description {
    fps: f64,
    units: String,
    up_axis: String,
    #[serde(default)]
    object: String,
    gravity: Point,
    /// Remark in words on clipping of the recording.
    #[serde(default)]
    metric: serde_json::Value,
    #[serde(default)]
    sequences: serde_json::Value,
}

/// Reads an .npz and the .json that describes it.
///
/// # Errors
/// If either is missing, damaged, or not in the layout of `docs/formats/capture.md`.
pub fn read_npz(npz: &Path, description: &Path, limits: &Limits) -> Result<Capture, Error> {
    let mut files = Files::open(npz, limits)?;
    let name = description.display().to_string();
    let io = |source: std::io::Error| match source.kind() {
        std::io::ErrorKind::NotFound => Error::MissingFile(name.clone()),
        _ => Error::Io { at: name.clone(), source },
    };
    let mut bytes = Vec::new();
    let file = File::open(description).map_err(io)?;
    file.take(MAX_DOCUMENT).read_to_end(&mut bytes).map_err(io)?;
    let description: Description = json(&bytes, &name)?;
    let capture = read(&mut files, &description)?;
    validate(&capture)?;
    Ok(capture)
}

/// The .npz of a folder that has one, with the .json that describes it beside it.
pub(crate) fn packed(contents: &Contents) -> Option<&str> {
    let mut arrays = contents.files.iter().filter(|name| stem(name).is_some());
    let (Some(npz), None) = (arrays.next(), arrays.next()) else { return None };
    contents.has(&description_of(npz)).then_some(npz)
}

/// Reads an .npz and its .json in a folder or an archive.
pub(crate) fn read_packed(files: &mut Files<'_>, npz: &str) -> Result<Capture, Error> {
    let name = description_of(npz);
    let description: Description = json(&files.read_document(&name)?, &name)?;
    let bytes = files.read(npz)?;
    let mut arrays = Files::from_bytes(stem(npz).unwrap_or(npz), &bytes, &files.limits)?;
    // Unpacked bytes count beside the bytes read.
    std::mem::swap(&mut arrays.budget, &mut files.budget);
    let capture = read(&mut arrays, &description);
    std::mem::swap(&mut arrays.budget, &mut files.budget);
    capture
}

/// The name of an .npz without its extension; none of another file.
fn stem(name: &str) -> Option<&str> {
    let (stem, extension) = name.rsplit_once('.')?;
    (!stem.is_empty() && extension.eq_ignore_ascii_case("npz")).then_some(stem)
}

fn description_of(npz: &str) -> String {
    format!("{}.json", stem(npz).unwrap_or(npz))
}

fn read(files: &mut Files<'_>, description: &Description) -> Result<Capture, Error> {
    let frame = Frame::of_up_axis(&description.up_axis)?;
    let frame = Frame { metres: Frame::metres_per(&description.units)?, ..frame };
    let clipped = description.metric.to_string().contains("clipped to");

    let edges = read_integers(files, "edges", Some(2))?;
    let held = read_integers(files, "controlled", None)?;
    let mut object = Object::default();
    let mut sequences = Vec::new();
    for (role, required) in [("train", true), ("eval", false)] {
        let at = format!("{role}.npy");
        let Some(bytes) = files.find(&at)? else {
            if required {
                return Err(Error::MissingArray { at: files.name.clone(), array: role.to_owned() });
            }
            continue;
        };
        let array = npy::read(&at, &bytes)?;
        let &[count, frames, vertices, 3] = array.shape.as_slice() else {
            return Err(array.wrong_shape("[S, T, V, 3]"));
        };
        files.check_sequences(count)?;
        files.check_counts(frames, vertices)?;
        files.check_controls(held.len())?;
        if object.point_count == 0 {
            object.point_count = vertices;
        } else if vertices != object.point_count {
            return Err(array.wrong_shape(&format!("[S, T, {}, 3] as train", object.point_count)));
        }
        let held = held_points(&held, vertices)?;
        let mut points = array.points(&mut files.budget)?;
        drop(bytes);
        frame.apply(&mut points);
        if clipped {
            // Not `max`: a missing z must stay missing.
            points.iter_mut().filter(|p| p[2] < FLOOR_M).for_each(|p| p[2] = FLOOR_M);
        }
        // Flags and controls are copies beside the points.
        let cells = frames.saturating_mul(vertices);
        let extra = (count * cells * 14 + count * frames * held.len() * 12) as u64;
        files.budget.take(extra, "the sequences")?;
        for index in 0..count {
            let points = points[index * cells..(index + 1) * cells].to_vec();
            let train = if role == "train" { frames } else { 0 };
            let name = format!("{role} {}", title(&description.sequences, role, index));
            sequences.push(sequence(name, points, &held, vertices, train));
        }
        object.pins = held
            .iter()
            .enumerate()
            .map(|(control, point)| HeldPoint { point: *point, control: control as u32 })
            .collect();
    }
    for (index, pair) in edges.as_chunks::<2>().0.iter().enumerate() {
        let [a, b] = *pair;
        let points = object.point_count;
        let edge = index_in(a, points).zip(index_in(b, points)).filter(|(a, b)| a != b);
        object.edges.push(edge.ok_or(Error::EdgeRange { index, a, b, points })?.into());
    }
    object.rest_points = rest_points(files, object.point_count)?;
    frame.apply(&mut object.rest_points);

    let floor = Plane { normal: [0.0, 0.0, 1.0], offset_m: FLOOR_M };
    Ok(Capture {
        name: if description.object.is_empty() {
            files.name.clone()
        } else {
            description.object.clone()
        },
        fps: description.fps,
        environment: Environment {
            gravity: frame.turn(description.gravity),
            ground: clipped.then_some(floor),
        },
        source_to_world: frame.rotation,
        object,
        sequences,
        others: Vec::new(),
    })
}

/// A sequence whose held points move as recorded; its state starts from two frames.
fn sequence(
    name: String,
    points: Vec<Point>,
    held: &[u32],
    vertices: usize,
    train: usize,
) -> Sequence {
    let frame_count = points.len() / vertices.max(1);
    let controls = points
        .chunks_exact(vertices.max(1))
        .flat_map(|row| held.iter().map(|h| row[*h as usize]))
        .collect();
    let cells = points.len();
    let mut motion_valid = vec![true; cells];
    motion_valid.iter_mut().take(vertices).for_each(|m| *m = false);
    Sequence {
        name,
        frame_count,
        train_frame_count: train,
        visible: vec![true; cells],
        motion_valid,
        points,
        controls,
        truth_tracks: Vec::new(),
        start_frames: 2.min(frame_count).max(1),
    }
}

fn held_points(held: &[i64], vertices: usize) -> Result<Vec<u32>, Error> {
    let point = |(index, &point): (usize, &i64)| {
        let controls = held.len();
        let out =
            Error::PinRange { index, point, control: index as i64, points: vertices, controls };
        index_in(point, vertices).ok_or(out)
    };
    held.iter().enumerate().map(point).collect()
}

fn read_integers(
    files: &mut Files<'_>,
    array: &str,
    width: Option<usize>,
) -> Result<Vec<i64>, Error> {
    let at = format!("{array}.npy");
    let missing = || Error::MissingArray { at: files.name.clone(), array: array.to_owned() };
    if !files.has(&at) {
        return Err(missing());
    }
    let bytes = files.read(&at)?;
    let found = npy::read(&at, &bytes)?;
    match (found.shape.as_slice(), width) {
        ([_], None) => found.integers(&mut files.budget),
        ([_, w], Some(width)) if *w == width => found.integers(&mut files.budget),
        (_, None) => Err(found.wrong_shape("[n]")),
        (_, Some(width)) => Err(found.wrong_shape(&format!("[n, {width}]"))),
    }
}

/// The undeformed shape: positions or, where only lengths and angles of the
/// source are right, the `_raw` positions, which serve the same purpose.
fn rest_points(files: &mut Files<'_>, vertices: usize) -> Result<Vec<Point>, Error> {
    for at in ["rest_vertices.npy", "rest_vertices_raw.npy"] {
        let Some(bytes) = files.find(at)? else { continue };
        let array = npy::read(at, &bytes)?;
        if array.shape != [vertices, 3] {
            return Err(array.wrong_shape(&format!("[{vertices}, 3]")));
        }
        return array.points(&mut files.budget);
    }
    Ok(Vec::new())
}

fn title(names: &serde_json::Value, role: &str, index: usize) -> String {
    let given = names.get(role).and_then(|list| list.get(index)).and_then(|name| name.as_str());
    given.map_or_else(|| index.to_string(), str::to_owned)
}

#[cfg(test)]
mod tests;
