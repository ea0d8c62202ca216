//! Faults of the database file itself.

use std::path::Path;

use sqlx::{
    ConnectOptions as _, SqliteConnection,
    sqlite::{SqliteConnectOptions, SqliteRow},
};

use crate::{Error, Result, database};

/// Most faults that are listed.
const MOST_FAULTS: &str = "pragma integrity_check(100)";

/// A connection that only reads, as the file is: beside a server, too.
pub(super) async fn read_only(data_dir: &Path) -> Result<SqliteConnection> {
    open(&data_dir.join(database::FILE)).await
}

/// [`read_only`] for a database of any name.
pub(super) async fn open(file: &Path) -> Result<SqliteConnection> {
    if !file.try_exists()? {
        return Err(Error::NotFound { name: file.display().to_string() });
    }
    Ok(SqliteConnectOptions::new().filename(file).read_only(true).connect().await?)
}

/// Faults of the pages, tables and indexes; none if all is well.
pub(super) async fn faults(connection: &mut SqliteConnection) -> Result<Vec<String>> {
    let found: Result<Vec<String>, sqlx::Error> =
        sqlx::query_scalar(MOST_FAULTS).fetch_all(connection).await;
    match found.map_err(Error::from) {
        Ok(lines) => Ok(lines.into_iter().filter(|line| line != "ok").collect()),
        Err(Error::DatabaseDamaged { fault }) => Ok(vec![fault]),
        Err(error) => Err(error),
    }
}

/// The identity in a database, which those from before there were identities lack.
pub(super) async fn identity(connection: &mut SqliteConnection) -> Result<Option<String>> {
    let table: Option<SqliteRow> =
        sqlx::query("select 1 from sqlite_master where type = 'table' and name = 'store'")
            .fetch_optional(&mut *connection)
            .await?;
    if table.is_none() {
        return Ok(None);
    }
    let identity = sqlx::query_scalar("select identity from store where id = 1");
    Ok(identity.fetch_optional(connection).await?)
}
