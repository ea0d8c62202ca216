//! The parts that are specific to SQLite: the files, the pragmas, and one writer beside many
//! readers.
//!
//! SQLite ends a transaction by itself when a disk is full or fails. The pool would still count it
//! as open, and every later transaction would be refused. So a returned connection must prove that
//! it can begin a transaction, however the last one ended: if it cannot, it is closed, and the next
//! write opens another.

use std::{fs, path::Path, sync::Arc, time::Duration};

use sqlx::{
    Connection as _, SqliteConnection, SqlitePool,
    sqlite::{SqliteConnectOptions, SqliteJournalMode, SqlitePoolOptions, SqliteSynchronous},
};

use crate::{
    Error, Result,
    database::migrations,
    folder::{self, disk::Reserve},
    sql::{Readers, Transaction},
    store::meter::Meter,
};

/// Name of the database in the data folder.
pub(crate) const FILE: &str = "bendtwin.sqlite";

const READERS: u32 = 4;
const BUSY_TIMEOUT: Duration = Duration::from_secs(10);
const ACQUIRE_TIMEOUT: Duration = Duration::from_secs(20);
/// Size up to which a database is checked at every start [bytes]: about a second of reading.
const CHECKED_AT_START: u64 = 1 << 30;

/// The one connection that writes.
#[derive(Debug)]
pub(crate) struct Writer(SqlitePool);

impl Writer {
    /// A transaction that holds the write lock from its start.
    pub(super) async fn begin(&self, meter: &Meter) -> Result<Transaction> {
        let open = self.0.begin_with("begin immediate").await?;
        Ok(Transaction::sqlite(open, meter.clone()))
    }

    pub(crate) async fn close(&self) {
        self.0.close().await;
    }

    #[cfg(test)]
    pub(super) fn pool(&self) -> &SqlitePool {
        &self.0
    }
}

/// Opens the database in a data folder and brings its tables up to date.
pub(crate) async fn open(data_dir: &Path, reserve: Arc<Reserve>) -> Result<(Writer, Readers)> {
    let file = data_dir.join(FILE);
    let options = options(&file).create_if_missing(true);
    let size_bytes = fs::metadata(&file).map_or(0, |found| found.len());
    // SQLite has one writer at a time anyway; a pool of one queues fairly instead of polling.
    let writer = SqlitePoolOptions::new()
        .max_connections(1)
        .acquire_timeout(ACQUIRE_TIMEOUT)
        .after_release(move |connection, _| {
            let reserve = reserve.clone();
            Box::pin(async move {
                let sound = is_idle(connection).await;
                if !sound {
                    tracing::warn!("the connection of a transaction that failed is closed");
                    reserve.release_if_low();
                }
                Ok(sound)
            })
        })
        .connect_with(options.clone())
        .await?;
    // A later connection must not make a new database where this one was moved away.
    let options = options.create_if_missing(false);
    writer.set_connect_options(options.clone());
    folder::close_to_others(&file, folder::FILE);
    if size_bytes > CHECKED_AT_START {
        tracing::info!(size_bytes, "too large to be checked at start: see `store check`");
    } else if size_bytes > 0 {
        quick_check(&writer).await?;
    }
    migrations::sqlite().run(&writer).await?;
    migrations::newer(&Readers::Sqlite(writer.clone())).await?;
    let readers = SqlitePoolOptions::new()
        .max_connections(READERS)
        .acquire_timeout(ACQUIRE_TIMEOUT)
        .connect_with(options.read_only(true))
        .await?;
    Ok((Writer(writer), Readers::Sqlite(readers)))
}

/// Options of every connection to a database file.
pub(crate) fn options(file: &Path) -> SqliteConnectOptions {
    SqliteConnectOptions::new()
        .filename(file)
        .journal_mode(SqliteJournalMode::Wal)
        .synchronous(SqliteSynchronous::Full)
        .busy_timeout(BUSY_TIMEOUT)
}

/// True if neither SQLite nor sqlx has a transaction open: either would refuse this one.
async fn is_idle(connection: &mut SqliteConnection) -> bool {
    match connection.begin_with("begin").await {
        Ok(transaction) => transaction.rollback().await.is_ok(),
        Err(_) => false,
    }
}

/// Reads all pages once, without comparing indexes with their tables.
async fn quick_check(pool: &SqlitePool) -> Result<()> {
    let found: String = sqlx::query_scalar("pragma quick_check(1)").fetch_one(pool).await?;
    if found == "ok" { Ok(()) } else { Err(Error::DatabaseDamaged { fault: found }) }
}

#[cfg(test)]
mod tests;
