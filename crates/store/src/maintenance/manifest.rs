//! The file `backup.json`, by which a backup is known as such: a server refuses to start in that folder,
//! and the next backup into it refuses another store.

use std::{fs, io, path::Path};

use jiff::Timestamp;
use serde::{Deserialize, Serialize};

use crate::{Error, Result, database, folder};

/// Version of the form of a backup.
const FORMAT: u32 = 1;

/// Facts of a backup.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Manifest {
    /// Version of its form.
    pub format: u32,
    /// Identity of the store.
    pub store: String,
    /// Name of its database, without a password.
    pub database: String,
    /// The moment whose rows it has; none while the first backup into its folder is under way.
    pub taken: Option<Timestamp>,
    /// Version of the program that made it.
    pub version: String,
}

impl Manifest {
    /// A backup of a store that has just begun.
    pub(super) fn new(store: &str, database: &str) -> Self {
        Self {
            format: FORMAT,
            store: store.to_owned(),
            database: database.to_owned(),
            taken: None,
            version: env!("CARGO_PKG_VERSION").to_owned(),
        }
    }

    /// The manifest of a folder; none if that is no backup.
    ///
    /// # Errors
    /// [`Error::BackupUnreadable`]; file errors.
    pub fn read(folder: &Path) -> Result<Option<Self>> {
        let unreadable =
            |fault: String| Error::BackupUnreadable { folder: folder.to_owned(), fault };
        let text = match fs::read(folder.join(database::BACKUP)) {
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(None),
            text => text?,
        };
        let read: Self = serde_json::from_slice(&text).map_err(|e| unreadable(e.to_string()))?;
        if read.format > FORMAT {
            let fault = format!("its form {} is newer than this program", read.format);
            return Err(unreadable(fault));
        }
        Ok(Some(read))
    }

    pub(super) fn write(&self, folder: &Path) -> Result<()> {
        let text = serde_json::to_vec_pretty(self).map_err(io::Error::other)?;
        Ok(folder::write(&folder.join(database::BACKUP), &text)?)
    }
}
