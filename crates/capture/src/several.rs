//! Several recordings of one object: `recordings.json` and one folder for each, in any format of a
//! capture. `docs/formats/capture.md` specifies it for other programs.

use bendtwin_core::Capture;
use serde::{Deserialize, Serialize};

use crate::{
    Error, Opened, Remarks,
    check::structure::validate,
    files::{Files, at_most},
    format::Format,
    limits::Budget,
    phystwin::json,
    raw,
    read::read_one,
};

/// The document that says that folders are recordings of one object.
pub(crate) const MARKER: &str = "recordings.json";
/// The folder of a recording that lies beside the document itself.
pub(crate) const ROOT: &str = ".";
/// The word in `format`.
const FORMAT: &str = "bendtwin-recordings";
/// Version that this build reads and writes.
const VERSION: u64 = 1;

/// A recording among several of one object.
#[derive(Debug)]
pub struct Part {
    /// Name of the recording.
    pub name: String,
    /// True if no frame of it is for fitting.
    pub held_out: bool,
    /// Content, which is never several recordings itself.
    pub opened: Opened,
}

#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Document {
    format: String,
    version: u64,
    /// The recordings, the reference first; all folders by name if there are no recordings.
    #[serde(default)]
    recordings: Vec<Entry>,
}

#[derive(Debug, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Entry {
    folder: String,
    /// Name for people; the folder's if it is empty.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    name: String,
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    held_out: bool,
}

/// A recording's files.
struct Place<'a> {
    entry: Entry,
    files: Files<'a>,
}

/// The recordings among these files, opened; `None` if there is no document that names them.
pub(crate) fn open(files: &mut Files<'static>) -> Result<Option<Vec<Part>>, Error> {
    let Some(places) = places(files)? else { return Ok(None) };
    let (mut parts, mut budget) = (Vec::with_capacity(places.len()), Budget::new(&files.limits));
    for Place { entry, mut files } in places {
        let named = |error| in_recording(&entry.name, error);
        let mut remarks = Remarks::default();
        let opened = match read_within(&mut files, &mut budget, &mut remarks) {
            Ok(capture) => Opened::Observed(capture, remarks),
            Err(Error::RawOnly(_)) => Opened::Raw(raw::find(files).map_err(named)?),
            Err(error) => return Err(named(error)),
        };
        parts.push(Part { name: entry.name, held_out: entry.held_out, opened });
    }
    Ok(Some(parts))
}

/// The recordings among these files, all of which must hold points; `None` if there is no document
/// that names them.
pub(crate) fn read(files: &mut Files<'_>, remarks: &mut Remarks) -> Result<Option<Capture>, Error> {
    let Some(places) = places(files)? else { return Ok(None) };
    let whole = files.name.clone();
    let mut captures = Vec::with_capacity(places.len());
    let mut budget = Budget::new(&files.limits);
    for Place { entry, mut files } in places {
        let capture = read_within(&mut files, &mut budget, remarks);
        let capture = capture.map_err(|e| in_recording(&entry.name, e))?;
        captures.push((entry.name, entry.held_out, capture));
    }
    join(whole, captures).map(Some)
}

/// Reads the points of a recording. All recordings are in memory together, so they share a budget.
fn read_within(
    files: &mut Files<'_>,
    budget: &mut Budget,
    remarks: &mut Remarks,
) -> Result<Capture, Error> {
    std::mem::swap(&mut files.budget, budget);
    let read = read_one(files, remarks);
    std::mem::swap(&mut files.budget, budget);
    read
}

/// Joins all recordings of an object into a capture, the reference first.
///
/// # Errors
/// If there are no recordings, or one contradicts itself.
pub fn join(
    name: String,
    recordings: impl IntoIterator<Item = (String, bool, Capture)>,
) -> Result<Capture, Error> {
    let mut all = recordings.into_iter().map(|(name, held_out, mut capture)| {
        if held_out {
            capture.sequences.iter_mut().for_each(|s| s.train_frame_count = 0);
        }
        Capture { name, ..capture }
    });
    let none =
        || Error::UnknownKind { name: name.clone(), there: "which has no recordings".into() };
    let reference = all.next().ok_or_else(none)?;
    let capture = Capture { others: all.collect(), name, ..reference };
    validate(&capture)?;
    Ok(capture)
}

/// The document of recordings in these folders, as JSON.
pub(crate) fn document<'a>(
    folders: impl Iterator<Item = (String, &'a str)>,
) -> Result<Vec<u8>, serde_json::Error> {
    let entry =
        |(folder, name): (String, &str)| Entry { folder, name: name.to_owned(), held_out: false };
    serde_json::to_vec_pretty(&Document {
        format: FORMAT.to_owned(),
        version: VERSION,
        recordings: folders.map(entry).collect(),
    })
}

fn places<'a>(files: &mut Files<'a>) -> Result<Option<Vec<Place<'a>>>, Error> {
    if !files.settle(Format::is_in)? || !files.has(MARKER) {
        return Ok(None);
    }
    let document: Document = json(&files.read_document(MARKER)?, MARKER)?;
    let fault = |fault: String| Error::Damaged { at: MARKER.to_owned(), fault };
    if document.format != FORMAT || document.version != VERSION {
        return Err(fault(format!(
            "it is `{}` version {}, this build reads `{FORMAT}` version {VERSION}",
            document.format, document.version
        )));
    }
    let folders = files.list("").folders;
    let mut entries = document.recordings;
    if entries.is_empty() {
        let all = folders.iter().cloned();
        entries = all.map(|folder| Entry { folder, ..Entry::default() }).collect();
    }
    at_most("recordings", entries.len(), Capture::MOST_RECORDINGS)?;
    if entries.is_empty() {
        return Err(fault("there is no folder with a recording beside it".to_owned()));
    }
    let mut places: Vec<Place<'a>> = Vec::new();
    for mut entry in entries {
        if entry.folder != ROOT && !folders.contains(&entry.folder) {
            return Err(fault(format!("there is no folder `{}` beside it", entry.folder)));
        }
        if entry.name.is_empty() {
            let own = if entry.folder == ROOT { &files.name } else { &entry.folder };
            entry.name.clone_from(own);
        }
        if places.iter().any(|p| p.entry.folder == entry.folder || p.entry.name == entry.name) {
            return Err(fault(format!("recording `{}` is there twice", entry.name)));
        }
        places.push(Place { files: files.part(&entry.folder), entry });
    }
    Ok(Some(places))
}

fn in_recording(name: &str, error: Error) -> Error {
    Error::InRecording { name: name.to_owned(), error: Box::new(error) }
}

#[cfg(test)]
mod tests;
