//! The one way in: finds out what kind of capture lies at a path and reads it.

use std::path::Path;

use bendtwin_core::{Capture, Finding};

use crate::{
    Error, Limits, bundle,
    check::Note,
    files::{Contents, Files},
    mocap, phystwin,
    raw::{self, Recording},
    several::{self, Part},
    structure::validate,
};

/// Reads a capture from a folder, a ZIP or tar archive, or an .npz of motion capture with its .json
/// beside it, which may lie in a folder or archive, too.
///
/// The result is structurally sound (lengths agree, indices exist), in metres
/// with z up. [`crate::check()`] judges its numbers.
///
/// # Errors
/// If there is no capture, it is damaged, or it exceeds the limits.
pub fn read(path: &Path, limits: &Limits) -> Result<Capture, Error> {
    read_noting(path, limits).map(|(capture, _)| capture)
}

/// Reads a capture from the bytes of an archive; `name` stands in for its file name.
///
/// # Errors
/// Those of [`read`].
pub fn read_bytes(name: &str, bytes: &[u8], limits: &Limits) -> Result<Capture, Error> {
    let mut files = Files::from_bytes(name, bytes, limits)?;
    read_files(&mut files, &mut Vec::new())
}

/// Content of a path: points, or a raw recording of cameras.
#[derive(Debug)]
pub enum Opened {
    /// Points that were tracked already, and what the reader noticed without failing.
    Observed(Capture, Vec<Finding>),
    /// Colour and depth, to be lifted to points.
    Raw(Recording),
    /// Several recordings of one object, the reference first.
    Several(Vec<Part>),
}

/// Opens the capture at a path: with [`read`] or, if nothing there is processed, with
/// [`raw::open`].
///
/// # Errors
/// If there is no capture, it is damaged, or it exceeds the limits.
pub fn open(path: &Path, limits: &Limits) -> Result<Opened, Error> {
    let path = root(path);
    if is_npz(path) {
        let (capture, notes) = read_noting(path, limits)?;
        return Ok(observed(capture, notes));
    }
    if raw::mcap_at(path)?.is_some() {
        return raw::open(path, limits).map(Opened::Raw);
    }
    open_files(&mut Files::open(path, limits)?)
}

/// Opens the capture in these files.
pub(crate) fn open_files(files: &mut Files<'static>) -> Result<Opened, Error> {
    if let Some(parts) = several::open(files)? {
        return Ok(Opened::Several(parts));
    }
    let mut notes = Vec::new();
    match read_one(files, &mut notes) {
        Ok(capture) => Ok(observed(capture, notes)),
        Err(Error::RawOnly(_)) => raw::find(files.fork()).map(Opened::Raw),
        Err(error) => Err(error),
    }
}

fn observed(capture: Capture, notes: Vec<Note>) -> Opened {
    Opened::Observed(capture, notes.into_iter().map(|n| n.0).collect())
}

/// True for the arrays of motion capture, which are no archive of files.
fn is_npz(path: &Path) -> bool {
    path.extension().is_some_and(|e| e.eq_ignore_ascii_case("npz"))
}

/// The folder or file to open: a person may point at the document inside the bundle.
pub(crate) fn root(path: &Path) -> &Path {
    match (path.file_name(), path.parent()) {
        (Some(name), Some(parent)) if name == bundle::MARKER && path.is_file() => {
            if parent.as_os_str().is_empty() { Path::new(".") } else { parent }
        }
        _ => path,
    }
}

pub(crate) fn read_noting(path: &Path, limits: &Limits) -> Result<(Capture, Vec<Note>), Error> {
    let mut notes = Vec::new();
    let path = root(path);
    let capture = if is_npz(path) {
        mocap::read_npz(path, &path.with_extension("json"), limits)?
    } else if raw::mcap_at(path)?.is_some() {
        let name = path.file_stem().unwrap_or_default().to_string_lossy();
        return Err(Error::RawOnly(name.into_owned()));
    } else {
        read_files(&mut Files::open(path, limits)?, &mut notes)?
    };
    Ok((capture, notes))
}

fn read_files(files: &mut Files<'_>, notes: &mut Vec<Note>) -> Result<Capture, Error> {
    match several::read(files, notes)? {
        Some(capture) => Ok(capture),
        None => read_one(files, notes),
    }
}

/// Reads a capture that is not several recordings.
pub(crate) fn read_one(files: &mut Files<'_>, notes: &mut Vec<Note>) -> Result<Capture, Error> {
    if !files.settle(is_capture)? {
        return Err(files.unknown());
    }
    let contents = files.list("");
    let capture = if contents.has(bundle::MARKER) {
        bundle::read(files, notes)?
    } else if contents.has(phystwin::MARKER) {
        phystwin::read(files, notes)?
    } else if contents.has(several::MARKER) {
        return Err(files.unknown());
    } else if let (true, Some(npz)) = (is_motion_capture(&contents), mocap::packed(&contents)) {
        mocap::read_packed(files, npz)?
    } else {
        return Err(Error::RawOnly(files.name.clone()));
    };
    notes.extend(taken(&contents).map(Note));
    validate(&capture)?;
    Ok(capture)
}

/// `true` if a folder with these files is a capture.
pub(crate) fn is_capture(contents: &Contents) -> bool {
    formats(contents).next().is_some()
}

/// Words for recordings that lie in folders.
const SEVERAL: &str = "several recordings (`recordings.json`)";
const MOTION_CAPTURE: &str = "motion capture (`.npz` with its `.json`)";

/// `true` if a folder is read as motion capture.
fn is_motion_capture(contents: &Contents) -> bool {
    formats(contents).next() == Some(MOTION_CAPTURE)
}

/// Formats in a folder; the first is read.
pub(crate) fn formats(contents: &Contents) -> impl Iterator<Item = &'static str> {
    [
        (contents.has(several::MARKER), SEVERAL),
        (contents.has(bundle::MARKER), "a bundle (`capture.json`)"),
        (contents.has(phystwin::MARKER), "a processed PhysTwin case (`final_data.pkl`)"),
        (contents.has(raw::nerfstudio::MARKER), "nerfstudio (`transforms.json`)"),
        (raw::is_case(contents), "a raw PhysTwin case (`metadata.json` with `color`)"),
        (mocap::packed(contents).is_some(), MOTION_CAPTURE),
    ]
    .into_iter()
    .filter_map(|(is_there, name)| is_there.then_some(name))
}

/// The finding that says which format of several was read.
pub(crate) fn taken(contents: &Contents) -> Option<Finding> {
    // One of several recordings may lie beside the document that names them all.
    let mut formats = formats(contents).filter(|format| *format != SEVERAL);
    let first = formats.next()?;
    let others = formats.collect::<Vec<_>>().join(" and ");
    let message = format!("it was read as {first}; {others} in the same folder is passed over");
    let advice = "move the files of the first away to have the other read";
    let finding = Finding { advice: advice.into(), ..Finding::info("FORMAT_TAKEN", message) };
    (!others.is_empty()).then_some(finding)
}
