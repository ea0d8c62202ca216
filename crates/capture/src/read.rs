//! The one way in: finds out what kind of capture lies at a path and reads it.

mod coincident;

use std::path::Path;

use bendtwin_core::{Capture, Finding};

use crate::{
    Error, Limits, Sources, bundle,
    check::{Note, structure::validate},
    files::Files,
    format::{Format, Place, root, taken},
    mocap, phystwin,
    raw::{self, Recording},
    several::{self, Part},
};

/// Reads a capture from a folder, a ZIP or tar archive, or a file of motion capture: an .npz with its
/// .json beside it, or markers as C3D, CSV or TRC. They may lie in a folder or archive, too.
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
    if let Some((capture, _)) = mocap::read_markers_in(name, bytes, limits)? {
        validate(&capture)?;
        return Ok(capture);
    }
    let mut files = Files::from_bytes(name, bytes, limits)?;
    read_files(&mut files, &mut Remarks::default())
}

/// Content of a path: points, or a raw recording of cameras.
#[derive(Debug)]
pub enum Opened {
    /// Points that were tracked already, and what the reader noticed without failing.
    Observed(Capture, Remarks),
    /// Colour and depth, to be lifted to points.
    Raw(Recording),
    /// Several recordings of one object, the reference first.
    Several(Vec<Part>),
}

/// What a reader of tracked points noticed, and what it took as what.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Remarks {
    /// What it noticed.
    pub findings: Vec<Finding>,
    /// What was taken as what; empty if the format leaves no choice.
    pub sources: Sources,
}

impl Remarks {
    pub(crate) fn add(&mut self, notes: Vec<Note>) {
        self.findings.extend(notes.into_iter().map(|note| note.0));
    }

    pub(crate) fn extend(&mut self, other: Self) {
        self.findings.extend(other.findings);
        self.sources.extend(other.sources);
    }
}

impl IntoIterator for Remarks {
    type Item = Finding;
    type IntoIter = std::vec::IntoIter<Finding>;

    fn into_iter(self) -> Self::IntoIter {
        self.findings.into_iter()
    }
}

/// Opens the capture at a path: with [`read`] or, if nothing there is processed, with
/// [`raw::open`].
///
/// # Errors
/// If there is no capture, it is damaged, or it exceeds the limits.
pub fn open(path: &Path, limits: &Limits) -> Result<Opened, Error> {
    match Place::at(path) {
        Place::Arrays(path) => {
            let capture = mocap::read_npz(path, &path.with_extension("json"), limits)?;
            Ok(Opened::Observed(capture, Remarks::default()))
        }
        Place::Markers(path) => {
            let (capture, remarks) = mocap::read_markers(path, limits)?;
            validate(&capture)?;
            Ok(Opened::Observed(capture, remarks))
        }
        Place::Mcap(file) => raw::open_mcap(file, limits).map(Opened::Raw),
        Place::Files(path) => open_files(&mut Files::open(path, limits)?),
    }
}

/// Opens the capture in these files.
pub(crate) fn open_files(files: &mut Files<'static>) -> Result<Opened, Error> {
    if let Some(parts) = several::open(files)? {
        return Ok(Opened::Several(parts));
    }
    let mut remarks = Remarks::default();
    match read_one(files, &mut remarks) {
        Ok(capture) => Ok(Opened::Observed(capture, remarks)),
        Err(Error::RawOnly(_)) => raw::find(files.fork()).map(Opened::Raw),
        Err(error) => Err(error),
    }
}

pub(crate) fn read_noting(path: &Path, limits: &Limits) -> Result<(Capture, Remarks), Error> {
    let mut remarks = Remarks::default();
    let capture = match Place::at(path) {
        Place::Arrays(path) => mocap::read_npz(path, &path.with_extension("json"), limits)?,
        Place::Markers(path) => {
            let (capture, remarks) = mocap::read_markers(path, limits)?;
            validate(&capture)?;
            return Ok((capture, remarks));
        }
        Place::Mcap(_) => {
            let name = root(path).file_stem().unwrap_or_default().to_string_lossy();
            return Err(Error::RawOnly(name.into_owned()));
        }
        Place::Files(path) => read_files(&mut Files::open(path, limits)?, &mut remarks)?,
    };
    Ok((capture, remarks))
}

fn read_files(files: &mut Files<'_>, remarks: &mut Remarks) -> Result<Capture, Error> {
    match several::read(files, remarks)? {
        Some(capture) => Ok(capture),
        None => read_one(files, remarks),
    }
}

/// Reads a capture that is not several recordings.
pub(crate) fn read_one(files: &mut Files<'_>, remarks: &mut Remarks) -> Result<Capture, Error> {
    if !files.settle(Format::is_in)? {
        return Err(files.unknown());
    }
    let contents = files.list("");
    let mut formats = Format::all(&contents);
    let format = match formats.next() {
        // Points of a recording may lie beside the document that names all recordings.
        Some(Format::Recordings) => {
            formats.next().filter(|format| [Format::Bundle, Format::PhysTwin].contains(format))
        }
        first => first,
    };
    let mut notes = Vec::new();
    let mut capture = match (format, mocap::packed(&contents)) {
        (Some(Format::Bundle), _) => bundle::read(files, &mut notes)?,
        (Some(Format::PhysTwin), _) => phystwin::read(files, &mut notes)?,
        (Some(Format::Markers), _) => {
            let (capture, more) = mocap::read_packed_markers(files)?;
            remarks.extend(more);
            capture
        }
        (Some(Format::MotionCapture), Some(npz)) => mocap::read_packed(files, npz)?,
        (Some(Format::Nerfstudio | Format::RawPhysTwin | Format::Mcap), _) => {
            return Err(Error::RawOnly(files.name.clone()));
        }
        (Some(Format::Recordings | Format::MotionCapture) | None, _) => return Err(files.unknown()),
    };
    coincident::merge(&mut capture.object, &mut notes);
    notes.extend(taken(&contents).map(Note));
    remarks.add(notes);
    validate(&capture)?;
    Ok(capture)
}
