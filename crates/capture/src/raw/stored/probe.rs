//! A look into the first files of each camera: the forms that only their content tells, and faults that
//! all of them have. Such a fault is refused once, instead of being counted file by file and camera by
//! camera.

use bendtwin_core::{Finding, Problem as _};

use super::{Names, StoredFrames};
use crate::{
    Error, Sources,
    files::Files,
    limits::Budget,
    raw::{
        Camera,
        decode::{
            self, Turn,
            orientation::{self, Orientation},
        },
    },
};

/// Names that are tried until a file is found: a list may name files that are not there.
const MAX_TRIED: usize = 1000;

/// Forms of one camera's files in words; empty if they could not be read.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(in crate::raw) struct Forms {
    pub(in crate::raw) color: String,
    pub(in crate::raw) depth: String,
    /// Absent if there are no tracks.
    pub(in crate::raw) tracks: Option<String>,
}

/// Looks into the files of all cameras, and settles what counts of colour images that declare an
/// orientation; `chosen` is the description's choice.
///
/// # Errors
/// If an orientation leaves open which pixels count, or if all files of depth that were read hold something
/// else.
pub(in crate::raw) fn look(
    source: &mut StoredFrames,
    cameras: &[Camera],
    chosen: Option<Turn>,
    notes: &mut Vec<Finding>,
) -> Result<Vec<Forms>, Error> {
    let mut all = Vec::with_capacity(cameras.len());
    for (index, camera) in cameras.iter().enumerate() {
        let turn = color(source, index, chosen)?;
        if let (Some(of), Some(turn)) = (source.cameras.get_mut(index), &turn) {
            of.turn = turn.counts;
            notes.extend(turn.note(camera).map(|note| note.cameras([index])));
        }
        all.push(Forms {
            color: turn.map_or_else(String::new, |turn| turn.form()),
            depth: depth(source, index)?,
            tracks: source.track_form(index),
        });
    }
    Ok(all)
}

/// Parses the key that says how orientations are meant.
pub(in crate::raw) fn chosen_turn(value: Option<&str>, at: &str) -> Result<Option<Turn>, Error> {
    match value {
        None => Ok(None),
        Some("stored") => Ok(Some(Turn::Stored)),
        Some("shown") => Ok(Some(Turn::Shown)),
        Some(other) => {
            let other: String = other.chars().take(40).collect();
            let fault =
                format!("`image_orientation` is `{other}`: it must be \"stored\" or \"shown\"");
            Err(Error::Document { at: at.to_owned(), fault })
        }
    }
}

/// Adds what was found of each camera to what was taken.
pub(in crate::raw) fn tell(
    sources: &mut Sources,
    cameras: &[Camera],
    forms: &[Forms],
    from: &[[String; 3]],
) {
    for ((camera, forms), [color, depth, tracks]) in cameras.iter().zip(forms).zip(from) {
        let name = Some(camera.name.as_str());
        sources.take("colour", name, color, &forms.color);
        sources.take("depth", name, depth, &forms.depth);
        if let Some(form) = &forms.tracks {
            sources.take("tracks", name, tracks, form);
        }
    }
}

/// A colour image's form, and what counts of its orientation.
struct Turned {
    kind: &'static str,
    declared: Orientation,
    counts: Turn,
}

impl Turned {
    fn form(&self) -> String {
        match self.counts {
            _ if self.declared == Orientation::NONE => self.kind.to_owned(),
            Turn::Shown => format!("{}, {}", self.kind, self.declared.words()),
            _ => format!("{}, as stored", self.kind),
        }
    }

    fn note(&self, camera: &Camera) -> Option<Finding> {
        if self.declared == Orientation::NONE {
            return None;
        }
        let message = format!(
            "colour images of camera `{}` say by EXIF that they are to be shown {} (orientation {}); they were taken as {}",
            camera.name,
            self.declared.words(),
            self.declared.number(),
            if self.counts == Turn::Shown { "shown" } else { "stored" },
        );
        Some(Finding::info("IMAGE_TURNED", message))
    }
}

fn color(
    source: &StoredFrames,
    index: usize,
    chosen: Option<Turn>,
) -> Result<Option<Turned>, Error> {
    let Some(of) = source.cameras.get(index) else { return Ok(None) };
    let mut files = source.files.fork();
    let first = existing(&files, &of.color, 0..source.frame_count);
    let Some((at, bytes)) = first.and_then(|name| read(&mut files, name, of.file_cap())) else {
        return Ok(None);
    };
    let Some((size, declared)) = orientation::peek(&bytes) else { return Ok(None) };
    let stored = size == of.size;
    let shown = declared.turned_size(size) == of.size;
    let counts = match chosen {
        Some(chosen) => chosen,
        None if declared == Orientation::NONE => Turn::Undeclared,
        None if stored && shown => {
            return Err(Error::Turned { at, turn: declared.words(), number: declared.number() });
        }
        None if shown => Turn::Shown,
        None => Turn::Stored,
    };
    let kind = if bytes.starts_with(b"\x89PNG") { "PNG" } else { "JPEG" };
    Ok(Some(Turned { kind, declared, counts }))
}

/// The form of a camera's depth.
fn depth(source: &StoredFrames, index: usize) -> Result<String, Error> {
    let Some(depth) = source.cameras.get(index).and_then(|of| of.depth.as_ref()) else {
        return Ok(String::new());
    };
    let mut files = source.files.fork();
    let (all, cap) = (source.frame_count, source.cameras[index].file_cap());
    // The first, one of the middle, and one of the end.
    let places = [0..all, all / 2..all, all - all.min(2)..all];
    let mut refused = None;
    let mut tried = Vec::new();
    for place in places {
        let Some(name) = existing(&files, &depth.names, place) else { continue };
        if tried.contains(&name) {
            continue;
        }
        tried.push(name.clone());
        files.budget = Budget::new(&files.limits);
        let Some((at, bytes)) = read(&mut files, name, cap) else { return Ok(String::new()) };
        match decode::depth_form(&at, &bytes, depth.unit, &mut files.budget) {
            Ok(form) => return Ok(form),
            Err(error) if error.reason() == "WRONG_DTYPE" => refused = refused.or(Some(error)),
            Err(_) => return Ok(String::new()),
        }
    }
    refused.map_or(Ok(String::new()), Err)
}

/// The first of some frames' names that is there.
fn existing(files: &Files<'_>, names: &Names, frames: std::ops::Range<usize>) -> Option<String> {
    let mut named = frames.filter_map(|frame| names.at(frame)).take(MAX_TRIED);
    named.find(|name| files.has(name)).map(std::borrow::Cow::into_owned)
}

/// A file's name and content; none if it cannot be read: its frame reports that.
fn read(files: &mut Files<'_>, name: String, cap: u64) -> Option<(String, Vec<u8>)> {
    let bytes = files.find_within(&name, cap).ok().flatten()?;
    Some((name, bytes))
}
