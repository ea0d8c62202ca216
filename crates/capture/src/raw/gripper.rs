//! Grippers of a robot: their recorded poses and openings, from `grippers.json` beside the description
//! of a recording. They tell where the object is held, without masks.

use bendtwin_core::geometry::{cross, dot};
use serde::Deserialize;

use super::{Pose, validity::settle_pose};
use crate::{
    Error, Sources,
    files::{Files, at_most, is_plain},
    frame::Frame,
    npy,
    phystwin::json,
};

const DOCUMENT: &str = "grippers.json";
const FORMAT: &str = "bendtwin-grippers";
const VERSION: u32 = 1;

/// Most grippers of a recording.
const MAX_GRIPPERS: usize = 8;
/// Widest opening of a gripper that holds soft objects, and largest finger [m].
const MAX_WIDTH_M: f64 = 1.0;

/// A gripper whose motion was recorded. Its axes: the origin lies between the tips of the fingers, z
/// points out of the gripper, and the fingers open along y.
#[derive(Clone, Debug, PartialEq)]
pub struct Gripper {
    /// A person's name for it.
    pub name: String,
    /// Pose in the world in each frame [T]; `None` where it is unknown.
    pub poses: Vec<Option<Pose>>,
    /// Distance between the fingers in each frame [T] [m], NaN where it is unknown; empty if it was not
    /// recorded.
    pub widths_m: Vec<f64>,
    /// The part of a finger that touches.
    pub pad: Pad,
}

/// The part of a finger that touches what is held.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pad {
    /// Extent from the tip back along z [m].
    pub length_m: f64,
    /// Extent along x [m].
    pub breadth_m: f64,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Document {
    format: String,
    version: u32,
    grippers: Vec<Entry>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Entry {
    #[serde(default)]
    name: String,
    poses: Numbers,
    widths: Option<Numbers>,
    #[serde(default)]
    axes: Axes,
    #[serde(default)]
    pad: PadEntry,
}

/// Numbers in a file, or in the document itself.
#[derive(Deserialize)]
#[serde(untagged)]
enum Numbers {
    File(String),
    Rows(Vec<Vec<Option<f64>>>),
    Row(Vec<Option<f64>>),
}

/// Axes of the recorded poses: which of them is which.
#[derive(Deserialize)]
#[serde(deny_unknown_fields, default)]
struct Axes {
    approach: String,
    opening: String,
}

impl Default for Axes {
    fn default() -> Self {
        Self { approach: "+z".to_owned(), opening: "+y".to_owned() }
    }
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields, default)]
struct PadEntry {
    length_m: f64,
    breadth_m: f64,
}

impl Default for PadEntry {
    fn default() -> Self {
        Self { length_m: 0.02, breadth_m: 0.02 }
    }
}

/// The grippers of a recording of `frames` frames; none without their document. `frame` leads from the
/// recording's world.
///
/// # Errors
/// If the document contradicts itself or the number of frames.
pub(super) fn find(
    files: &mut Files<'_>,
    frames: usize,
    frame: &Frame,
    sources: &mut Sources,
) -> Result<Vec<Gripper>, Error> {
    let Some(bytes) = files.find_document(DOCUMENT)? else { return Ok(Vec::new()) };
    let document: Document = json(&bytes, DOCUMENT)?;
    if document.format != FORMAT || document.version != VERSION {
        return Err(wrong(format!(
            "it is `{}` version {}: `{FORMAT}` version {VERSION} is read",
            document.format, document.version
        )));
    }
    at_most("grippers", document.grippers.len(), MAX_GRIPPERS)?;
    let mut grippers = Vec::with_capacity(document.grippers.len());
    for (index, entry) in document.grippers.into_iter().enumerate() {
        let gripper = gripper(files, entry, index, frames, frame)?;
        let form = if gripper.widths_m.is_empty() { "without its opening" } else { "" };
        sources.take("gripper", Some(&gripper.name), DOCUMENT, form);
        grippers.push(gripper);
    }
    Ok(grippers)
}

fn gripper(
    files: &mut Files<'_>,
    entry: Entry,
    index: usize,
    frames: usize,
    frame: &Frame,
) -> Result<Gripper, Error> {
    let name = if entry.name.is_empty() { index.to_string() } else { entry.name };
    let axes = axes(&name, &entry.axes)?;
    let (columns, numbers) = rows(files, entry.poses)?;
    let poses = match columns {
        7 | 12 | 16 if numbers.len() == frames * columns => numbers
            .chunks_exact(columns)
            .map(|row| Ok(pose(&name, row)?.map(|pose| pose.after(&axes).turned(frame))))
            .collect::<Result<Vec<_>, Error>>()?,
        _ => {
            return Err(wrong(format!(
                "the poses of gripper `{name}` are {} rows of {columns} numbers: give {frames} rows, one a frame, of x, y, z and a \
                 quaternion x, y, z, w, or of a 4 x 4 matrix",
                numbers.len() / columns.max(1)
            )));
        }
    };
    if poses.iter().all(Option::is_none) {
        return Err(wrong(format!("gripper `{name}` has no pose in any frame")));
    }
    let widths_m = match entry.widths {
        None => Vec::new(),
        Some(widths) => widths_of(files, widths, &name, frames)?,
    };
    let pad = Pad { length_m: entry.pad.length_m, breadth_m: entry.pad.breadth_m };
    if ![pad.length_m, pad.breadth_m].iter().all(|x| *x > 0.0 && *x <= MAX_WIDTH_M) {
        return Err(wrong(format!(
            "the pad of gripper `{name}` is {} x {} m: give its size in metres",
            pad.length_m, pad.breadth_m
        )));
    }
    Ok(Gripper { name, poses, widths_m, pad })
}

fn widths_of(
    files: &mut Files<'_>,
    widths: Numbers,
    name: &str,
    frames: usize,
) -> Result<Vec<f64>, Error> {
    let (_, widths) = rows(files, widths)?;
    if widths.len() != frames {
        let count = widths.len();
        return Err(wrong(format!(
            "gripper `{name}` has {count} widths for {frames} frames: give one a frame"
        )));
    }
    match widths.iter().find(|w| !w.is_nan() && !(0.0..=MAX_WIDTH_M).contains(*w)) {
        None => Ok(widths),
        Some(width) => Err(wrong(format!(
            "gripper `{name}` is open by {width}: give the distance between its fingers in metres"
        ))),
    }
}

/// Numbers of a row, and all numbers, row by row; unknown ones are NaN.
fn rows(files: &mut Files<'_>, numbers: Numbers) -> Result<(usize, Vec<f64>), Error> {
    let known = |x: Option<f64>| x.unwrap_or(f64::NAN);
    match numbers {
        Numbers::File(at) => {
            if !is_plain(&at) {
                return Err(wrong(format!("`{at}` is no relative path of a file")));
            }
            let bytes = files.read(&at)?;
            let array = npy::read(&at, &bytes)?;
            // Shapes of empty arrays may be of any size.
            let columns = array.shape.iter().skip(1).fold(1_usize, |all, n| all.saturating_mul(*n));
            Ok((columns, array.doubles(&mut files.budget)?))
        }
        Numbers::Row(row) => Ok((1, row.into_iter().map(known).collect())),
        Numbers::Rows(rows) => {
            let columns = rows.first().map_or(0, Vec::len);
            if rows.iter().any(|row| row.len() != columns) {
                return Err(wrong("rows of poses have different lengths".to_owned()));
            }
            Ok((columns, rows.into_iter().flatten().map(known).collect()))
        }
    }
}

/// The pose of a row, if it is known.
fn pose(name: &str, row: &[f64]) -> Result<Option<Pose>, Error> {
    if !row.iter().all(|x| x.is_finite()) {
        return Ok(None);
    }
    let what = format!("gripper {name}");
    let pose = match *row {
        [x, y, z, i, j, k, w] => Pose::from_quaternion([i, j, k, w], [x, y, z]),
        _ => Pose::from_rows(&what, row.as_chunks::<4>().0)?,
    };
    settle_pose(&what, &pose).map(Some)
}

/// The rotation from the axes of this program to those of the poses.
fn axes(name: &str, axes: &Axes) -> Result<Pose, Error> {
    let unit = |axis: &str| -> Option<[f64; 3]> {
        let (sign, letter) = match axis.as_bytes() {
            [b'+', letter] | [letter] => (1.0, letter),
            [b'-', letter] => (-1.0, letter),
            _ => return None,
        };
        let index = [b'x', b'y', b'z'].iter().position(|l| l == letter)?;
        Some(std::array::from_fn(|i| if i == index { sign } else { 0.0 }))
    };
    let (Some(z), Some(y)) = (unit(&axes.approach), unit(&axes.opening)) else {
        return Err(wrong(format!(
            "the axes of gripper `{name}` are `{}` and `{}`: each must be one of +x, -x, +y, -y, +z, -z",
            axes.approach, axes.opening
        )));
    };
    if dot(y, z) != 0.0 {
        return Err(wrong(format!(
            "gripper `{name}` approaches and opens along one axis: these differ"
        )));
    }
    let columns = [cross(y, z), y, z];
    let rotation = std::array::from_fn(|i| columns.map(|column| column[i]));
    Ok(Pose { rotation, ..Pose::IDENTITY })
}

fn wrong(fault: String) -> Error {
    Error::Document { at: DOCUMENT.to_owned(), fault }
}

#[cfg(test)]
mod tests;
