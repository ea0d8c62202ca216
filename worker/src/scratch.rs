//! The folder in which a worker keeps captures while it reads them. It is removed when the process
//! ends; what a killed process left is removed when the next one starts.

use std::{
    fs::{File, TryLockError},
    io,
    path::Path,
};

use tempfile::TempDir;

const PREFIX: &str = "bendtwin-worker-";
/// Lock file, held as long as the folder's process lives; the system releases it however that ends.
const LOCK: &str = "lock";

/// A worker's own folder.
pub(crate) struct Scratch {
    folder: TempDir,
    /// Held, not read.
    _lock: File,
}

impl Scratch {
    /// Makes a folder in `base`, which is made too, and removes those of processes that are gone.
    pub(crate) fn new(base: &Path) -> io::Result<Self> {
        std::fs::create_dir_all(base)?;
        sweep(base)?;
        let folder = tempfile::Builder::new().prefix(PREFIX).tempdir_in(base)?;
        // The lock appears under its name when it is held already: a sweep in between finds none.
        let made = folder.path().join("lock.new");
        let lock = File::create_new(&made)?;
        lock.lock()?;
        std::fs::rename(made, folder.path().join(LOCK))?;
        Ok(Self { folder, _lock: lock })
    }

    /// Path of the folder.
    pub(crate) fn path(&self) -> &Path {
        self.folder.path()
    }
}

fn sweep(base: &Path) -> io::Result<()> {
    for entry in std::fs::read_dir(base)? {
        let path = entry?.path();
        let name = path.file_name().unwrap_or_default();
        if !name.to_string_lossy().starts_with(PREFIX) {
            continue;
        }
        // Another user's, or one that its process is removing: not ours to care about.
        let Ok(lock) = File::open(path.join(LOCK)) else { continue };
        match lock.try_lock() {
            Ok(()) => {
                tracing::info!(path = %path.display(), "removing what a killed worker left");
                if let Err(error) = std::fs::remove_dir_all(&path) {
                    tracing::warn!(path = %path.display(), "cannot remove it: {error}");
                }
            }
            Err(TryLockError::WouldBlock) => {}
            Err(TryLockError::Error(error)) => {
                tracing::debug!(path = %path.display(), "cannot find out whether this folder is in use: {error}");
            }
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_used_stays_and_what_a_killed_process_left_goes() {
        let base = tempfile::tempdir().unwrap();
        let alive = Scratch::new(base.path()).unwrap();
        let content = alive.path().join("capture.zip");
        std::fs::write(&content, "x").unwrap();
        // A killed process removes nothing, but its lock is gone.
        let killed = base.path().join("bendtwin-worker-killed");
        std::fs::create_dir(&killed).unwrap();
        std::fs::write(killed.join(LOCK), "").unwrap();
        std::fs::write(killed.join("capture.zip"), "x").unwrap();
        let unrelated = base.path().join("else");
        std::fs::create_dir(&unrelated).unwrap();

        let other = Scratch::new(base.path()).unwrap();
        assert!(content.exists() && unrelated.exists() && !killed.exists());
        drop(other);
        drop(alive);
        assert!(!content.exists());
    }
}
