//! The parts that are specific to SQLite: the files, the pragmas, one writer beside many readers,
//! and the lock that keeps a second server off the folder.
//!
//! SQLite ends a transaction by itself when a disk is full or fails. The pool would go on counting
//! it as open, and every later transaction would be refused. So a connection that comes back must
//! prove that it can begin one, however the last one ended: if not, it is closed, and the next
//! write opens another.

use std::{
    fs::{self, File, TryLockError},
    path::Path,
    sync::Arc,
    time::Duration,
};

use sqlx::{
    Connection as _, Sqlite, SqliteConnection, SqlitePool, Transaction,
    sqlite::{SqliteConnectOptions, SqliteJournalMode, SqlitePoolOptions, SqliteSynchronous},
};

use crate::{Error, Result, disk::Reserve, folder, migrations};

/// Name of the database in the data folder.
pub(crate) const FILE: &str = "bendtwin.sqlite";

/// Name of the file whose lock a server holds.
pub(crate) const LOCK: &str = "lock";

const READERS: u32 = 4;
const BUSY_TIMEOUT: Duration = Duration::from_secs(10);
const ACQUIRE_TIMEOUT: Duration = Duration::from_secs(20);
/// Size up to which a database is checked at every start [bytes]: about a second of reading.
const CHECKED_AT_START: u64 = 1 << 30;

/// The open database.
#[derive(Debug)]
pub(crate) struct Database {
    writer: SqlitePool,
    readers: SqlitePool,
    reserve: Arc<Reserve>,
    /// Lock, held for as long as the database is open; the system releases it with the process.
    lock: File,
}

impl Database {
    pub(crate) async fn open(data_dir: &Path, lock: File, reserve: Arc<Reserve>) -> Result<Self> {
        let file = data_dir.join(FILE);
        let options = options(&file).create_if_missing(true);
        let size_bytes = fs::metadata(&file).map_or(0, |found| found.len());
        // SQLite has one writer at a time anyway; a pool of one queues fairly instead of polling.
        let low = reserve.clone();
        let writer = SqlitePoolOptions::new()
            .max_connections(1)
            .acquire_timeout(ACQUIRE_TIMEOUT)
            .after_release(move |connection, _| {
                let low = low.clone();
                Box::pin(async move {
                    let sound = is_idle(connection).await;
                    if !sound {
                        tracing::warn!("the connection of a transaction that failed is closed");
                        low.release_if_low();
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
        migrations::migrator().run(&writer).await?;
        let readers = SqlitePoolOptions::new()
            .max_connections(READERS)
            .acquire_timeout(ACQUIRE_TIMEOUT)
            .connect_with(options.read_only(true))
            .await?;
        Ok(Self { writer, readers, reserve, lock })
    }

    /// For single statements that only read.
    pub(crate) fn read(&self) -> &SqlitePool {
        &self.readers
    }

    /// A transaction that holds the write lock from its start, so that its reads stay valid.
    pub(crate) async fn write(&self) -> Result<Transaction<'static, Sqlite>> {
        self.reserve.release_if_low();
        Ok(self.writer.begin_with("begin immediate").await?)
    }

    pub(crate) async fn close(&self) {
        self.readers.close().await;
        self.writer.close().await;
        // Not by closing the file: a process that is just being started holds it, too, for a moment.
        if let Err(error) = self.lock.unlock() {
            tracing::warn!(%error, "the lock of the data folder ends with this process");
        }
    }

    #[cfg(test)]
    pub(crate) fn writer(&self) -> &SqlitePool {
        &self.writer
    }
}

/// Options of every connection to a database file.
pub(crate) fn options(file: &Path) -> SqliteConnectOptions {
    SqliteConnectOptions::new()
        .filename(file)
        .journal_mode(SqliteJournalMode::Wal)
        .synchronous(SqliteSynchronous::Full)
        .busy_timeout(BUSY_TIMEOUT)
}

/// Takes the lock of a data folder.
pub(crate) fn lock(data_dir: &Path) -> Result<File> {
    let path = data_dir.join(LOCK);
    let lock = File::create(&path)?;
    folder::close_to_others(&path, folder::FILE);
    lock.try_lock().map_err(|error| match error {
        TryLockError::WouldBlock => Error::DataDirInUse,
        TryLockError::Error(error) => error.into(),
    })?;
    Ok(lock)
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
