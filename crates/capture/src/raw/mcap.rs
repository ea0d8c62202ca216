//! MCAP: what robots record. Images, calibrations and transforms of ROS 1, ROS 2 (CDR) and
//! Foxglove's protobuf messages.
//!
//! A single pass over the files finds where every image lies; after that images are read one by one,
//! so that memory stays flat for files of any length. The topics of a camera are found in [`rig`].

mod chunk;
mod encodings;
mod frames;
mod images;
mod index;
mod joints;
mod messages;
mod names;
mod open;
mod parts;
mod pass;
mod place;
mod protobuf;
mod record;
mod rig;
mod ros;
mod transforms;
mod zstd;

use std::path::Path;

use ::mcap::MAGIC;
use ruzstd::decoding::StreamingDecoder;

pub(super) use self::parts::is_named;
use self::{index::Index, place::Store};
use super::Recording;
use crate::{
    Error, Limits, Sources,
    files::{Files, Section, SharedFile, shortened},
};

/// `true` if an MCAP file lies at a path, which may be compressed as a whole. Its name does not
/// matter: uploads lose it.
pub(super) fn is_at(path: &Path) -> bool {
    let Ok(file) = SharedFile::open(path) else { return false };
    let section = Section::of_file(file);
    let mut start = [0; MAGIC.len()];
    if section.read_exact_at(&mut start, 0).is_err() {
        return false;
    }
    if start.starts_with(zstd::MAGIC) {
        let decoder =
            StreamingDecoder::new_with_max_window_size(section.reader(), zstd::MOST_FILE_WINDOW);
        let read = decoder.map(|mut d| std::io::Read::read_exact(&mut d, &mut start).is_ok());
        return read.unwrap_or(false) && start == MAGIC;
    }
    start == MAGIC
}

/// Reads the recording in the MCAP files of a folder or archive, but none of its frames.
pub(super) fn read(mut files: Files<'_>) -> Result<Recording, Error> {
    let mut sources = Sources::default();
    let parts = parts::of_files(&mut files, &mut sources)?;
    let name = match parts.parts.as_slice() {
        [one] => parts::stem(&one.name),
        _ => files.name.clone(),
    };
    let limits = files.limits.clone();
    let index = Index::read(&parts.parts, &limits)?;
    if !parts.declared {
        parts::expect_one(&parts.parts, &index)?;
    }
    if parts.parts.len() > 1 {
        let names: Vec<String> = parts.parts.iter().map(|part| part.name.clone()).collect();
        let form = format!("{} files, as one recording", names.len());
        sources.take("recording", None, shortened(&names, names.len()), form);
    }
    rig::recording(&name, Store::new(parts.parts), index, Some(&mut files), sources, &limits)
}

/// Reads the recording in an MCAP file, but none of its frames.
pub(super) fn read_file(path: &Path, limits: &Limits) -> Result<Recording, Error> {
    let at = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let file = SharedFile::open(path)
        .map_err(|source| Error::Io { at: path.display().to_string(), source })?;
    let mut left = limits.total_bytes / 2;
    let name = parts::stem(&at);
    let part = parts::part(at, Section::of_file(file), limits, &mut left)?;
    let index = Index::read(std::slice::from_ref(&part), limits)?;
    rig::recording(&name, Store::new(vec![part]), index, None, Sources::default(), limits)
}

#[cfg(test)]
mod tests;
