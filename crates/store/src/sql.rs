//! Statements in the dialect that SQLite and PostgreSQL share, each written once.
//!
//! A statement has `$1`, `$2`, … and values of four types. A [`Record`] is read from rows of either
//! database. A statement runs on an open transaction, on the connections that read, or
//! on one connection of SQLite ([`Target`]).

pub(crate) mod row;
mod target;
mod value;

use std::fmt::Write as _;

use sqlx::{
    AssertSqlSafe, FromRow, Postgres, SqlSafeStr, SqlStr, Sqlite,
    postgres::{PgQueryResult, PgRow},
    sqlite::{SqliteQueryResult, SqliteRow},
};

use crate::{Error, Result, database::postgres};

use target::Place;
pub(crate) use target::{Readers, Reading, Target, Transaction, answered};
pub(crate) use value::Value;
use value::arguments;

/// A value that can be read from a row of either database.
pub(crate) trait Record:
    Send + Unpin + for<'r> FromRow<'r, SqliteRow> + for<'r> FromRow<'r, PgRow>
{
}

impl<T> Record for T where
    T: Send + Unpin + for<'r> FromRow<'r, SqliteRow> + for<'r> FromRow<'r, PgRow>
{
}

/// A statement with its values.
#[derive(Debug)]
pub(crate) struct Query {
    sql: SqlStr,
    values: Vec<Value>,
}

/// A statement without values yet.
pub(crate) fn query(sql: impl SqlSafeStr) -> Query {
    Query { sql: sql.into_sql_str(), values: Vec::new() }
}

/// A statement whose rows have one column.
pub(crate) fn query_scalar(sql: impl SqlSafeStr) -> Scalar {
    Scalar(query(sql))
}

/// Runs a statement on its target; `$sqlite` and `$postgres` convert the answer of their database.
/// Rows are decoded outside, so that sqlx's futures are compiled for three functions and not for
/// every record.
macro_rules! run {
    ($query:ident, $target:ident, $call:ident, $sqlite:expr, $postgres:expr) => {{
        let Query { sql, values } = $query;
        let Target { place, meter } = $target;
        let operation = place.operation();
        let call = async {
            Ok(match place {
                Place::SqliteReaders(readers) => {
                    let query = sqlx::query_with::<Sqlite, _>(sql, arguments::<Sqlite>(values)?);
                    $sqlite(query.$call(readers).await?)
                }
                Place::Sqlite(connection) => {
                    let query = sqlx::query_with::<Sqlite, _>(sql, arguments::<Sqlite>(values)?);
                    $sqlite(query.$call(connection).await?)
                }
                Place::PostgresReaders(readers) => {
                    let query =
                        sqlx::query_with::<Postgres, _>(sql, arguments::<Postgres>(values)?);
                    let connection = readers.acquire().await;
                    let mut connection = connection.map_err(|e| postgres::unserved(e, meter))?;
                    let answer = answered(query.$call(&mut *connection)).await;
                    if matches!(answer, Err(Error::DatabaseUnavailable)) {
                        // Returned to its pool it would wait for the answer, and keep a place.
                        drop(connection.detach());
                    }
                    $postgres(answer?)
                }
                Place::Postgres(connection) => {
                    let query =
                        sqlx::query_with::<Postgres, _>(sql, arguments::<Postgres>(values)?);
                    match meter {
                        Some(_) => $postgres(answered(query.$call(connection)).await?),
                        // Statements of maintenance have no time limit.
                        None => $postgres(query.$call(connection).await?),
                    }
                }
            })
        };
        match meter {
            Some(meter) => meter.measure(operation, call).await,
            None => call.await,
        }
    }};
}

impl Query {
    /// Adds the next value.
    pub(crate) fn bind(mut self, value: impl Into<Value>) -> Self {
        self.values.push(value.into());
        self
    }

    /// The statement that shows the plan of this one, with the same values.
    #[cfg(test)]
    pub(crate) fn explained(self, explain: &str) -> Self {
        let sql = AssertSqlSafe(format!("{explain} {}", self.sql.as_str())).into_sql_str();
        Self { sql, ..self }
    }

    /// Runs it. Returns the number of rows that it changed.
    pub(crate) async fn execute<'t>(self, target: impl Into<Target<'t>>) -> Result<u64> {
        self.execute_on(target.into()).await
    }

    /// All rows.
    pub(crate) async fn fetch_all<'t, T: Record>(
        self,
        target: impl Into<Target<'t>>,
    ) -> Result<Vec<T>> {
        Ok(match self.all_rows(target.into()).await? {
            Rows::Sqlite(rows) => rows.iter().map(T::from_row).collect::<sqlx::Result<_>>()?,
            Rows::Postgres(rows) => rows.iter().map(T::from_row).collect::<sqlx::Result<_>>()?,
        })
    }

    /// The first row, if there is one.
    pub(crate) async fn fetch_optional<'t, T: Record>(
        self,
        target: impl Into<Target<'t>>,
    ) -> Result<Option<T>> {
        self.first_row(target.into()).await?.map(|row| read(&row)).transpose()
    }

    /// The first row; without rows, an error of the database.
    pub(crate) async fn fetch_one<'t, T: Record>(self, target: impl Into<Target<'t>>) -> Result<T> {
        let row = self.first_row(target.into()).await?.ok_or(sqlx::Error::RowNotFound)?;
        read(&row)
    }

    async fn execute_on(self, target: Target<'_>) -> Result<u64> {
        let sqlite = |done: SqliteQueryResult| done.rows_affected();
        let postgres = |done: PgQueryResult| done.rows_affected();
        run!(self, target, execute, sqlite, postgres)
    }

    async fn all_rows(self, target: Target<'_>) -> Result<Rows> {
        run!(self, target, fetch_all, Rows::Sqlite, Rows::Postgres)
    }

    async fn first_row(self, target: Target<'_>) -> Result<Option<Row>> {
        let sqlite = |row: Option<SqliteRow>| row.map(Row::Sqlite);
        let postgres = |row: Option<PgRow>| row.map(Row::Postgres);
        run!(self, target, fetch_optional, sqlite, postgres)
    }
}

/// A row of either database.
enum Row {
    Sqlite(SqliteRow),
    Postgres(PgRow),
}

/// Rows of either database.
enum Rows {
    Sqlite(Vec<SqliteRow>),
    Postgres(Vec<PgRow>),
}

fn read<T: Record>(row: &Row) -> Result<T> {
    Ok(match row {
        Row::Sqlite(row) => T::from_row(row)?,
        Row::Postgres(row) => T::from_row(row)?,
    })
}

/// A statement whose rows have one column.
#[derive(Debug)]
pub(crate) struct Scalar(Query);

impl Scalar {
    /// Adds the next value.
    pub(crate) fn bind(self, value: impl Into<Value>) -> Self {
        Self(self.0.bind(value))
    }

    /// All values.
    pub(crate) async fn fetch_all<'t, T>(self, target: impl Into<Target<'t>>) -> Result<Vec<T>>
    where
        (T,): Record,
    {
        Ok(self.0.fetch_all(target).await?.into_iter().map(|(value,)| value).collect())
    }

    /// The first value, if there is a row.
    pub(crate) async fn fetch_optional<'t, T>(
        self,
        target: impl Into<Target<'t>>,
    ) -> Result<Option<T>>
    where
        (T,): Record,
    {
        Ok(self.0.fetch_optional(target).await?.map(|(value,)| value))
    }

    /// The first value; without rows, an error of the database.
    pub(crate) async fn fetch_one<'t, T>(self, target: impl Into<Target<'t>>) -> Result<T>
    where
        (T,): Record,
    {
        let (value,) = self.0.fetch_one(target).await?;
        Ok(value)
    }
}

/// A statement that is put together from parts, with its values in their order.
#[derive(Debug)]
pub(crate) struct Builder {
    sql: String,
    values: Vec<Value>,
}

impl Builder {
    /// The beginning of a statement.
    pub(crate) fn new(sql: &str) -> Self {
        Self { sql: sql.to_owned(), values: Vec::new() }
    }

    /// Adds text of the statement itself.
    pub(crate) fn push(&mut self, sql: impl std::fmt::Display) -> &mut Self {
        // A string takes everything.
        let _ = write!(self.sql, "{sql}");
        self
    }

    /// Adds a value to which the text refers by its number.
    pub(crate) fn bind(&mut self, value: impl Into<Value>) -> &mut Self {
        self.values.push(value.into());
        self
    }

    /// Adds a value in its place.
    pub(crate) fn push_bind(&mut self, value: impl Into<Value>) -> &mut Self {
        self.values.push(value.into());
        let place = self.values.len();
        self.push(format_args!("${place}"))
    }

    /// Adds values with commas between them; without any, null, which no value of a column equals:
    /// PostgreSQL has no empty list.
    pub(crate) fn push_list<V: Into<Value>>(
        &mut self,
        values: impl IntoIterator<Item = V>,
    ) -> &mut Self {
        let mut count = 0;
        for value in values {
            self.push(if count == 0 { "" } else { ", " }).push_bind(value);
            count += 1;
        }
        if count == 0 { self.push("null") } else { self }
    }

    /// The statement.
    pub(crate) fn build(self) -> Query {
        // Its text came through `push`, what clients sent through `push_bind`.
        Query { sql: AssertSqlSafe(self.sql).into_sql_str(), values: self.values }
    }
}
