//! Folders and files that only the user of the server may read: captures and twins are private, and
//! other users may have accounts on the same machine.

pub(crate) mod disk;

use std::{fs, io, path::Path};

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
