//! The places where statements run.

use std::{future::Future, time::Duration};

use sqlx::{PgConnection, PgPool, Postgres, Sqlite, SqliteConnection, SqlitePool};

use crate::{Error, Result, store::meter::Meter};

/// Longest wait for the answer to a statement of PostgreSQL: longer than its own limit on statements,
/// so that it ends only the wait for a server or a network that is silent.
const SILENCE: Duration = Duration::from_secs(35);

/// The connections for single statements that only read.
#[derive(Clone, Debug)]
pub(crate) enum Readers {
    Sqlite(SqlitePool),
    Postgres(PgPool),
}

/// The connections for single statements that only read, with the meter of what they take.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Reading<'t> {
    pub(crate) readers: &'t Readers,
    pub(crate) meter: &'t Meter,
}

/// A transaction that excludes every other that writes, until it ends. Dropped, it changes nothing.
#[derive(Debug)]
pub(crate) struct Transaction {
    open: Inner,
    /// Time of the database when it excluded the others, if the database has a clock [us].
    database_time: Option<i64>,
    meter: Meter,
}

#[derive(Debug)]
enum Inner {
    Sqlite(sqlx::Transaction<'static, Sqlite>),
    Postgres(sqlx::Transaction<'static, Postgres>),
}

impl Transaction {
    /// A transaction of SQLite, which holds the lock on writing.
    pub(crate) fn sqlite(open: sqlx::Transaction<'static, Sqlite>, meter: Meter) -> Self {
        Self { open: Inner::Sqlite(open), database_time: None, meter }
    }

    /// A transaction of PostgreSQL, which holds the lock on writing, with the database's time then
    /// [us].
    pub(crate) fn postgres(
        open: sqlx::Transaction<'static, Postgres>,
        time: i64,
        meter: Meter,
    ) -> Self {
        Self { open: Inner::Postgres(open), database_time: Some(time), meter }
    }

    /// Time of the database, if it has a clock [us].
    pub(crate) fn database_time(&self) -> Option<i64> {
        self.database_time
    }

    /// Makes its changes last.
    pub(crate) async fn commit(self) -> Result<()> {
        let Self { open, meter, .. } = self;
        let commit = async {
            match open {
                Inner::Sqlite(open) => Ok(open.commit().await?),
                Inner::Postgres(open) => answered(open.commit()).await,
            }
        };
        meter.measure("commit", commit).await
    }
}

/// The answer of PostgreSQL, unless it is silent for longer than it may be.
pub(crate) async fn answered<T>(call: impl Future<Output = sqlx::Result<T>>) -> Result<T> {
    match tokio::time::timeout(SILENCE, call).await {
        Ok(answer) => Ok(answer?),
        Err(_) => Err(Error::DatabaseUnavailable),
    }
}

/// Connection or transaction on which a statement runs, and the meter of what it takes, if it is one of
/// an open store.
#[derive(Debug)]
pub(crate) struct Target<'t> {
    pub(super) place: Place<'t>,
    pub(super) meter: Option<&'t Meter>,
}

#[derive(Debug)]
pub(super) enum Place<'t> {
    SqliteReaders(&'t SqlitePool),
    Sqlite(&'t mut SqliteConnection),
    PostgresReaders(&'t PgPool),
    Postgres(&'t mut PgConnection),
}

impl Place<'_> {
    /// The word for its statements in metrics.
    pub(super) fn operation(&self) -> &'static str {
        match self {
            Self::SqliteReaders(_) | Self::PostgresReaders(_) => "read",
            Self::Sqlite(_) | Self::Postgres(_) => "write",
        }
    }
}

impl<'t> From<&'t Readers> for Target<'t> {
    fn from(readers: &'t Readers) -> Self {
        let place = match readers {
            Readers::Sqlite(readers) => Place::SqliteReaders(readers),
            Readers::Postgres(readers) => Place::PostgresReaders(readers),
        };
        Self { place, meter: None }
    }
}

impl<'t> From<Reading<'t>> for Target<'t> {
    fn from(Reading { readers, meter }: Reading<'t>) -> Self {
        Self { meter: Some(meter), ..readers.into() }
    }
}

impl<'t> From<&'t mut Transaction> for Target<'t> {
    fn from(transaction: &'t mut Transaction) -> Self {
        let place = match &mut transaction.open {
            Inner::Sqlite(open) => Place::Sqlite(open),
            Inner::Postgres(open) => Place::Postgres(open),
        };
        Self { place, meter: Some(&transaction.meter) }
    }
}

impl<'t> From<&'t mut SqliteConnection> for Target<'t> {
    fn from(connection: &'t mut SqliteConnection) -> Self {
        Self { place: Place::Sqlite(connection), meter: None }
    }
}

impl<'t> From<&'t mut PgConnection> for Target<'t> {
    fn from(connection: &'t mut PgConnection) -> Self {
        Self { place: Place::Postgres(connection), meter: None }
    }
}
