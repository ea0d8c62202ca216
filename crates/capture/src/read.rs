//! The one way in: finds out what kind of capture lies at a path and reads it.

use std::path::Path;

use bendtwin_core::{Capture, Finding};

use crate::{
    Error, Limits, bundle,
    check::Note,
    files::Files,
    mocap, phystwin,
    raw::{self, Recording},
    several::{self, Part},
    structure::validate,
};

/// Reads a capture from a folder, a ZIP archive or an .npz of motion capture
/// with its .json beside it.
///
/// The result is structurally sound (lengths agree, indices exist), in metres
/// with z up. [`crate::check()`] judges its numbers.
///
/// # Errors
/// If there is no capture, it is damaged, or it exceeds the limits.
pub fn read(path: &Path, limits: &Limits) -> Result<Capture, Error> {
    read_noting(path, limits).map(|(capture, _)| capture)
}

/// Reads a capture from the bytes of a ZIP archive; `name` stands in for its file name.
///
/// # Errors
/// As [`read`].
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

/// Opens whatever lies at a path: as [`read`] and, where there is nothing processed, as
/// [`raw::open`].
///
/// # Errors
/// If there is no capture, it is damaged, or it exceeds the limits.
pub fn open(path: &Path, limits: &Limits) -> Result<Opened, Error> {
    if let Some(parts) = several::open(path, limits)? {
        return Ok(Opened::Several(parts));
    }
    match read_noting(path, limits) {
        Ok((capture, notes)) => {
            Ok(Opened::Observed(capture, notes.into_iter().map(|n| n.0).collect()))
        }
        Err(Error::RawOnly(_)) => raw::open(path, limits).map(Opened::Raw),
        Err(error) => Err(error),
    }
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
    let capture = if path.extension().is_some_and(|e| e.eq_ignore_ascii_case("npz")) {
        mocap::read_npz(path, &path.with_extension("json"), limits)?
    } else if raw::is_mcap(path)? {
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
    let capture = if files.enter(bundle::MARKER)? {
        bundle::read(files, notes)?
    } else if files.enter(phystwin::MARKER)? {
        phystwin::read(files, notes)?
    } else if raw::is_here(files)? {
        return Err(Error::RawOnly(files.name.clone()));
    } else {
        return Err(Error::UnknownKind(files.name.clone()));
    };
    validate(&capture)?;
    Ok(capture)
}
