//! The folder that a suite fills:
//!
//! - `runs/CAPTURE/CONFIGURATION/SEED.json`: a [`Record`] each;
//! - `twins/CAPTURE/CONFIGURATION/SEED.twin`: the twins themselves;
//! - `checkpoints/`: fits under way, by the same names;
//! - `table.md`, `table.json`, `figure.png`, `pictures/`.
//!
//! Every file appears whole or not at all, and one process at a time works in the folder.

use std::{
    fs::{self, File, TryLockError},
    io::Write as _,
    path::{Path, PathBuf},
};

use crate::{
    Error,
    record::{Record, VERSION},
    suite::RunId,
};

/// A suite's folder, held by this process.
#[derive(Debug)]
pub struct Folder {
    root: PathBuf,
    /// Lock, held while the folder is open.
    _lock: File,
}

impl Folder {
    /// Makes the folder if it does not exist, and holds it.
    ///
    /// # Errors
    /// If it cannot be made, or another process holds it.
    pub fn open(root: &Path) -> Result<Self, Error> {
        fs::create_dir_all(root).map_err(Error::file(root))?;
        let path = root.join("lock");
        let lock = File::create(&path).map_err(Error::file(&path))?;
        match lock.try_lock() {
            Ok(()) => Ok(Self { root: root.to_owned(), _lock: lock }),
            Err(TryLockError::WouldBlock) => Err(Error::Busy(root.to_owned())),
            Err(TryLockError::Error(e)) => Err(Error::file(&path)(e)),
        }
    }

    /// Path of the folder.
    pub fn root(&self) -> &Path {
        &self.root
    }

    /// The record of a run; `None` without one that this build can read.
    pub fn record(&self, id: &RunId) -> Option<Record> {
        let bytes = fs::read(self.root.join(record_path(id))).ok()?;
        let record: Record = serde_json::from_slice(&bytes).ok()?;
        (record.version == VERSION && record.run == *id).then_some(record)
    }

    pub(crate) fn write_record(&self, record: &Record) -> Result<(), Error> {
        let mut json =
            serde_json::to_vec_pretty(record).map_err(|e| Error::Writing(e.to_string()))?;
        json.push(b'\n');
        self.write(&record_path(&record.run), &json)
    }

    /// The file of a run's twin.
    pub fn twin_path(&self, id: &RunId) -> PathBuf {
        self.root.join(twin_name(id))
    }

    pub(crate) fn write_twin(&self, id: &RunId, twin: &[u8]) -> Result<(), Error> {
        self.write(&twin_name(id), twin)
    }

    pub(crate) fn checkpoint(&self, id: &RunId) -> Option<Vec<u8>> {
        fs::read(self.root.join(checkpoint_name(id))).ok()
    }

    pub(crate) fn write_checkpoint(&self, id: &RunId, bytes: &[u8]) -> Result<(), Error> {
        self.write(&checkpoint_name(id), bytes)
    }

    /// Removes files that are no longer of use; a failure to remove them does no harm.
    pub(crate) fn remove_checkpoint(&self, id: &RunId) {
        let _ = fs::remove_file(self.root.join(checkpoint_name(id)));
    }

    /// Writes a file of the folder, whole or not at all.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn write(&self, name: &str, bytes: &[u8]) -> Result<(), Error> {
        let path = self.root.join(name);
        if let Some(folder) = path.parent() {
            fs::create_dir_all(folder).map_err(Error::file(folder))?;
        }
        let mut partial = path.clone().into_os_string();
        partial.push(".partial");
        let partial = PathBuf::from(partial);
        let write = || {
            let mut file = File::create(&partial)?;
            file.write_all(bytes)?;
            file.sync_all()?;
            fs::rename(&partial, &path)
        };
        write().map_err(Error::file(&path))
    }
}

/// The name of a run's record in the folder.
pub(crate) fn record_path(id: &RunId) -> String {
    format!("runs/{id}.json")
}

fn twin_name(id: &RunId) -> String {
    format!("twins/{id}.twin")
}

fn checkpoint_name(id: &RunId) -> String {
    format!("checkpoints/{id}.checkpoint")
}
