//! The blobs as files: for the identity of a folder of them, and for check, repair and backup.

use std::{
    fs, io,
    io::Write as _,
    path::{Path, PathBuf},
};

use super::PUBLISHED;
use crate::{Digest, Result, folder};

/// Name of the file with the identity.
const IDENTITY: &str = "identity";

/// Path of a published blob.
pub(crate) fn published(root: &Path, digest: &str) -> PathBuf {
    root.join(PUBLISHED).join(digest.get(..2).unwrap_or("xx")).join(digest)
}

/// Path in one of the folders beside the published blobs.
pub(crate) fn beside(root: &Path, folder: &str, digest: &str) -> PathBuf {
    root.join(folder).join(digest)
}

/// The identity of the database that a folder's content belongs to.
pub(crate) fn identity(root: &Path) -> Result<Option<String>> {
    match fs::read_to_string(root.join(IDENTITY)) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(None),
        read => Ok(Some(read?.trim().to_owned())),
    }
}

/// Gives a folder's content an identity: whole or not at all, since half of one would be another.
pub(crate) fn set_identity(root: &Path, identity: &str) -> Result<()> {
    folder::make(root)?;
    let partial = root.join("identity.partial");
    let mut file = fs::File::create(&partial)?;
    writeln!(file, "{identity}")?;
    file.sync_all()?;
    fs::rename(partial, root.join(IDENTITY))?;
    folder::sync(root)?;
    Ok(())
}

/// True if a file has the content of this digest.
pub(crate) fn is_content(file: &Path, digest: &str) -> io::Result<bool> {
    let mut hasher = blake3::Hasher::new();
    hasher.update_reader(fs::File::open(file)?)?;
    Ok(Digest::from_hex(digest).is_ok_and(|wanted| wanted == hasher.finalize()))
}

/// All published blobs by digest, with their sizes [bytes].
pub(crate) fn all(root: &Path) -> io::Result<Vec<(String, u64)>> {
    let mut blobs = Vec::new();
    for folder in folders(root)? {
        for (file, size_bytes) in list(&folder)? {
            let name = file.file_name().map(|name| name.to_string_lossy().into_owned());
            blobs.extend(name.map(|name| (name, size_bytes)));
        }
    }
    blobs.sort();
    Ok(blobs)
}

/// True if there is a published blob.
pub(crate) fn any(root: &Path) -> io::Result<bool> {
    for folder in folders(root)? {
        if !list(&folder)?.is_empty() {
            return Ok(true);
        }
    }
    Ok(false)
}

/// The files of a folder with their sizes [bytes]; none if there is no such folder.
pub(crate) fn list(folder: &Path) -> io::Result<Vec<(PathBuf, u64)>> {
    let mut files = Vec::new();
    for entry in entries(folder)? {
        // A file removed in the meantime does not count.
        if let Ok(found) = entry.metadata()
            && found.is_file()
        {
            files.push((entry.path(), found.len()));
        }
    }
    Ok(files)
}

/// The folders of published blobs.
pub(crate) fn folders(root: &Path) -> io::Result<Vec<PathBuf>> {
    let entries = entries(&root.join(PUBLISHED))?.into_iter();
    Ok(entries.map(|entry| entry.path()).filter(|path| path.is_dir()).collect())
}

fn entries(folder: &Path) -> io::Result<Vec<fs::DirEntry>> {
    match fs::read_dir(folder) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(Vec::new()),
        entries => entries?.collect(),
    }
}
