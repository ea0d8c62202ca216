//! Reads a bundle.

use bendtwin_core::{
    Capture, Point, Sequence,
    capture::{HeldPoint, Object},
};

use super::{
    arrays,
    manifest::{MARKER, Manifest, SequenceEntry},
};
use crate::{Error, check::Note, files::Files, frame::Frame, npy};

/// Reads the bundle at the root of `files`.
pub(crate) fn read(files: &mut Files<'_>, notes: &mut Vec<Note>) -> Result<Capture, Error> {
    let manifest = Manifest::parse(&files.read_document(MARKER)?)?;
    if manifest.sequences.is_empty() && manifest.raw.is_some() {
        return Err(Error::RawOnly(files.name.clone()));
    }
    files.check_sequences(manifest.sequences.len())?;
    let frame = manifest.frame()?;
    let environment = manifest.environment(&frame)?;
    let source_to_world = manifest.source_to_world(&frame)?;

    let mut sequences = Vec::with_capacity(manifest.sequences.len());
    let mut point_count = None;
    for (index, entry) in manifest.sequences.iter().enumerate() {
        let sequence = read_sequence(files, &frame, entry, index, &mut point_count, notes)?;
        sequences.push(sequence);
    }
    let point_count = point_count.unwrap_or(0);
    let controls = sequences.first().map_or(0, Sequence::control_count);
    let mut object = read_object(files, &frame, point_count, controls)?;
    object.mass_kg = manifest.mass_kg;
    Ok(Capture {
        name: if manifest.name.is_empty() { files.name.clone() } else { manifest.name },
        fps: manifest.fps,
        environment,
        source_to_world,
        object,
        sequences,
        others: Vec::new(),
    })
}

fn read_sequence(
    files: &mut Files<'_>,
    frame: &Frame,
    entry: &SequenceEntry,
    index: usize,
    point_count: &mut Option<usize>,
    notes: &mut Vec<Note>,
) -> Result<Sequence, Error> {
    let folder = folder(&entry.folder)?;
    let path = |name: &str| format!("{folder}{name}");
    let name = if entry.name.is_empty() { format!("{index}") } else { entry.name.clone() };

    let at = path(arrays::POINTS);
    let bytes = files.read(&at)?;
    let array = npy::read(&at, &bytes)?;
    let &[frame_count, found, 3] = array.shape.as_slice() else {
        return Err(array.wrong_shape("[T, P, 3]"));
    };
    files.check_counts(frame_count, found)?;
    let expected = *point_count.get_or_insert(found);
    if found != expected {
        return Err(array.wrong_shape(&format!("[T, {expected}, 3] as in the first sequence")));
    }
    let mut points = array.points(&mut files.budget)?;
    drop(bytes);
    frame.apply(&mut points);

    let visible = match read_flags(files, &path(arrays::VISIBLE), frame_count, found)? {
        Some(visible) => visible,
        None => points.iter().map(|p| p.iter().all(|x| x.is_finite())).collect(),
    };
    let motion_valid = match read_flags(files, &path(arrays::MOTION), frame_count, found)? {
        Some(valid) => valid,
        None => seen_twice(&visible, found),
    };
    let mut read_tracks = |name: &str| -> Result<Vec<Point>, Error> {
        let at = path(name);
        let Some(bytes) = files.find(&at)? else { return Ok(Vec::new()) };
        let array = npy::read(&at, &bytes)?;
        match array.shape.as_slice() {
            &[frames, count, 3] if frames == frame_count => {
                files.check_controls(count)?;
                let mut tracks = array.points(&mut files.budget)?;
                frame.apply(&mut tracks);
                Ok(tracks)
            }
            _ => Err(array.wrong_shape(&format!(
                "[{frame_count}, n, 3]: one row per frame of {}",
                arrays::POINTS
            ))),
        }
    };
    let controls = read_tracks(arrays::CONTROLS)?;
    let truth_tracks = read_tracks(arrays::TRUTH)?;
    if truth_tracks.is_empty() {
        notes.push(Note::info(
            "OPTIONAL_MISSING",
            format!(
                "sequence `{name}` has no {}: the track metric is left out unless every point is a node",
                arrays::TRUTH
            ),
        ));
    }
    let split = entry.train_frame_count;
    let train_frame_count = usize::try_from(split)
        .ok()
        .filter(|n| *n <= frame_count)
        .ok_or_else(|| Error::SplitRange { sequence: name.clone(), split, frames: frame_count })?;
    Ok(Sequence {
        name,
        frame_count,
        train_frame_count,
        points,
        visible,
        motion_valid,
        controls,
        truth_tracks,
        start_frames: entry.start_frames,
    })
}

/// A folder inside the bundle, with its slash.
fn folder(name: &str) -> Result<String, Error> {
    let plain = name.split('/').all(|part| {
        !part.is_empty() && part != "." && part != ".." && !part.contains(['\\', ':', '\0'])
    });
    match name {
        "" => Ok(String::new()),
        _ if plain => Ok(format!("{name}/")),
        _ => Err(Error::Document {
            at: MARKER.to_owned(),
            fault: format!(
                "a sequence's folder is `{name}`: it must be a plain path inside the bundle"
            ),
        }),
    }
}

fn read_flags(
    files: &mut Files<'_>,
    at: &str,
    frames: usize,
    points: usize,
) -> Result<Option<Vec<bool>>, Error> {
    let Some(bytes) = files.find(at)? else { return Ok(None) };
    let array = npy::read(at, &bytes)?;
    if array.shape != [frames, points] {
        return Err(
            array.wrong_shape(&format!("[{frames}, {points}], [T, P] of {}", arrays::POINTS))
        );
    }
    array.bools(&mut files.budget).map(Some)
}

/// The default of motion validity: seen in this frame and in the previous one.
pub(super) fn seen_twice(visible: &[bool], point_count: usize) -> Vec<bool> {
    let before = std::iter::repeat_n(&false, point_count).chain(visible);
    visible.iter().zip(before).map(|(now, before)| *now && *before).collect()
}

fn read_object(
    files: &mut Files<'_>,
    frame: &Frame,
    point_count: usize,
    control_count: usize,
) -> Result<Object, Error> {
    let mut object = Object { point_count, ..Object::default() };
    if let Some(bytes) = files.find(arrays::COLORS)? {
        let array = npy::read(arrays::COLORS, &bytes)?;
        if array.shape != [point_count, 3] {
            return Err(array.wrong_shape(&format!("[{point_count}, 3], a colour per point")));
        }
        object.colors = array.colors(&mut files.budget)?;
    }
    for (name, into, rows) in [
        (arrays::SURFACE, &mut object.completed_surface, None),
        (arrays::INTERIOR, &mut object.interior, None),
        (arrays::REST, &mut object.rest_points, Some(point_count)),
    ] {
        let Some(bytes) = files.find(name)? else { continue };
        let array = npy::read(name, &bytes)?;
        match array.shape.as_slice() {
            &[n, 3] if rows.is_none_or(|rows| rows == n) => {
                files.check_counts(0, n)?;
                *into = array.points(&mut files.budget)?;
                frame.apply(into);
            }
            _ => {
                let needed = rows.map_or("[n, 3]".to_owned(), |rows| format!("[{rows}, 3]"));
                return Err(array.wrong_shape(&needed));
            }
        }
    }
    if let Some(bytes) = files.find(arrays::HANDS)? {
        let array = npy::read(arrays::HANDS, &bytes)?;
        if array.shape != [control_count] {
            return Err(array.wrong_shape(&format!("[{control_count}], a hand per control point")));
        }
        let hands = array.integers(&mut files.budget)?;
        let hand = |hand: i64| {
            index_in(hand, control_count).ok_or_else(|| Error::Document {
                at: arrays::HANDS.to_owned(),
                fault: format!(
                    "it names hand {hand} of {control_count} control points: count from 0"
                ),
            })
        };
        object.control_hands = hands.into_iter().map(hand).collect::<Result<_, _>>()?;
    }
    object.edges = read_pairs(files, arrays::EDGES, |index, [a, b]| {
        let edge = index_in(a, point_count).zip(index_in(b, point_count)).filter(|(a, b)| a != b);
        edge.map(Into::into).ok_or(Error::EdgeRange { index, a, b, points: point_count })
    })?;
    object.pins = read_pairs(files, arrays::PINS, |index, [point, control]| {
        let pin = index_in(point, point_count).zip(index_in(control, control_count));
        pin.map(|(point, control)| HeldPoint { point, control }).ok_or(Error::PinRange {
            index,
            point,
            control,
            points: point_count,
            controls: control_count,
        })
    })?;
    Ok(object)
}

fn read_pairs<T>(
    files: &mut Files<'_>,
    name: &str,
    make: impl Fn(usize, [i64; 2]) -> Result<T, Error>,
) -> Result<Vec<T>, Error> {
    let Some(bytes) = files.find(name)? else { return Ok(Vec::new()) };
    let array = npy::read(name, &bytes)?;
    if !matches!(array.shape.as_slice(), [_, 2]) {
        return Err(array.wrong_shape("[n, 2]"));
    }
    let numbers = array.integers(&mut files.budget)?;
    numbers.as_chunks::<2>().0.iter().enumerate().map(|(i, pair)| make(i, *pair)).collect()
}

/// An index that exists.
pub(crate) fn index_in(index: i64, count: usize) -> Option<u32> {
    u32::try_from(index).ok().filter(|i| (*i as usize) < count)
}
