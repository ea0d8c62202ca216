//! Files in the data folder that say what it is: that its database, or its content, is elsewhere, that it
//! is a backup, or that a restore has not ended. Without them a server started without the URL would begin
//! with an empty database beside it, or continue with old data.

use std::{fs, io, path::Path};

use super::DatabaseUrl;
use crate::{Error, ObjectsUrl, Result, folder};

/// Names of the files.
const DATABASE: &str = "postgres";
const OBJECTS: &str = "objects";

/// Name of the file that makes a folder a backup.
pub(crate) const BACKUP: &str = "backup.json";
/// Name of the folder of a restore under way, and of the file in it that says so.
pub(crate) const RESTORING: &str = "restoring";
pub(crate) const RESTORE_STATE: &str = "restore.json";

/// Refuses a folder that is a backup, and one whose restore has not ended.
pub(crate) fn require_settled(data_dir: &Path) -> Result<()> {
    let folder = data_dir.to_owned();
    if data_dir.join(BACKUP).try_exists()? {
        return Err(Error::IsBackup { folder });
    }
    if data_dir.join(RESTORING).join(RESTORE_STATE).try_exists()? {
        return Err(Error::RestoreUnfinished { folder });
    }
    Ok(())
}

/// Refuses SQLite in a folder whose database is elsewhere.
pub(crate) fn require_none(data_dir: &Path) -> Result<()> {
    match read(data_dir, DATABASE)? {
        Some(database) => Err(Error::DatabaseElsewhere { database }),
        None => Ok(()),
    }
}

/// Says where the database of a folder is.
pub(crate) fn leave(data_dir: &Path, url: &DatabaseUrl) -> Result<()> {
    write(data_dir, DATABASE, &url.to_string())
}

/// Refuses content in a folder whose content is elsewhere.
pub(crate) fn require_local_objects(data_dir: &Path, advice: &'static str) -> Result<()> {
    match read(data_dir, OBJECTS)? {
        Some(objects) => Err(Error::ObjectsNotLocal { objects, advice }),
        None => Ok(()),
    }
}

/// Refuses another place of content than that of the folder.
pub(crate) fn require_objects(data_dir: &Path, url: Option<&ObjectsUrl>) -> Result<()> {
    match read(data_dir, OBJECTS)? {
        Some(objects) if url.map(ToString::to_string).as_ref() != Some(&objects) => {
            Err(Error::ObjectsElsewhere { objects })
        }
        _ => Ok(()),
    }
}

/// Says where the content of a folder is.
pub(crate) fn leave_objects(data_dir: &Path, url: &ObjectsUrl) -> Result<()> {
    write(data_dir, OBJECTS, &url.to_string())
}

fn read(data_dir: &Path, file: &str) -> Result<Option<String>> {
    match fs::read_to_string(data_dir.join(file)) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(None),
        read => Ok(Some(read?.trim().to_owned())),
    }
}

fn write(data_dir: &Path, file: &str, url: &str) -> Result<()> {
    let file = data_dir.join(file);
    let text = format!("{url}\n");
    if fs::read_to_string(&file).is_ok_and(|before| before == text) {
        return Ok(());
    }
    fs::write(&file, text)?;
    folder::close_to_others(&file, folder::FILE);
    folder::sync(data_dir)?;
    Ok(())
}
