//! The files of a folder that are read, out of all that lie there: those that an upload needs.

use std::{collections::BTreeSet, path::Path};

use crate::{Error, Limits, Opened, files::Files, raw, read};

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
    let path = read::root(path);
    if let Some(file) = raw::mcap_at(path)? {
        fn name(of: Option<&std::ffi::OsStr>) -> String {
            of.unwrap_or_default().to_string_lossy().into_owned()
        }
        return Ok(FilesRead {
            name: name(file.file_stem()),
            folder: String::new(),
            format: "an MCAP file",
            files: vec![name(file.file_name())],
        });
    }
    let mut files = Files::open(path, limits)?;
    files.keep_names();
    let mut names = frames_of(&read::open_files(&mut files)?);
    names.extend(files.names_read());
    let own = |name: &String| name.strip_prefix(files.prefix()).map(str::to_owned);
    Ok(FilesRead {
        name: files.name.clone(),
        folder: files.prefix().to_owned(),
        format: read::formats(&files.list("")).next().unwrap_or_default(),
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
