//! The move of a store's rows from SQLite to an empty PostgreSQL database. Content stays where it
//! is.
//!
//! All rows are copied in one transaction, and read back and compared in it: an interruption leaves
//! the target database as empty as before, and the command is run again. Then a marker in the
//! folder names the new database, and the SQLite file is kept under another name. After an
//! interruption between these last steps the command is run again, too: it finds the rows already
//! copied.

use std::{fs, path::Path, sync::Arc};

use futures::TryStreamExt as _;
use serde::Serialize;
use sqlx::{
    AssertSqlSafe, ColumnIndex, Connection as _, Decode, PgConnection, Row, SqlitePool, Type,
};

use crate::{
    DatabaseUrl, Digest, Error, Result,
    database::{self, migrations, postgres, sqlite},
    folder::{self, disk::Reserve},
    sql::{Builder, Readers, Value, query_scalar},
};

/// Rows of one statement: with the widest table far below the number of values that one may have.
const BATCH: usize = 500;

/// A table, and the columns of its primary key.
#[derive(Clone, Copy, Debug)]
struct Table {
    name: &'static str,
    key: &'static str,
}

/// All tables.
const TABLES: [Table; 23] = [
    Table { name: "arrivals", key: "id, digest" },
    Table { name: "captures", key: "id" },
    Table { name: "deleted_requests", key: "kind, request_id" },
    Table { name: "deletions", key: "digest" },
    Table { name: "jobs", key: "id" },
    Table { name: "keys", key: "id" },
    Table { name: "losses", key: "fit, stage, variant, iteration" },
    Table { name: "masks", key: "capture" },
    Table { name: "observations", key: "capture" },
    Table { name: "playbacks", key: "capture" },
    Table { name: "project_members", key: "project, owner" },
    Table { name: "projects", key: "id" },
    Table { name: "reports", key: "capture" },
    Table { name: "reservations", key: "id" },
    Table { name: "retention_rules", key: "id" },
    Table { name: "servers", key: "id" },
    Table { name: "store", key: "id" },
    Table { name: "supplements", key: "capture, kind" },
    Table { name: "tags", key: "kind, tag, resource" },
    Table { name: "twins", key: "id" },
    Table { name: "upload_parts", key: "upload, number" },
    Table { name: "uploads", key: "id" },
    Table { name: "workers", key: "id" },
];

/// A column, and its type as PostgreSQL names it.
type Column = (String, String);

/// Outcome of a migration.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Migration {
    /// The database, without a password.
    pub database: String,
    /// True if an earlier run had moved all rows.
    pub was_moved: bool,
    /// The tables with their rows.
    pub tables: Vec<MovedTable>,
}

/// A table of both databases.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MovedTable {
    /// Name of the table.
    pub name: String,
    /// Number of rows.
    pub rows: u64,
    /// BLAKE3 of all rows in the order of their keys.
    pub digest: String,
}

/// Moves the rows of a store that no server has open.
///
/// # Errors
/// [`Error::DataDirInUse`]; [`Error::NotFound`] if there is no SQLite database;
/// [`Error::DatabaseNotEmpty`]; [`Error::StoreNewer`]; [`Error::MigrationDiffers`]; database and file errors.
pub async fn migrate(data_dir: &Path, to: &DatabaseUrl) -> Result<Migration> {
    let file = data_dir.join(database::FILE);
    if !file.try_exists()? {
        return Err(Error::NotFound { name: file.display().to_string() });
    }
    let _lock = database::lock(data_dir)?;
    let (writer, readers) = sqlite::open(data_dir, Arc::new(Reserve::open(data_dir))).await?;
    let Readers::Sqlite(source) = readers else {
        return Err(Error::NotFound { name: to.to_string() });
    };
    let moved = match migrations::newer(&Readers::Sqlite(source.clone())).await? {
        // Its columns are not known here, and would be lost.
        Some(migration) => Err(Error::StoreNewer { migration }),
        None => transfer(&source, to).await,
    };
    source.close().await;
    writer.close().await;
    let moved = moved?;
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

/// Moves all rows in one transaction.
async fn transfer(source: &SqlitePool, to: &DatabaseUrl) -> Result<Migration> {
    let mut connection = postgres::connect(&to.options()?).await?;
    postgres::prepare(&mut connection).await?;
    let mut tx = connection.begin().await?;
    sqlx::query("select pg_advisory_xact_lock($1)")
        .bind(postgres::WRITE_LOCK)
        .execute(&mut *tx)
        .await?;
    let identity = "select identity from store";
    let theirs: Option<String> = query_scalar(identity).fetch_optional(&mut *tx).await?;
    let mine: Option<String> =
        query_scalar(identity).fetch_optional(&Readers::Sqlite(source.clone())).await?;
    let was_moved = theirs.is_some() && theirs == mine;
    let mut tables = Vec::new();
    for table in TABLES {
        let columns = columns(&mut tx, table).await?;
        if !was_moved {
            require_empty(&mut tx, table, to).await?;
            copy(source, &mut tx, table, &columns).await?;
        }
        let from = of_sqlite(source, table, &columns).await?;
        if from != of_postgres(&mut tx, table, &columns).await? {
            let (table, database) = (table.name.to_owned(), to.to_string());
            return Err(Error::MigrationDiffers { table, database });
        }
        let (rows, digest) = from;
        let name = table.name.to_owned();
        tables.push(MovedTable { name, rows, digest: digest.to_hex().to_string() });
    }
    // Plans follow statistics, which come by themselves only after a while.
    sqlx::query("analyze").execute(&mut *tx).await?;
    tx.commit().await?;
    connection.close().await?;
    Ok(Migration { database: to.to_string(), was_moved, tables })
}

async fn require_empty(tx: &mut PgConnection, table: Table, to: &DatabaseUrl) -> Result<()> {
    let any = format!("select exists (select 1 from {})", table.name);
    let any: bool = query_scalar(AssertSqlSafe(any)).fetch_one(tx).await?;
    if any { Err(Error::DatabaseNotEmpty { database: to.to_string() }) } else { Ok(()) }
}

/// The columns of a table by name.
async fn columns(tx: &mut PgConnection, table: Table) -> Result<Vec<Column>> {
    let columns = crate::sql::query(
        "select column_name::text, data_type::text from information_schema.columns
         where table_schema = current_schema() and table_name = $1 order by column_name",
    );
    columns.bind(table.name).fetch_all(tx).await
}

/// The statement for all rows of a table in the order of its key.
fn select(table: Table, columns: &[Column]) -> AssertSqlSafe<String> {
    let names: Vec<&str> = columns.iter().map(|(name, _)| name.as_str()).collect();
    let Table { name, key } = table;
    AssertSqlSafe(format!("select {} from {name} order by {key}", names.join(", ")))
}

async fn copy(
    source: &SqlitePool,
    tx: &mut PgConnection,
    table: Table,
    columns: &[Column],
) -> Result<()> {
    let mut rows = sqlx::query(select(table, columns)).fetch(source);
    let mut batch = Vec::with_capacity(BATCH);
    while let Some(row) = rows.try_next().await? {
        batch.push(values(&row, columns)?);
        if batch.len() == BATCH {
            insert(tx, table, columns, std::mem::take(&mut batch)).await?;
        }
    }
    if batch.is_empty() { Ok(()) } else { insert(tx, table, columns, batch).await }
}

async fn insert(
    tx: &mut PgConnection,
    table: Table,
    columns: &[Column],
    rows: Vec<Vec<Value>>,
) -> Result<()> {
    let names: Vec<&str> = columns.iter().map(|(name, _)| name.as_str()).collect();
    let mut sql = Builder::new("insert into ");
    sql.push(table.name).push(" (").push(names.join(", ")).push(") values ");
    for (nth, row) in rows.into_iter().enumerate() {
        sql.push(if nth == 0 { "(" } else { ", (" }).push_list(row).push(")");
    }
    sql.build().execute(tx).await.map(drop)
}

/// Number and digest of the rows of a table.
async fn of_sqlite(source: &SqlitePool, table: Table, columns: &[Column]) -> Result<(u64, Digest)> {
    let mut seen = RowDigest::default();
    let mut rows = sqlx::query(select(table, columns)).fetch(source);
    while let Some(row) = rows.try_next().await? {
        seen.add(&values(&row, columns)?);
    }
    Ok(seen.end())
}

async fn of_postgres(
    tx: &mut PgConnection,
    table: Table,
    columns: &[Column],
) -> Result<(u64, Digest)> {
    let mut seen = RowDigest::default();
    let mut rows = sqlx::query(select(table, columns)).fetch(tx);
    while let Some(row) = rows.try_next().await? {
        seen.add(&values(&row, columns)?);
    }
    Ok(seen.end())
}

/// The values of a row by the types of its columns.
fn values<R: Row>(row: &R, columns: &[Column]) -> sqlx::Result<Vec<Value>>
where
    usize: ColumnIndex<R>,
    for<'r> String: Decode<'r, R::Database> + Type<R::Database>,
    for<'r> i64: Decode<'r, R::Database> + Type<R::Database>,
    for<'r> f64: Decode<'r, R::Database> + Type<R::Database>,
    for<'r> bool: Decode<'r, R::Database> + Type<R::Database>,
{
    let value = |(nth, (_, kind)): (usize, &Column)| {
        Ok(match kind.as_str() {
            "bigint" => Value::Integer(row.try_get(nth)?),
            "double precision" => Value::Real(row.try_get(nth)?),
            "boolean" => Value::Boolean(row.try_get(nth)?),
            _ => Value::Text(row.try_get(nth)?),
        })
    };
    columns.iter().enumerate().map(value).collect()
}

/// Rows that have been seen: their number, and a hash of their values, each with its type and
/// length.
#[derive(Default)]
struct RowDigest {
    rows: u64,
    hash: blake3::Hasher,
}

impl RowDigest {
    fn add(&mut self, row: &[Value]) {
        self.rows += 1;
        for value in row {
            match value {
                Value::Text(Some(text)) => self.bytes(b't', text.as_bytes()),
                Value::Integer(Some(number)) => self.bytes(b'i', &number.to_le_bytes()),
                Value::Real(Some(number)) => self.bytes(b'r', &number.to_bits().to_le_bytes()),
                Value::Boolean(Some(truth)) => self.bytes(b'b', &[u8::from(*truth)]),
                Value::Text(None)
                | Value::Integer(None)
                | Value::Real(None)
                | Value::Boolean(None) => self.bytes(b'n', &[]),
            }
        }
    }

    fn bytes(&mut self, kind: u8, bytes: &[u8]) {
        self.hash.update(&[kind]).update(&(bytes.len() as u64).to_le_bytes()).update(bytes);
    }

    fn end(self) -> (u64, Digest) {
        (self.rows, self.hash.finalize())
    }
}

#[cfg(test)]
mod tests;
