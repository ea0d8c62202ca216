//! MCAP: what robots record. Images, calibrations and transforms of ROS 1, ROS 2 (CDR) and
//! Foxglove's protobuf messages.
//!
//! A single pass over the file finds where every image lies; after that images are read one by one,
//! so that memory stays flat for files of any length. The topics of a camera are found in [`rig`].

mod chunk;
mod frames;
mod images;
mod index;
mod messages;
mod place;
mod protobuf;
mod record;
mod rig;
mod ros;
mod transforms;

use std::path::{Path, PathBuf};

use ::mcap::MAGIC;

use self::{index::Index, place::Store};
use super::Recording;
use crate::{Error, Limits, files::SharedFile};

/// The MCAP file at a path: the file itself, or the only one in a folder, as `ros2 bag record`
/// leaves it.
pub(super) fn file_at(path: &Path) -> Result<Option<PathBuf>, Error> {
    let is_mcap = |path: &Path| {
        let mut start = [0; MAGIC.len()];
        SharedFile::open(path).is_ok_and(|f| f.read_exact_at(&mut start, 0).is_ok())
            && start == MAGIC
    };
    if path.is_file() {
        return Ok(is_mcap(path).then(|| path.to_owned()));
    }
    let Ok(entries) = std::fs::read_dir(path) else { return Ok(None) };
    let mut found: Vec<PathBuf> = entries
        .take(1000)
        .filter_map(|entry| Some(entry.ok()?.path()))
        .filter(|path| path.extension().is_some_and(|e| e.eq_ignore_ascii_case("mcap")))
        .filter(|path| path.is_file() && is_mcap(path))
        .collect();
    found.sort();
    if found.len() > 1 {
        let names: Vec<String> = found
            .iter()
            .take(5)
            .filter_map(|p| Some(p.file_name()?.display().to_string()))
            .collect();
        return Err(Error::Several(names.join(", ")));
    }
    Ok(found.pop())
}

/// Reads the recording in an MCAP file, but none of its frames.
pub(super) fn read(path: &Path, limits: &Limits) -> Result<Recording, Error> {
    let at = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let file = SharedFile::open(path)
        .map_err(|source| Error::Io { at: path.display().to_string(), source })?;
    let mut store = Store::new(at, file);
    let index = Index::read(&mut store, limits)?;
    let name = path.file_stem().unwrap_or_default().to_string_lossy();
    rig::recording(&name, store, index, limits)
}

#[cfg(test)]
mod tests;
