//! The move of a store's rows from SQLite to an empty PostgreSQL database. Content stays where it
//! is.
//!
//! All rows are copied in one transaction, and read back and compared in it: an interruption leaves
//! the target database as empty as before, and the command is run again. Then a marker in the
//! folder names the new database, and the SQLite file is kept under another name. After an
//! interruption between these last steps the command is run again, too: it finds the rows already
//! copied.

use std::{fs, path::Path, sync::Arc};

use serde::Serialize;

use super::rows::{self, Connection, CopiedTable};
use crate::{
    DatabaseUrl, Error, Result,
    database::{self, postgres, sqlite},
    folder::{self, disk::Reserve},
    sql::{Readers, query},
};

/// Outcome of a migration.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Migration {
    /// The database, without a password.
    pub database: String,
    /// True if an earlier run had moved all rows.
    pub was_moved: bool,
    /// The tables with their rows.
    pub tables: Vec<CopiedTable>,
}

/// Moves the rows of a store that no server has open.
///
/// # Errors
/// [`Error::DataDirInUse`]; [`Error::NotFound`] if there is no SQLite database;
/// [`Error::DatabaseNotEmpty`]; [`Error::StoreNewer`]; [`Error::MigrationDiffers`]; database and file errors.
pub async fn migrate(data_dir: &Path, to: &DatabaseUrl) -> Result<Migration> {
    let file = data_dir.join(database::FILE);
    database::require_settled(data_dir)?;
    if !file.try_exists()? {
        return Err(Error::NotFound { name: file.display().to_string() });
    }
    let _lock = database::lock(data_dir)?;
    // Brings its tables up to date.
    let (writer, readers) = sqlite::open(data_dir, Arc::new(Reserve::open(data_dir))).await?;
    if let Readers::Sqlite(readers) = readers {
        readers.close().await;
    }
    writer.close().await;
    let mut source = Connection::sqlite(&file).await?;
    rows::require_current(&mut source).await?;
    let mut connection = postgres::connect(&to.options()?).await?;
    postgres::prepare(&mut connection).await?;
    let mut target = Connection::Postgres(connection);
    let moved = transfer(&mut source, &mut target, &to.to_string()).await?;
    target.close().await?;
    source.close().await?;
    database::leave_marker(data_dir, to)?;
    for suffix in ["-wal", "-shm", ""] {
        let name = |base: &str| data_dir.join(format!("{base}{suffix}"));
        let renamed =
            fs::rename(name(database::FILE), name(&format!("{}.migrated", database::FILE)));
        match renamed {
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => {}
            renamed => renamed?,
        }
    }
    folder::sync(data_dir)?;
    Ok(moved)
}

/// Copies all rows in one transaction to an empty database, or finds them copied there.
pub(super) async fn transfer(
    source: &mut Connection,
    target: &mut Connection,
    database: &str,
) -> Result<Migration> {
    let tables = rows::tables().await?;
    target.begin_writing().await?;
    let theirs = target.identity().await?;
    let was_moved = theirs.is_some() && theirs == source.identity().await?;
    if !was_moved && !target.is_empty(&tables).await? {
        return Err(Error::DatabaseNotEmpty { database: database.to_owned() });
    }
    let mut copied = Vec::new();
    for table in &tables {
        copied.push(match was_moved {
            false => rows::copy(source, target, table, database).await?,
            true => rows::compare(source, target, table, database).await?,
        });
    }
    // Plans follow statistics, which come by themselves only after a while.
    query("analyze").execute(target.target()).await?;
    target.commit().await?;
    Ok(Migration { database: database.to_owned(), was_moved, tables: copied })
}

#[cfg(test)]
mod tests;
