//! The open database: SQLite in the data folder, or PostgreSQL.
//!
//! Both are used in the same way. [`Database::read`] is for single statements that only read.
//! [`Database::write`] begins a transaction that excludes all others that write, from its start to
//! its end, whichever process they belong to: what it has read stays true until it commits. In
//! SQLite that is its lock on writing; in PostgreSQL, where a row that was read may change before it
//! is written, it is an advisory lock, which every transaction takes first.

mod marker;
pub(crate) mod migrations;
pub(crate) mod postgres;
pub(crate) mod sqlite;
#[cfg(test)]
pub(crate) mod testing;
mod url;

use std::{
    fs::{File, TryLockError},
    path::Path,
    sync::Arc,
    time::{Duration, Instant},
};

use tokio::sync::{Notify, broadcast};

use crate::{
    Error, JobId, Result,
    folder::{self, disk::Reserve},
    sql::{Readers, Reading, Transaction},
    store::meter::Meter,
};

pub(crate) use marker::{
    BACKUP, RESTORE_STATE, RESTORING, leave as leave_marker, leave_objects, require_local_objects,
    require_none, require_objects, require_settled,
};
pub(crate) use postgres::{Turn, plans};
pub(crate) use sqlite::{FILE, options};
pub use url::DatabaseUrl;

/// Name of the file whose lock a server holds.
pub(crate) const LOCK: &str = "lock";
/// Longest wait for another server of the same folder that is just starting.
const START: Duration = Duration::from_secs(10);

/// The open database.
#[derive(Debug)]
pub(crate) struct Database {
    engine: Engine,
    readers: Readers,
    meter: Meter,
    /// Name in messages.
    name: String,
    reserve: Arc<Reserve>,
    /// Lock, held for as long as the database is open; the system releases it with the process.
    lock: File,
}

/// Tasks woken by the notifications of a database that several servers may have open.
#[derive(Clone, Debug)]
pub(crate) struct Wakes {
    /// Notified when a job enters the queue.
    pub(crate) queued: Arc<Notify>,
    /// Ids of jobs that changed.
    pub(crate) changes: broadcast::Sender<JobId>,
    /// Notified when a worker registers, goes, or is to end.
    pub(crate) members: Arc<Notify>,
}

#[derive(Debug)]
enum Engine {
    Sqlite(sqlite::Writer),
    Postgres(Box<postgres::Server>),
}

impl Database {
    /// Opens the database of a data folder whose lock is held: in SQLite, unless a URL is given.
    pub(crate) async fn open(
        data_dir: &Path,
        url: Option<&DatabaseUrl>,
        lock: File,
        reserve: Arc<Reserve>,
        meter: Meter,
    ) -> Result<Self> {
        let (engine, readers, name) = match url {
            None => {
                require_none(data_dir)?;
                let (writer, readers) = sqlite::open(data_dir, reserve.clone()).await?;
                let name = data_dir.join(FILE).display().to_string();
                (Engine::Sqlite(writer), readers, name)
            }
            Some(url) => {
                let (server, readers) = postgres::open(url).await?;
                (Engine::Postgres(Box::new(server)), readers, url.to_string())
            }
        };
        Ok(Self { engine, readers, meter, name, reserve, lock })
    }

    /// Name in messages, without a password.
    pub(crate) fn name(&self) -> &str {
        &self.name
    }

    /// True if it is PostgreSQL, whose connections may break and whose changes others may make.
    pub(crate) fn is_remote(&self) -> bool {
        matches!(self.engine, Engine::Postgres(_))
    }

    /// Connection for single statements that only read.
    pub(crate) fn read(&self) -> Reading<'_> {
        Reading { readers: &self.readers, meter: &self.meter }
    }

    /// A transaction that excludes all others that write, so that its reads stay valid.
    pub(crate) async fn write(&self) -> Result<Transaction> {
        self.reserve.release_if_low();
        let begin = async {
            match &self.engine {
                Engine::Sqlite(writer) => writer.begin(&self.meter).await,
                Engine::Postgres(server) => server.begin(&self.meter).await,
            }
        };
        self.meter.measure("begin", begin).await
    }

    /// Wakes waiters when any server that has this database open changes what they wait for, if it is
    /// one that several may have open.
    pub(crate) fn wake(&self, wakes: Wakes) {
        if let Engine::Postgres(server) = &self.engine {
            server.wake(wakes);
        }
    }

    /// Allows other servers to use the folder, too, if their rows are in the same database.
    pub(crate) fn share_folder(&self) -> Result<()> {
        if self.is_remote() { share(&self.lock) } else { Ok(()) }
    }

    /// The turn of this server to do a work that one at a time does; none while another has it.
    pub(crate) async fn turn(&self, work: i64) -> Result<Option<Turn>> {
        match &self.engine {
            Engine::Sqlite(_) => Ok(Some(Turn::alone())),
            Engine::Postgres(server) => server.turn(work).await,
        }
    }

    pub(crate) async fn close(&self) {
        match (&self.engine, &self.readers) {
            (Engine::Sqlite(writer), Readers::Sqlite(readers)) => {
                readers.close().await;
                writer.close().await;
            }
            (Engine::Postgres(server), _) => server.close().await,
            (Engine::Sqlite(writer), Readers::Postgres(_)) => writer.close().await,
        }
        // Not by closing the file: a process that is just being started holds it, too, for a moment.
        if let Err(error) = self.lock.unlock() {
            tracing::warn!(%error, "the lock of the data folder ends with this process");
        }
    }

    /// The connection of SQLite that writes.
    #[cfg(test)]
    pub(crate) fn writer(&self) -> &sqlx::SqlitePool {
        match &self.engine {
            Engine::Sqlite(writer) => writer.pool(),
            Engine::Postgres(_) => panic!("a test of SQLite alone"),
        }
    }

    /// The server of PostgreSQL.
    #[cfg(test)]
    pub(crate) fn server(&self) -> &postgres::Server {
        match &self.engine {
            Engine::Sqlite(_) => panic!("a test of PostgreSQL alone"),
            Engine::Postgres(server) => server,
        }
    }
}

/// Takes the lock of a data folder, alone.
pub(crate) fn lock(data_dir: &Path) -> Result<File> {
    let lock = lock_file(data_dir)?;
    lock.try_lock().map_err(refused)?;
    Ok(lock)
}

/// Takes the lock of a data folder whose rows are elsewhere, so that several servers may have it.
/// If no other has it yet, it is held alone until [`share`].
pub(crate) async fn lock_shared(data_dir: &Path) -> Result<File> {
    let lock = lock_file(data_dir)?;
    let patience = Instant::now() + START;
    loop {
        match lock.try_lock() {
            Ok(()) => return Ok(lock),
            Err(TryLockError::Error(error)) => return Err(error.into()),
            Err(TryLockError::WouldBlock) => {}
        }
        match lock.try_lock_shared() {
            Ok(()) => return Ok(lock),
            // Another one is just starting, or a repair is under way.
            Err(TryLockError::WouldBlock) if Instant::now() < patience => {
                tokio::time::sleep(Duration::from_millis(20)).await;
            }
            Err(error) => return Err(refused(error)),
        }
    }
}

/// Allows other servers to use the folder, too.
pub(crate) fn share(lock: &File) -> Result<()> {
    lock.try_lock_shared().map_err(refused)
}

fn lock_file(data_dir: &Path) -> Result<File> {
    let path = data_dir.join(LOCK);
    let lock = File::create(&path)?;
    folder::close_to_others(&path, folder::FILE);
    Ok(lock)
}

fn refused(error: TryLockError) -> Error {
    match error {
        TryLockError::WouldBlock => Error::DataDirInUse,
        TryLockError::Error(error) => error.into(),
    }
}
