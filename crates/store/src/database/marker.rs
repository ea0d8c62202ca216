//! A file in the data folder that says that its database is elsewhere. Without it a server that is
//! started without the URL would begin a new database beside the content, or go on with an old one.

use std::{fs, io, path::Path};

use super::DatabaseUrl;
use crate::{Error, Result, folder};

/// Name of the file.
const FILE: &str = "postgres";

/// Refuses SQLite in a folder whose database is elsewhere.
pub(crate) fn require_none(data_dir: &Path) -> Result<()> {
    match fs::read_to_string(data_dir.join(FILE)) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(()),
        read => Err(Error::DatabaseElsewhere { database: read?.trim().to_owned() }),
    }
}

/// Says where the database of a folder is.
pub(crate) fn leave(data_dir: &Path, url: &DatabaseUrl) -> Result<()> {
    let file = data_dir.join(FILE);
    let text = format!("{url}\n");
    if fs::read_to_string(&file).is_ok_and(|before| before == text) {
        return Ok(());
    }
    fs::write(&file, text)?;
    folder::close_to_others(&file, folder::FILE);
    folder::sync(data_dir)?;
    Ok(())
}
