//! Markers of motion capture in the files that its programs export: C3D, OptiTrack's CSV, TRC. A reader
//! of each gives [`Markers`]; [`assemble`](self::assemble::assemble) makes a capture of them.
//!
//! A file says neither what the object is nor what moves it: names of markers and of rigid bodies do.
//! What they leave open is declared in a JSON file beside, see [`Description`].

mod assemble;
mod c3d;
mod chain;
mod csv;
mod gaps;
mod names;
mod trc;

use std::{borrow::Cow, ffi::OsStr, fs::File, io::Read as _, path::Path};

use bendtwin_core::{Capture, Point};
use serde::Deserialize;

use self::assemble::assemble;
use crate::{
    Error, Limits, Remarks,
    files::{Contents, Files, at_most, contents::FilesRead, shortened},
    format::Format,
    frame::Frame,
    limits::Budget,
    phystwin::json,
};

/// Bytes by which a file is recognised.
const LOOKED_AT: u64 = 2048;
/// Bytes of memory that a cell of a line takes beside its letters, at most.
const CELL_BYTES: u64 = 128;

/// Format of a file of markers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    /// Binary, of most systems.
    C3d,
    /// Text of OptiTrack's Motive.
    Csv,
    /// Text of Motion Analysis, OpenSim, Motive and others.
    Trc,
}

impl Kind {
    /// The format of a file by its first bytes.
    fn of(start: &[u8]) -> Option<Self> {
        let text = start.strip_prefix(b"\xef\xbb\xbf").unwrap_or(start);
        if text.starts_with(b"Format Version,") {
            Some(Self::Csv)
        } else if text.starts_with(b"PathFileType") {
            Some(Self::Trc)
        } else if c3d::is_one(start) {
            Some(Self::C3d)
        } else {
            None
        }
    }

    /// The format that the name of a file promises; a CSV file may be anything.
    fn named(name: &str) -> Option<Self> {
        let (stem, ending) = name.rsplit_once('.')?;
        match ending.to_ascii_lowercase().as_str() {
            _ if stem.is_empty() => None,
            "c3d" => Some(Self::C3d),
            "csv" => Some(Self::Csv),
            "trc" => Some(Self::Trc),
            _ => None,
        }
    }

    /// The format in words.
    fn words(self) -> &'static str {
        match self {
            Self::C3d => "C3D",
            Self::Csv => "CSV of OptiTrack Motive",
            Self::Trc => "TRC",
        }
    }
}

/// What a file of markers leaves open, in a JSON file of its name beside it. Every key may be absent.
#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
struct Description {
    /// The axis that points up, such as `+z`.
    up_axis: Option<String>,
    /// Unit of lengths: `m`, `cm` or `mm`.
    units: Option<String>,
    /// Markers of the object that a hand or gripper holds.
    held: Vec<String>,
    /// Markers of the hand or gripper itself.
    hand: Vec<String>,
    /// Pairs of markers that are neighbours along a cable.
    edges: Vec<[String; 2]>,
}

/// Markers over time, as a file has them.
#[derive(Debug)]
struct Markers {
    /// Frames per second.
    fps: f64,
    /// Unit of lengths, as declared; empty if it is not.
    units: String,
    /// The axis that points up, and where that is known from; `None` if the file does not say.
    up_axis: Option<(String, &'static str)>,
    /// Axes that may point up if the file does not say, the usual one first.
    usual_axes: [&'static str; 2],
    marks: Vec<Mark>,
    /// Positions in the file's units and axes, NaN where a marker was not seen, shape [T, M].
    points: Vec<Point>,
    /// What was not taken, with the reason.
    left_out: Vec<(String, String)>,
}

/// A marker, or a point of a rigid body.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Mark {
    /// Label, without the body's name.
    label: String,
    /// Name of the rigid body or marker set that it belongs to; empty if of none.
    set: String,
    /// `true` if the set is a rigid body.
    is_rigid: bool,
}

impl Mark {
    /// A mark of a label, `set:label` if it belongs to a set.
    fn labelled(label: &str) -> Self {
        let (set, label) = label.rsplit_once(':').unwrap_or(("", label));
        Self { label: label.trim().to_owned(), set: set.trim().to_owned(), is_rigid: false }
    }

    /// The whole label.
    fn full(&self) -> String {
        match self.set.as_str() {
            "" => self.label.clone(),
            set => format!("{set}:{}", self.label),
        }
    }
}

impl Markers {
    fn frame_count(&self) -> usize {
        self.points.len().checked_div(self.marks.len()).unwrap_or(0)
    }
}

/// True if a file has markers, by its first bytes.
pub(crate) fn is_file(path: &Path) -> bool {
    let mut start = Vec::new();
    path.is_file()
        && File::open(path).is_ok_and(|f| f.take(LOOKED_AT).read_to_end(&mut start).is_ok())
        && Kind::of(&start).is_some()
}

/// True if a folder holds markers and nothing else.
pub(crate) fn has(contents: &Contents) -> bool {
    let is_document = |name: &String| name.to_ascii_lowercase().ends_with(".json");
    let is_known = |name: &String| Kind::named(name).is_some() || is_document(name);
    !packed(contents).is_empty()
        && contents.folders.is_empty()
        && contents.files.iter().all(is_known)
}

/// Files of markers in a folder.
fn packed(contents: &Contents) -> Vec<String> {
    contents.files.iter().filter(|name| Kind::named(name).is_some()).cloned().collect()
}

/// A file of markers, and its description if there is one beside it.
pub(crate) fn files_of(path: &Path) -> FilesRead {
    let text = |part: Option<&OsStr>| part.unwrap_or_default().to_string_lossy().into_owned();
    let name = text(path.file_name());
    let document = description_of(&name);
    let mut files = vec![name];
    if path.with_file_name(&document).is_file() {
        files.push(document);
    }
    FilesRead {
        name: text(path.file_stem()),
        folder: String::new(),
        format: Format::Markers.words(),
        files,
    }
}

/// A file of markers and its description, if there is one beside it.
pub fn described(path: &Path) -> Option<FilesRead> {
    is_file(path).then(|| files_of(path)).filter(|read| read.files.len() > 1)
}

/// Reads the only file of markers in a folder or an archive, with its description if there is one.
pub(crate) fn read_packed(files: &mut Files<'_>) -> Result<(Capture, Remarks), Error> {
    let names = packed(&files.list(""));
    match names.as_slice() {
        [name] => read_named(files, &files.name.clone(), name),
        _ => Err(Error::Several(shortened(&names, names.len()))),
    }
}

/// Reads a separate file of markers, with the description beside it if there is one.
pub(crate) fn read_file(path: &Path, limits: &Limits) -> Result<(Capture, Remarks), Error> {
    let at = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let title = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let folder = path.parent().filter(|parent| !parent.as_os_str().is_empty());
    let mut files = Files::open(folder.unwrap_or(Path::new(".")), limits)?;
    read_named(&mut files, &title, &at)
}

/// Reads bytes if they are a file of markers.
pub(crate) fn read_in(
    title: &str,
    bytes: &[u8],
    limits: &Limits,
) -> Result<Option<(Capture, Remarks)>, Error> {
    let Some(kind) = Kind::of(bytes) else { return Ok(None) };
    let (described, mut budget) = (Description::default(), Budget::new(limits));
    read_bytes(title, title, kind, bytes, &described, limits, &mut budget).map(Some)
}

fn read_named(files: &mut Files<'_>, title: &str, name: &str) -> Result<(Capture, Remarks), Error> {
    let document = description_of(name);
    let described = files.find_document(&document)?.map(|bytes| json(&bytes, &document));
    let described: Description = described.transpose()?.unwrap_or_default();
    let bytes = files.read(name)?;
    let kind = Kind::of(&bytes).ok_or_else(|| Error::UnknownKind {
        name: name.to_owned(),
        there: "which has no markers of motion capture".to_owned(),
    })?;
    let limits = files.limits.clone();
    read_bytes(title, name, kind, &bytes, &described, &limits, &mut files.budget)
}

fn read_bytes(
    title: &str,
    at: &str,
    kind: Kind,
    bytes: &[u8],
    description: &Description,
    limits: &Limits,
    budget: &mut Budget,
) -> Result<(Capture, Remarks), Error> {
    let mut markers = match kind {
        Kind::C3d => c3d::read(at, bytes, limits, budget)?,
        Kind::Csv => csv::read(at, &text(at, bytes)?, limits, budget)?,
        Kind::Trc => trc::read(at, &text(at, bytes)?, limits, budget)?,
    };
    if let Some(units) = &description.units {
        units.clone_into(&mut markers.units);
    }
    if let Some(axis) = &description.up_axis {
        markers.up_axis = Some((axis.clone(), "as declared"));
    }
    assemble(title, at, kind, markers, description, limits)
}

/// The text of a file; labels of old programs may be in any 8-bit encoding.
fn text<'a>(at: &str, bytes: &'a [u8]) -> Result<Cow<'a, str>, Error> {
    if bytes.starts_with(b"\xff\xfe") || bytes.starts_with(b"\xfe\xff") {
        let fault = "it is UTF-16 text: save it as UTF-8".to_owned();
        return Err(Error::Document { at: at.to_owned(), fault });
    }
    Ok(String::from_utf8_lossy(bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes)))
}

fn description_of(name: &str) -> String {
    format!("{}.json", name.rsplit_once('.').map_or(name, |(stem, _)| stem))
}

/// Takes the memory of positions of all marks in all frames, and of the flags and copies beside them.
fn reserve(
    at: &str,
    frames: usize,
    marks: usize,
    limits: &Limits,
    budget: &mut Budget,
) -> Result<Vec<Point>, Error> {
    at_most("frames", frames, limits.frames)?;
    at_most("tracked points", marks, limits.points)?;
    let cells = frames.saturating_mul(marks);
    budget.take((cells as u64).saturating_mul(64), &format!("`{at}`"))?;
    Ok(Vec::with_capacity(cells))
}

/// Charges the cells of a line before they are taken apart: a line may have nothing but separators.
fn charge_cells(at: &str, line: &str, separator: u8, budget: &mut Budget) -> Result<(), Error> {
    let cells = line.bytes().filter(|byte| *byte == separator).count() as u64;
    budget.take(cells.saturating_add(1).saturating_mul(CELL_BYTES), &format!("`{at}`"))
}

fn damaged(at: &str, fault: impl Into<String>) -> Error {
    Error::Damaged { at: at.to_owned(), fault: fault.into() }
}

/// The frame in which lengths are metres and z points up.
fn frame(axis: &str, units: &str) -> Result<Frame, Error> {
    let turned = Frame::of_up_axis(axis)?;
    let units = match units.trim().to_ascii_lowercase().as_str() {
        "m" | "meters" | "metres" | "meter" | "metre" => "m",
        "cm" | "centimeters" | "centimetres" => "cm",
        "mm" | "millimeters" | "millimetres" => "mm",
        _ => units,
    };
    Ok(Frame { metres: Frame::metres_per(units)?, ..turned })
}

#[cfg(test)]
mod tests;
