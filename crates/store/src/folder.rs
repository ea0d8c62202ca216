//! Folders and files that only the user of the server may read: captures and twins are private, and
//! other users may have accounts on the same machine.

pub(crate) mod disk;

use std::{fs, io, io::Write as _, path::Path};

/// Permissions of a file.
pub(crate) const FILE: u32 = 0o600;
/// Permissions of a folder.
pub(crate) const FOLDER: u32 = 0o700;

/// Creates a folder that only its owner can read, with its parents. An existing folder is left
/// unchanged.
pub(crate) fn make(path: &Path) -> io::Result<()> {
    let mut builder = fs::DirBuilder::new();
    builder.recursive(true);
    #[cfg(unix)]
    std::os::unix::fs::DirBuilderExt::mode(&mut builder, FOLDER);
    builder.create(path)
}

/// Creates a file that only its owner can read, in place of one of that name.
pub(crate) fn create(path: &Path) -> io::Result<fs::File> {
    let mut options = fs::OpenOptions::new();
    options.write(true).create(true).truncate(true);
    #[cfg(unix)]
    std::os::unix::fs::OpenOptionsExt::mode(&mut options, FILE);
    let file = options.open(path)?;
    close_to_others(path, FILE);
    Ok(file)
}

/// Writes a file that only its owner can read: whole and durably, or not at all.
pub(crate) fn write(path: &Path, content: &[u8]) -> io::Result<()> {
    let partial = path.with_extension("partial");
    let mut file = create(&partial)?;
    file.write_all(content)?;
    file.sync_all()?;
    fs::rename(&partial, path)?;
    path.parent().map_or(Ok(()), sync)
}

/// Takes the permissions of others away from a file or a folder that the store made.
pub(crate) fn close_to_others(path: &Path, mode: u32) {
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        let closed = fs::metadata(path).and_then(|found| {
            let open = found.permissions().mode() & 0o777 & !mode != 0;
            if open { fs::set_permissions(path, PermissionsExt::from_mode(mode)) } else { Ok(()) }
        });
        if let Err(error) = closed {
            tracing::warn!(%error, path = %path.display(), "other users may read this");
        }
    }
    #[cfg(not(unix))]
    let _ = (path, mode);
}

/// Syncs the names in a folder.
pub(crate) fn sync(path: &Path) -> io::Result<()> {
    fs::File::open(path)?.sync_all()
}
