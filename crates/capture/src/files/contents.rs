//! The files of a folder that are read, out of all that lie there: those that an upload needs.

use std::{collections::BTreeSet, ffi::OsStr, path::Path};

use crate::{
    Error, Limits, Opened,
    files::Files,
    format::{Format, Place},
    mocap, read,
};

/// The capture in a folder, and the files that it is read from.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FilesRead {
    /// A person's name for the capture: that of its folder.
    pub name: String,
    /// The capture's own folder, relative to the given one, `/` between parts and at the end; empty
    /// if that is it.
    pub folder: String,
    /// The format as which it is read, in words.
    pub format: &'static str,
    /// Names of the files, relative to [`FilesRead::folder`], in their order.
    pub files: Vec<String>,
}

/// Asks the reader which files of a folder it reads, by opening the capture. Frames of a raw
/// recording are not read for that.
///
/// # Errors
/// Those of [`crate::open`].
pub fn files_read(path: &Path, limits: &Limits) -> Result<FilesRead, Error> {
    let mut files = match Place::at(path) {
        Place::Mcap(file) => {
            let name = |part: Option<&OsStr>| part.unwrap_or_default().to_string_lossy().into();
            return Ok(FilesRead {
                name: name(file.file_stem()),
                folder: String::new(),
                format: Format::Mcap.words(),
                files: vec![name(file.file_name())],
            });
        }
        Place::Markers(path) => return Ok(mocap::files_of_markers(path)),
        Place::Arrays(path) | Place::Files(path) => Files::open(path, limits)?,
    };
    files.keep_names();
    let mut names = frames_of(&read::open_files(&mut files)?);
    names.extend(files.names_read());
    let own = |name: &String| name.strip_prefix(files.prefix()).map(str::to_owned);
    Ok(FilesRead {
        name: files.name.clone(),
        folder: files.prefix().to_owned(),
        format: Format::detect(&files.list("")).map(Format::words).unwrap_or_default(),
        files: names.iter().filter_map(own).collect(),
    })
}

/// Names of the files with frames.
fn frames_of(opened: &Opened) -> BTreeSet<String> {
    match opened {
        Opened::Observed(..) => BTreeSet::new(),
        Opened::Raw(recording) => recording.source.files().into_iter().collect(),
        Opened::Several(parts) => parts.iter().flat_map(|part| frames_of(&part.opened)).collect(),
    }
}

#[cfg(test)]
mod tests;
