//! The places where statements run.

use sqlx::{PgConnection, PgPool, Postgres, Sqlite, SqliteConnection, SqlitePool};

use crate::Result;

/// The connections for single statements that only read.
#[derive(Clone, Debug)]
pub(crate) enum Readers {
    Sqlite(SqlitePool),
    Postgres(PgPool),
}

/// A transaction that excludes every other that writes, until it ends. Dropped, it changes nothing.
#[derive(Debug)]
pub(crate) struct Transaction {
    open: Inner,
    /// Time of the database when it excluded the others, if the database has a clock [us].
    database_time: Option<i64>,
}

#[derive(Debug)]
enum Inner {
    Sqlite(sqlx::Transaction<'static, Sqlite>),
    Postgres(sqlx::Transaction<'static, Postgres>),
}

impl Transaction {
    /// A transaction of SQLite, which holds the lock on writing.
    pub(crate) fn sqlite(open: sqlx::Transaction<'static, Sqlite>) -> Self {
        Self { open: Inner::Sqlite(open), database_time: None }
    }

    /// A transaction of PostgreSQL, which holds the lock on writing, with the database's time then
    /// [us].
    pub(crate) fn postgres(open: sqlx::Transaction<'static, Postgres>, time: i64) -> Self {
        Self { open: Inner::Postgres(open), database_time: Some(time) }
    }

    /// Time of the database, if it has a clock [us].
    pub(crate) fn database_time(&self) -> Option<i64> {
        self.database_time
    }

    /// Makes its changes last.
    pub(crate) async fn commit(self) -> Result<()> {
        match self.open {
            Inner::Sqlite(open) => open.commit().await?,
            Inner::Postgres(open) => open.commit().await?,
        }
        Ok(())
    }
}

/// Connection or transaction on which a statement runs.
#[derive(Debug)]
pub(crate) enum Target<'t> {
    SqliteReaders(&'t SqlitePool),
    Sqlite(&'t mut SqliteConnection),
    PostgresReaders(&'t PgPool),
    Postgres(&'t mut PgConnection),
}

impl<'t> From<&'t Readers> for Target<'t> {
    fn from(readers: &'t Readers) -> Self {
        match readers {
            Readers::Sqlite(readers) => Self::SqliteReaders(readers),
            Readers::Postgres(readers) => Self::PostgresReaders(readers),
        }
    }
}

impl<'t> From<&'t mut Transaction> for Target<'t> {
    fn from(transaction: &'t mut Transaction) -> Self {
        match &mut transaction.open {
            Inner::Sqlite(open) => Self::Sqlite(open),
            Inner::Postgres(open) => Self::Postgres(open),
        }
    }
}

impl<'t> From<&'t mut SqliteConnection> for Target<'t> {
    fn from(connection: &'t mut SqliteConnection) -> Self {
        Self::Sqlite(connection)
    }
}

impl<'t> From<&'t mut PgConnection> for Target<'t> {
    fn from(connection: &'t mut PgConnection) -> Self {
        Self::Postgres(connection)
    }
}
