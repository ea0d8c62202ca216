//! The parts that are specific to PostgreSQL: connections, their time limits, the lock on writing,
//! and what wakes those who wait for a change.
//!
//! A connection that broke is noticed when it is taken, and replaced: after a restart of PostgreSQL
//! the next request works. Meanwhile requests wait for [`ACQUIRE_TIMEOUT`] and end with
//! [`Error::DatabaseUnavailable`], which may be tried again.

pub(crate) mod plans;

use std::{
    sync::{Mutex, PoisonError},
    time::Duration,
};

use sqlx::{
    ConnectOptions as _, Connection as _, PgConnection, PgPool,
    migrate::Migrator,
    postgres::{PgConnectOptions, PgListener, PgPoolOptions},
};
use tokio::task::JoinHandle;

use super::{DatabaseUrl, Wakes};
use crate::{
    Error, JobId, Result,
    database::migrations,
    sql::{Readers, Transaction, answered},
    store::meter::Meter,
};

const READERS: u32 = 8;
/// Connections for writing: one at a time holds the lock; the others have begun their transactions
/// by their turn.
const WRITERS: u32 = 4;
const ACQUIRE_TIMEOUT: Duration = Duration::from_secs(4);
/// Time limits of the server on a statement, on the wait for the lock, and on a transaction whose
/// client is silent, which would keep all others waiting.
const TIMEOUTS: [(&str, &str); 3] = [
    ("statement_timeout", "30s"),
    ("lock_timeout", "10s"),
    ("idle_in_transaction_session_timeout", "30s"),
];
/// Oldest version that has all that is used: 14.
const OLDEST: i32 = 140_000;
/// The lock of transactions that write: `bendtwin` in ASCII. Locks of other databases on the same
/// server are others.
pub(crate) const WRITE_LOCK: i64 = 0x6265_6e64_7477_696e;
/// Takes the lock, then reads the clock [us].
const TAKE_LOCK: &str = "select pg_advisory_xact_lock($1)::text,
     (extract(epoch from clock_timestamp()) * 1000000)::bigint";
/// Channels of the notifications: about the queue, about jobs that changed, about workers.
const QUEUE: &str = "bendtwin_queue";
const JOBS: &str = "bendtwin_jobs";
const WORKERS: &str = "bendtwin_workers";
/// Wait before the next attempt to listen.
const LISTEN_AGAIN: Duration = Duration::from_secs(1);

/// The server, and the connections to it.
#[derive(Debug)]
pub(crate) struct Server {
    options: PgConnectOptions,
    writers: PgPool,
    readers: PgPool,
    listening: Mutex<Option<JoinHandle<()>>>,
    /// Leaves the lock out, as a port would do that takes SQLite's way over: for the test that
    /// shows what happens then.
    #[cfg(test)]
    pub(crate) without_lock: std::sync::atomic::AtomicBool,
    /// Leaves connections with stale plans where they are: for the test that shows what happens then.
    #[cfg(test)]
    pub(crate) keeps_plans: std::sync::Arc<std::sync::atomic::AtomicBool>,
}

/// Connects, and brings the tables up to date.
pub(super) async fn open(url: &DatabaseUrl) -> Result<(Server, Readers)> {
    let options = url.options()?.application_name("bendtwin");
    // Statements of migrations may take their time.
    let mut connection = connect(&options).await?;
    prepare(&mut connection).await?;
    connection.close().await?;
    let options = options.options(TIMEOUTS);
    #[cfg(test)]
    let keeps_plans = std::sync::Arc::new(std::sync::atomic::AtomicBool::new(false));
    let pool = |most: u32| {
        let pool = PgPoolOptions::new().max_connections(most).acquire_timeout(ACQUIRE_TIMEOUT);
        #[cfg(test)]
        let keeps_plans = keeps_plans.clone();
        let pool = pool.before_acquire(move |_, meta| {
            let is_fit = !plans::are_stale(meta.age);
            #[cfg(test)]
            let is_fit = is_fit || keeps_plans.load(std::sync::atomic::Ordering::SeqCst);
            Box::pin(std::future::ready(Ok(is_fit)))
        });
        pool.connect_lazy_with(options.clone())
    };
    let (writers, readers) = (pool(WRITERS), pool(READERS));
    let server = Server {
        options: options.clone(),
        writers,
        readers: readers.clone(),
        listening: Mutex::default(),
        #[cfg(test)]
        without_lock: false.into(),
        #[cfg(test)]
        keeps_plans,
    };
    Ok((server, Readers::Postgres(readers)))
}

/// The error of a request for which there was no connection: of a server that does not answer, or of
/// one whose connections were all in use.
pub(crate) fn unserved(error: sqlx::Error, meter: Option<&Meter>) -> Error {
    let answers = meter.is_none_or(|meter| meter.answered_within(ACQUIRE_TIMEOUT));
    match error {
        sqlx::Error::PoolTimedOut if !answers => Error::DatabaseUnavailable,
        error => error.into(),
    }
}

/// A connection without time limits.
pub(crate) async fn connect(options: &PgConnectOptions) -> Result<PgConnection> {
    let connected = tokio::time::timeout(ACQUIRE_TIMEOUT, options.connect()).await;
    Ok(connected.map_err(|_| Error::DatabaseUnavailable)??)
}

/// Refuses a server that will not do, and brings the tables up to date.
pub(crate) async fn prepare(connection: &mut PgConnection) -> Result<()> {
    let (version, encoding): (i32, String) = sqlx::query_as(
        "select current_setting('server_version_num')::int, current_setting('server_encoding')",
    )
    .fetch_one(&mut *connection)
    .await?;
    if version < OLDEST {
        let fault = format!("its version is {}, older than {}", version / 10_000, OLDEST / 10_000);
        return Err(Error::DatabaseUnfit { fault });
    }
    if encoding != "UTF8" {
        let fault = format!("its encoding is {encoding}: create it with encoding 'UTF8'");
        return Err(Error::DatabaseUnfit { fault });
    }
    migrate(connection, &migrations::postgres()).await
}

/// Brings the tables up to date, unless a newer version has.
pub(crate) async fn migrate(connection: &mut PgConnection, migrator: &Migrator) -> Result<()> {
    migrations::require_alone(connection, migrator, WRITE_LOCK).await?;
    migrator.run(&mut *connection).await?;
    sqlx::query("select pg_advisory_unlock_all()").execute(&mut *connection).await?;
    if migrations::newer(&mut *connection).await?.is_some() {
        // Its functions do what those of this version do, and more.
        return Ok(());
    }
    // Two servers that start at the same time must not replace the same function.
    let mut tx = connection.begin().await?;
    sqlx::query("select pg_advisory_xact_lock($1)").bind(WRITE_LOCK).execute(&mut *tx).await?;
    sqlx::raw_sql(include_str!("postgres.sql")).execute(&mut *tx).await?;
    tx.commit().await?;
    Ok(())
}

impl Server {
    /// A transaction that holds the lock on writing.
    pub(super) async fn begin(&self, meter: &Meter) -> Result<Transaction> {
        // A connection that is taken has answered a moment ago.
        let open = self.writers.begin().await;
        let mut open = open.map_err(|error| unserved(error, Some(meter)))?;
        #[cfg(test)]
        if self.without_lock.load(std::sync::atomic::Ordering::SeqCst) {
            return Ok(Transaction::postgres(
                open,
                crate::store::clock::micros(jiff::Timestamp::now()),
                meter.clone(),
            ));
        }
        // A separate statement: if it fails, sqlx knows of the transaction and ends it.
        let (_, time): (Option<String>, i64) =
            answered(sqlx::query_as(TAKE_LOCK).bind(WRITE_LOCK).fetch_one(&mut *open)).await?;
        Ok(Transaction::postgres(open, time, meter.clone()))
    }

    /// Wakes waiters when any server changes what they wait for, for as long as the database is open.
    /// While it cannot listen, waiters look from time to time.
    pub(super) fn wake(&self, wakes: Wakes) {
        let options = self.options.clone();
        let task = tokio::spawn(async move {
            loop {
                if let Err(error) = listen(&options, &wakes).await {
                    tracing::warn!(%error, "notifications of the database have ceased");
                }
                tokio::time::sleep(LISTEN_AGAIN).await;
            }
        });
        let mut listening = self.listening.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(before) = listening.replace(task) {
            before.abort();
        }
    }

    pub(super) async fn close(&self) {
        self.stop_listening();
        self.readers.close().await;
        self.writers.close().await;
    }

    fn stop_listening(&self) {
        let mut listening = self.listening.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(task) = listening.take() {
            task.abort();
        }
    }
}

/// The turn to do a work, until it ends or is dropped.
#[derive(Debug)]
pub(crate) struct Turn {
    /// The work, and the session that has its lock. Closing the session releases the lock, too, but some
    /// time after a drop.
    held: Option<(i64, sqlx::pool::PoolConnection<sqlx::Postgres>)>,
}

impl Turn {
    /// The turn of a single server, which asks no other.
    pub(super) fn alone() -> Self {
        Self { held: None }
    }

    /// Passes the turn on: the next server that asks gets it.
    pub(crate) async fn end(self) -> Result<()> {
        if let Some((work, mut session)) = self.held {
            let unlock = sqlx::query("select pg_advisory_unlock($1)").bind(work);
            unlock.execute(&mut *session).await?;
        }
        Ok(())
    }
}

impl Server {
    pub(super) async fn turn(&self, work: i64) -> Result<Option<Turn>> {
        let mut session = self.readers.acquire().await?;
        let locked = sqlx::query_scalar("select pg_try_advisory_lock($1)").bind(work);
        let locked: bool = locked.fetch_one(&mut *session).await?;
        if !locked {
            return Ok(None);
        }
        session.close_on_drop();
        Ok(Some(Turn { held: Some((work, session)) }))
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        self.stop_listening();
    }
}

/// Passes notifications on until the connection breaks.
async fn listen(options: &PgConnectOptions, wakes: &Wakes) -> Result<()> {
    let pool = PgPoolOptions::new()
        .max_connections(1)
        .acquire_timeout(ACQUIRE_TIMEOUT)
        .connect_lazy_with(options.clone());
    let mut listener = PgListener::connect_with(&pool).await?;
    listener.listen_all([QUEUE, JOBS, WORKERS]).await?;
    // Changes made while this server was not listening are found now.
    wakes.queued.notify_waiters();
    wakes.members.notify_one();
    while let Some(notification) = listener.try_recv().await? {
        match notification.channel() {
            JOBS => {
                let job = notification.payload().split_once('/');
                if let Some(job) = job.and_then(|(kind, id)| JobId::stored(kind, id)) {
                    // No receiver, no matter.
                    let _ = wakes.changes.send(job);
                }
            }
            WORKERS => wakes.members.notify_one(),
            _ => wakes.queued.notify_waiters(),
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests;
