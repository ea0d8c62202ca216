//! All rows of a store, copied from one database to another and compared on both sides.
//!
//! The tables are those that the migrations make: they are read from an empty database, so that a new
//! table or column is copied without being named here.

use std::path::Path;

use futures::{StreamExt as _, TryStreamExt as _, stream::BoxStream};
use serde::Serialize;
use sqlx::{
    AssertSqlSafe, ColumnIndex, ConnectOptions as _, Connection as _, Decode, PgConnection,
    Row as SqlxRow, SqliteConnection, Type, sqlite::SqliteConnectOptions,
};

use crate::{
    Digest, Error, Result,
    database::{self, migrations, postgres},
    sql::{Builder, Target, Value, query, query_scalar},
};

/// Most rows of one statement.
const BATCH: usize = 500;
/// Most values of one statement: SQLite takes 32,766.
const MOST_VALUES: usize = 30_000;

/// A table of the store.
#[derive(Clone, Debug)]
pub(super) struct Table {
    pub(super) name: String,
    columns: Vec<Column>,
    /// Columns of its primary key, in their order.
    key: Vec<String>,
}

/// A column, and the type of its values.
#[derive(Clone, Debug)]
struct Column {
    name: String,
    kind: Kind,
}

#[derive(Clone, Copy, Debug)]
enum Kind {
    Text,
    Integer,
    Real,
    Boolean,
}

/// A table that was copied.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CopiedTable {
    /// Name of the table.
    pub name: String,
    /// Number of rows.
    pub rows: u64,
    /// BLAKE3 of all rows in the order of their keys.
    pub digest: String,
}

/// A connection to either database, on which this module begins and ends transactions.
#[derive(Debug)]
pub(super) enum Connection {
    Sqlite(SqliteConnection),
    Postgres(PgConnection),
}

impl<'c> From<&'c mut Connection> for Target<'c> {
    fn from(connection: &'c mut Connection) -> Self {
        connection.target()
    }
}

/// The tables that this version of the program has.
pub(super) async fn tables() -> Result<Vec<Table>> {
    let mut memory = SqliteConnectOptions::new().in_memory(true).connect().await?;
    migrations::sqlite().run(&mut memory).await?;
    let names: Vec<String> = query_scalar(
        "select name from sqlite_master where type = 'table' and name not like '\\_sqlx%' escape '\\'
             and name not like 'sqlite\\_%' escape '\\' order by name",
    )
    .fetch_all(&mut memory)
    .await?;
    let mut tables = Vec::new();
    for name in names {
        let columns: Vec<(String, String, i64)> =
            query("select name, lower(type), pk from pragma_table_info($1) order by name")
                .bind(&name)
                .fetch_all(&mut memory)
                .await?;
        let mut key: Vec<(i64, String)> = columns
            .iter()
            .filter(|(.., place)| *place > 0)
            .map(|(column, _, place)| (*place, column.clone()))
            .collect();
        key.sort();
        let key = key.into_iter().map(|(_, column)| column).collect();
        let columns = columns.into_iter().map(|(name, kind, _)| Column::new(name, &kind)).collect();
        tables.push(Table { name, columns, key });
    }
    memory.close().await?;
    Ok(tables)
}

impl Column {
    fn new(name: String, declared: &str) -> Self {
        let kind = match declared {
            "bigint" => Kind::Integer,
            "double precision" => Kind::Real,
            "boolean" => Kind::Boolean,
            // The only other type of this schema; a test holds migrations to that.
            _ => Kind::Text,
        };
        Self { name, kind }
    }
}

impl Table {
    fn names(&self) -> String {
        let names: Vec<&str> = self.columns.iter().map(|column| column.name.as_str()).collect();
        names.join(", ")
    }

    /// The statement for all rows in the order of the key.
    fn select(&self) -> AssertSqlSafe<String> {
        let (names, table, key) = (self.names(), &self.name, self.key.join(", "));
        AssertSqlSafe(format!("select {names} from {table} order by {key}"))
    }

    /// The values of a row.
    fn values<R: SqlxRow>(&self, row: &R) -> sqlx::Result<Vec<Value>>
    where
        usize: ColumnIndex<R>,
        for<'r> String: Decode<'r, R::Database> + Type<R::Database>,
        for<'r> i64: Decode<'r, R::Database> + Type<R::Database>,
        for<'r> f64: Decode<'r, R::Database> + Type<R::Database>,
        for<'r> bool: Decode<'r, R::Database> + Type<R::Database>,
    {
        let value = |(nth, column): (usize, &Column)| {
            Ok(match column.kind {
                Kind::Integer => Value::Integer(row.try_get(nth)?),
                Kind::Real => Value::Real(row.try_get(nth)?),
                Kind::Boolean => Value::Boolean(row.try_get(nth)?),
                Kind::Text => Value::Text(row.try_get(nth)?),
            })
        };
        self.columns.iter().enumerate().map(value).collect()
    }
}

impl Connection {
    /// Connects to a SQLite database that exists.
    pub(super) async fn sqlite(file: &Path) -> Result<Self> {
        let options = database::options(file).create_if_missing(false);
        Ok(Self::Sqlite(options.connect().await?))
    }

    /// The place in which statements run.
    pub(super) fn target(&mut self) -> Target<'_> {
        match self {
            Self::Sqlite(connection) => connection.into(),
            Self::Postgres(connection) => connection.into(),
        }
    }

    /// Begins a transaction that excludes all others that write, whichever process they belong to.
    pub(super) async fn begin_writing(&mut self) -> Result<()> {
        match self {
            Self::Sqlite(connection) => {
                query("begin immediate").execute(connection).await?;
            }
            Self::Postgres(connection) => {
                query("begin").execute(&mut *connection).await?;
                let lock = query_scalar("select pg_advisory_xact_lock($1)::text");
                let _: Option<String> =
                    lock.bind(postgres::WRITE_LOCK).fetch_one(connection).await?;
            }
        }
        Ok(())
    }

    /// Begins a transaction that reads the database at this moment, unaffected by later writes.
    pub(super) async fn begin_reading(&mut self) -> Result<()> {
        let begin = match self {
            Self::Sqlite(_) => "begin",
            Self::Postgres(_) => "begin transaction isolation level repeatable read read only",
        };
        query(begin).execute(self.target()).await?;
        // The first statement that reads settles what is seen.
        query("select 1 from store").execute(self.target()).await?;
        Ok(())
    }

    /// Makes the changes of the transaction last.
    pub(super) async fn commit(&mut self) -> Result<()> {
        query("commit").execute(self.target()).await.map(drop)
    }

    pub(super) async fn close(self) -> Result<()> {
        match self {
            Self::Sqlite(connection) => connection.close().await?,
            Self::Postgres(connection) => connection.close().await?,
        }
        Ok(())
    }

    /// The identity of the store, if the database has one.
    pub(super) async fn identity(&mut self) -> Result<Option<String>> {
        query_scalar("select identity from store where id = 1").fetch_optional(self.target()).await
    }

    /// True if no table has a row.
    pub(super) async fn is_empty(&mut self, tables: &[Table]) -> Result<bool> {
        for table in tables {
            let any = AssertSqlSafe(format!("select exists (select 1 from {})", table.name));
            if query_scalar(any).fetch_one(self.target()).await? {
                return Ok(false);
            }
        }
        Ok(true)
    }

    /// All rows of a table in the order of its key.
    fn rows<'c>(&'c mut self, table: &'c Table) -> BoxStream<'c, Result<Vec<Value>>> {
        match self {
            Self::Sqlite(connection) => {
                let rows = sqlx::query(table.select()).fetch(connection);
                rows.map(|row| Ok(table.values(&row?)?)).boxed()
            }
            Self::Postgres(connection) => {
                let rows = sqlx::query(table.select()).fetch(connection);
                rows.map(|row| Ok(table.values(&row?)?)).boxed()
            }
        }
    }

    async fn insert(&mut self, table: &Table, rows: Vec<Vec<Value>>) -> Result<()> {
        if rows.is_empty() {
            return Ok(());
        }
        let mut sql = Builder::new("insert into ");
        sql.push(&table.name).push(" (").push(table.names()).push(") values ");
        for (nth, row) in rows.into_iter().enumerate() {
            sql.push(if nth == 0 { "(" } else { ", (" }).push_list(row).push(")");
        }
        sql.build().execute(self.target()).await.map(drop)
    }

    /// Number and digest of the rows of a table.
    pub(super) async fn digest(&mut self, table: &Table) -> Result<CopiedTable> {
        let mut seen = RowDigest::default();
        let mut rows = self.rows(table);
        while let Some(row) = rows.try_next().await? {
            seen.add(&row);
        }
        Ok(seen.end(table))
    }
}

/// Refuses a database that has not the tables of this version.
pub(super) async fn require_current<C>(database: &mut C) -> Result<()>
where
    for<'c> &'c mut C: Into<Target<'c>>,
{
    if let Some(migration) = migrations::newer(&mut *database).await? {
        // Columns of a newer version are not known here, and would be lost.
        return Err(Error::StoreNewer { migration });
    }
    let applied = query_scalar("select version from _sqlx_migrations");
    let applied: Vec<i64> = applied.fetch_all(database).await?;
    let known = migrations::sqlite();
    match known.iter().find(|migration| !applied.contains(&migration.version)) {
        Some(missing) => Err(Error::StoreOlder { migration: missing.version }),
        None => Ok(()),
    }
}

/// Copies all rows of a table, and compares both sides. `database` names the target.
///
/// # Errors
/// [`Error::MigrationDiffers`]; database errors.
pub(super) async fn copy(
    from: &mut Connection,
    to: &mut Connection,
    table: &Table,
    database: &str,
) -> Result<CopiedTable> {
    let most = (MOST_VALUES / table.columns.len().max(1)).clamp(1, BATCH);
    let mut seen = RowDigest::default();
    let mut batch = Vec::with_capacity(most);
    let mut rows = from.rows(table);
    while let Some(row) = rows.try_next().await? {
        seen.add(&row);
        batch.push(row);
        if batch.len() == most {
            to.insert(table, std::mem::take(&mut batch)).await?;
        }
    }
    to.insert(table, batch).await?;
    same(seen.end(table), to, table, database).await
}

/// Compares the rows of a table in two databases. `database` names the second one.
///
/// # Errors
/// [`Error::MigrationDiffers`]; database errors.
pub(super) async fn compare(
    from: &mut Connection,
    to: &mut Connection,
    table: &Table,
    database: &str,
) -> Result<CopiedTable> {
    same(from.digest(table).await?, to, table, database).await
}

async fn same(
    expected: CopiedTable,
    to: &mut Connection,
    table: &Table,
    database: &str,
) -> Result<CopiedTable> {
    if to.digest(table).await? == expected {
        return Ok(expected);
    }
    let (table, database) = (table.name.clone(), database.to_owned());
    Err(Error::MigrationDiffers { table, database })
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

    fn end(self, table: &Table) -> CopiedTable {
        let digest: Digest = self.hash.finalize();
        CopiedTable {
            name: table.name.clone(),
            rows: self.rows,
            digest: digest.to_hex().to_string(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[tokio::test]
    async fn every_table_has_a_key_and_types_that_are_copied() {
        let mut memory = SqliteConnectOptions::new().in_memory(true).connect().await.unwrap();
        migrations::sqlite().run(&mut memory).await.unwrap();
        let tables = tables().await.unwrap();
        assert!(tables.len() > 15 && tables.iter().any(|table| table.name == "captures"));
        for table in tables {
            assert!(!table.key.is_empty(), "{} has no primary key", table.name);
            let declared = query_scalar("select lower(type) from pragma_table_info($1)");
            let declared: Vec<String> =
                declared.bind(&table.name).fetch_all(&mut memory).await.unwrap();
            for kind in declared {
                let known = ["text", "bigint", "double precision", "boolean"].contains(&&*kind);
                assert!(known, "a column of {} is of type {kind}", table.name);
            }
        }
    }
}
