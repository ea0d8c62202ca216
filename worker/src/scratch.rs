//! The folder in which a worker keeps captures while it reads them. It is removed when the process
//! ends; what a killed process left is removed when the next one starts.
//!
//! The base may be a folder that others write to, such as the system's temporary one. An entry there
//! under this worker's name is believed only if it is this user's, and nothing of others is opened
//! in a way that could wait for them.

use std::{
    fs::{DirBuilder, File, OpenOptions, Permissions, TryLockError},
    io,
    os::unix::fs::{
        DirBuilderExt as _, MetadataExt as _, OpenOptionsExt as _, PermissionsExt as _,
    },
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
        // A folder that exists already keeps its mode; the one inside is private in any case.
        DirBuilder::new().recursive(true).mode(0o700).create(base)?;
        let base = base.canonicalize()?;
        let private = Permissions::from_mode(0o700);
        let folder =
            tempfile::Builder::new().prefix(PREFIX).permissions(private).tempdir_in(&base)?;
        // The lock appears under its name when it is held already: a sweep in between finds none.
        let made = folder.path().join("lock.new");
        let lock = File::create_new(&made)?;
        lock.lock()?;
        std::fs::rename(made, folder.path().join(LOCK))?;
        sweep(&base, lock.metadata()?.uid())?;
        Ok(Self { folder, _lock: lock })
    }

    /// Path of the folder.
    pub(crate) fn path(&self) -> &Path {
        self.folder.path()
    }
}

/// Removes folders of this `user` whose processes are gone.
fn sweep(base: &Path, user: u32) -> io::Result<()> {
    for entry in std::fs::read_dir(base)? {
        let path = entry?.path();
        let name = path.file_name().unwrap_or_default();
        if !name.to_string_lossy().starts_with(PREFIX) {
            continue;
        }
        // Another user's, or one that its process is removing: not ours to care about.
        let Some(lock) = own_lock(&path, user) else { continue };
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

/// The lock of a folder, if folder and lock are what this user's worker makes: a folder, and in it
/// a file. Anybody may put a pipe or a link under such a name.
fn own_lock(folder: &Path, user: u32) -> Option<File> {
    let metadata = std::fs::symlink_metadata(folder).ok()?;
    if !metadata.is_dir() || metadata.uid() != user {
        return None;
    }
    let mut options = OpenOptions::new();
    // To open a pipe would wait for its other end.
    options.read(true).custom_flags(libc::O_NOFOLLOW | libc::O_NONBLOCK);
    let lock = options.open(folder.join(LOCK)).ok()?;
    let metadata = lock.metadata().ok()?;
    (metadata.is_file() && metadata.uid() == user).then_some(lock)
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

    #[test]
    fn pipes_and_links_under_a_workers_name_block_nothing() {
        let base = tempfile::tempdir().unwrap();
        let pipe = base.path().join("bendtwin-worker-pipe");
        std::fs::create_dir(&pipe).unwrap();
        nix::unistd::mkfifo(&pipe.join(LOCK), nix::sys::stat::Mode::S_IRWXU).unwrap();
        let elsewhere = tempfile::tempdir().unwrap();
        std::fs::write(elsewhere.path().join(LOCK), "").unwrap();
        let link = base.path().join("bendtwin-worker-link");
        std::os::unix::fs::symlink(elsewhere.path(), &link).unwrap();
        let inner = base.path().join("bendtwin-worker-inner");
        std::fs::create_dir(&inner).unwrap();
        std::os::unix::fs::symlink(elsewhere.path().join(LOCK), inner.join(LOCK)).unwrap();

        let (done, waits) = std::sync::mpsc::channel();
        let at = base.path().to_owned();
        std::thread::spawn(move || done.send(Scratch::new(&at).map(drop)));
        let made = waits.recv_timeout(std::time::Duration::from_secs(20));
        made.expect("a pipe holds the worker up").unwrap();
        assert!(pipe.exists() && link.exists() && inner.exists());
        assert!(elsewhere.path().join(LOCK).exists());
    }

    #[test]
    fn folders_are_private() {
        let base = tempfile::tempdir().unwrap();
        let made = base.path().join("made");
        let scratch = Scratch::new(&made).unwrap();
        for folder in [made.as_path(), scratch.path()] {
            assert_eq!(std::fs::metadata(folder).unwrap().mode() & 0o777, 0o700);
        }
        let user = std::fs::metadata(&made).unwrap().uid();
        assert!(own_lock(scratch.path(), user).is_some());
        assert!(own_lock(scratch.path(), user + 1).is_none(), "it is another user's");
    }
}
