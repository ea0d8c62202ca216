//! A PhysTwin case as its users have it: `final_data.pkl`, `metadata.json`,
//! `split.json`, `gt_track_3d.pkl`. Its world has z pointing down and the ground
//! at z = 0. Raw colour, depth, masks and calibration are not needed and not opened. [`results`] are
//! those of its fits.

pub mod results;

use bendtwin_core::{Capture, Environment, Point, Sequence, capture::Object};
use serde::Deserialize;

use crate::{
    Error,
    array::Array,
    check::Note,
    files::{Files, at_most},
    frame::Frame,
    pickle,
};

pub(crate) const MARKER: &str = "final_data.pkl";

/// Share of the frames that PhysTwin fits to where nothing else is said.
const TRAIN_SHARE: f64 = 0.7;

#[derive(Deserialize)]
struct Metadata {
    fps: f64,
}

#[derive(Deserialize)]
struct Split {
    train: [i64; 2],
    test: Option<[i64; 2]>,
}

/// Reads the case at the root of `files`.
pub(crate) fn read(files: &mut Files<'_>, notes: &mut Vec<Note>) -> Result<Capture, Error> {
    let metadata: Metadata = json(&files.read_document("metadata.json")?, "metadata.json")?;
    let bytes = files.read(MARKER)?;
    let data = pickle::read(MARKER, &bytes, &files.limits, &mut files.budget)?;
    let missing =
        |array: &str| Error::MissingArray { at: MARKER.to_owned(), array: array.to_owned() };

    let points = data.entry("object_points")?.ok_or_else(|| missing("object_points"))?;
    let &[frame_count, point_count, 3] = points.shape.as_slice() else {
        return Err(points.wrong_shape("[T, P, 3]"));
    };
    files.check_counts(frame_count, point_count)?;
    let grid = [frame_count, point_count];
    let visible =
        data.entry("object_visibilities")?.ok_or_else(|| missing("object_visibilities"))?;
    let valid =
        data.entry("object_motions_valid")?.ok_or_else(|| missing("object_motions_valid"))?;
    expect(&visible, &grid, "[T, P] as object_points")?;
    // PhysTwin's own data drops the last frame, which has no motion to a next one.
    let short = [frame_count.saturating_sub(1), point_count];
    if valid.shape != short {
        expect(&valid, &grid, "[T, P] or [T-1, P] as object_points")?;
    }
    let controls = data.entry("controller_points")?.ok_or_else(|| missing("controller_points"))?;
    let &[control_frames, control_count, 3] = controls.shape.as_slice() else {
        return Err(controls.wrong_shape("[T, C, 3]"));
    };
    if control_frames != frame_count {
        return Err(controls
            .wrong_shape(&format!("[{frame_count}, C, 3]: one row per frame of object_points")));
    }
    files.check_controls(control_count)?;
    let colors = data.entry("object_colors")?;
    if let Some(colors) = &colors {
        expect(colors, &[frame_count, point_count, 3], "[T, P, 3] as object_points")?;
    }

    let budget = &mut files.budget;
    let mut sequence = Sequence {
        name: "main".to_owned(),
        frame_count,
        points: points.points(budget)?,
        visible: visible.bools(budget)?,
        motion_valid: since_previous(valid.bools(budget)?, frame_count, point_count),
        controls: controls.points(budget)?,
        start_frames: 1,
        ..Sequence::default()
    };
    let mut object = Object { point_count, ..Object::default() };
    if let Some(colors) = colors {
        object.colors = colors.colors(budget)?.into_iter().take(point_count).collect();
    }
    for (key, into, what) in [
        (
            "surface_points",
            &mut object.completed_surface,
            "the twin's surface is what the cameras saw",
        ),
        ("interior_points", &mut object.interior, "the twin has no interior nodes"),
    ] {
        match data.entry(key)? {
            Some(array) => {
                let &[count, 3] = array.shape.as_slice() else {
                    return Err(array.wrong_shape("[S, 3]"));
                };
                at_most(key, count, files.limits.points)?;
                *into = array.points(budget)?;
            }
            None => notes
                .push(Note::info("OPTIONAL_MISSING", format!("`{MARKER}` has no {key}: {what}"))),
        }
    }
    drop(data);
    drop(bytes);

    sequence.truth_tracks = truth(files, frame_count, notes)?;
    sequence.train_frame_count = split(files, frame_count, notes)?;
    let mut capture = Capture {
        name: files.name.clone(),
        fps: metadata.fps,
        environment: Environment::Z_UP,
        source_to_world: bendtwin_core::geometry::IDENTITY,
        object,
        sequences: vec![sequence],
        others: Vec::new(),
    };
    turn(&mut capture);
    Ok(capture)
}

/// PhysTwin flags the motion from a frame to the next one; a capture flags the
/// motion from the previous frame. The first frame has none.
fn since_previous(mut to_next: Vec<bool>, frame_count: usize, point_count: usize) -> Vec<bool> {
    to_next.truncate(frame_count.saturating_sub(1) * point_count);
    to_next.splice(0..0, std::iter::repeat_n(false, point_count));
    to_next.resize(frame_count * point_count, false);
    to_next
}

/// From z down to z up.
fn turn(capture: &mut Capture) {
    let Some(frame) = Frame::from_up("-z") else { return };
    capture.source_to_world = frame.rotation;
    frame.apply(&mut capture.object.completed_surface);
    frame.apply(&mut capture.object.interior);
    for sequence in &mut capture.sequences {
        for points in [&mut sequence.points, &mut sequence.controls, &mut sequence.truth_tracks] {
            frame.apply(points);
        }
    }
}

pub(crate) fn truth(
    files: &mut Files<'_>,
    frame_count: usize,
    notes: &mut Vec<Note>,
) -> Result<Vec<Point>, Error> {
    const NAME: &str = "gt_track_3d.pkl";
    let Some(bytes) = files.find(NAME)? else {
        notes.push(Note::info(
            "OPTIONAL_MISSING",
            format!(
                "there is no {NAME}: the track metric is left out unless every point is a node"
            ),
        ));
        return Ok(Vec::new());
    };
    let array = pickle::read(NAME, &bytes, &files.limits, &mut files.budget)?.array()?;
    match array.shape.as_slice() {
        &[frames, count, 3] if frames == frame_count => {
            at_most("ground-truth tracks", count, files.limits.points)?;
            array.points(&mut files.budget)
        }
        _ => Err(array.wrong_shape(&format!("[{frame_count}, K, 3]"))),
    }
}

pub(crate) fn split(
    files: &mut Files<'_>,
    frame_count: usize,
    notes: &mut Vec<Note>,
) -> Result<usize, Error> {
    const NAME: &str = "split.json";
    let Some(bytes) = files.find_document(NAME)? else {
        let train = (frame_count as f64 * TRAIN_SHARE).round() as usize;
        notes.push(Note::info(
            "OPTIONAL_MISSING",
            format!(
                "there is no {NAME}: the first {train} of {frame_count} frames are for fitting"
            ),
        ));
        return Ok(train);
    };
    let split: Split = json(&bytes, NAME)?;
    let out_of_range =
        |split| Error::SplitRange { sequence: "main".to_owned(), split, frames: frame_count };
    let [start, end] = split.train;
    if start != 0 {
        return Err(Error::Document {
            at: NAME.to_owned(),
            fault: format!("`train` starts at frame {start}: it must start at 0"),
        });
    }
    if let Some(last) = split.test.map(|t| t[1]).filter(|last| *last > frame_count as i64) {
        return Err(out_of_range(last));
    }
    usize::try_from(end).ok().filter(|end| *end <= frame_count).ok_or(out_of_range(end))
}

fn expect(array: &Array<'_>, shape: &[usize], letters: &str) -> Result<(), Error> {
    if array.shape == shape {
        Ok(())
    } else {
        Err(array.wrong_shape(&format!("{shape:?}, {letters}")))
    }
}

/// Parses a JSON document of a known form. A fault is named with its field.
pub(crate) fn json<'de, T: Deserialize<'de>>(bytes: &'de [u8], at: &str) -> Result<T, Error> {
    let fault = |fault: String| Error::Document { at: at.to_owned(), fault };
    let mut reader = serde_json::Deserializer::from_slice(bytes);
    let document = serde_path_to_error::deserialize(&mut reader).map_err(|error| {
        let (field, text) = (error.path().to_string(), error.inner().to_string());
        // The place counts only where the text itself is broken.
        if !error.inner().is_data() {
            return fault(text);
        }
        let what = text.rsplit_once(" at line ").map_or(text.as_str(), |(what, _)| what);
        fault(if field == "." { what.to_owned() } else { format!("`{field}`: {what}") })
    })?;
    reader.end().map_err(|error| fault(error.to_string()))?;
    Ok(document)
}

#[cfg(test)]
mod tests;
