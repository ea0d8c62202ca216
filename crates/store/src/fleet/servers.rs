//! Servers that have the database open. They know each other through it alone: each renews the row
//! that it made at its start, and the others watch whether it does.

use bendtwin_core::ids::ServerId;
use jiff::Timestamp;
use sqlx::PgConnection;

use crate::{
    Error, Result, Store,
    database::{Database, migrations},
    sql::{
        Transaction, query, query_scalar,
        row::{self, row},
    },
    store::clock::from_micros,
};

/// Time for which the row of a server that was killed may stand [us].
const LINGERING: i64 = 60_000_000;

/// A server that has the database open, or had it open when it was killed.
#[derive(Clone, Debug, PartialEq)]
pub struct Server {
    /// Id, new at every start.
    pub id: ServerId,
    /// The software's version.
    pub build: String,
    /// Time of its start.
    pub started: Timestamp,
    /// A number that changes while it runs.
    pub sign: i64,
}

/// The servers of a store.
#[derive(Clone, Copy, Debug)]
pub struct Servers<'a> {
    pub(crate) store: &'a Store,
}

row! {
    struct Row {
        id: String,
        build: String,
        started_at: i64,
        seen_at: i64,
    }
}

impl TryFrom<Row> for Server {
    type Error = Error;
    fn try_from(row: Row) -> Result<Self> {
        let id = row::id("servers", &row.id)?;
        let (started, sign) = (from_micros(row.started_at), row.seen_at);
        Ok(Self { id: id.into(), build: row.build, started, sign })
    }
}

impl Servers<'_> {
    /// Notes that a server runs.
    ///
    /// # Errors
    /// [`Error::DatabaseNewer`] if it cannot use the database any more; database errors.
    pub async fn seen(&self, id: ServerId, build: &str) -> Result<()> {
        let mut tx = self.store.inner.database.write().await?;
        migrations::newer(&mut tx).await?;
        let now = self.store.server_time(&tx);
        query(
            "insert into servers (id, build, started_at, seen_at) values ($1, $2, $3, $3)
             on conflict (id) do update set seen_at = excluded.seen_at",
        )
        .bind(id.uuid().to_string())
        .bind(build)
        .bind(now)
        .execute(&mut tx)
        .await?;
        tx.commit().await
    }

    /// All servers, newest first.
    ///
    /// # Errors
    /// Database errors.
    pub async fn all(&self) -> Result<Vec<Server>> {
        let rows: Vec<Row> = query("select * from servers order by id desc")
            .fetch_all(self.store.inner.database.read())
            .await?;
        rows.into_iter().map(Server::try_from).collect()
    }

    /// Forgets a server, which has stopped or is gone.
    ///
    /// # Errors
    /// Database errors.
    pub async fn forget(&self, id: ServerId) -> Result<()> {
        let mut tx = self.store.inner.database.write().await?;
        query("delete from servers where id = $1")
            .bind(id.uuid().to_string())
            .execute(&mut tx)
            .await?;
        tx.commit().await
    }
}

impl Store {
    /// The time of the servers' signs of life [us]: the database's if it has a clock, else this
    /// machine's.
    pub(crate) fn server_time(&self, tx: &Transaction) -> i64 {
        self.database_time(tx).unwrap_or_else(|| self.now_micros())
    }
}

/// Number of servers with recent signs of life; this one cannot be among them yet.
pub(crate) async fn count_lately(connection: &mut PgConnection) -> Result<i64> {
    let count = "select count(*) from servers
         where seen_at > (extract(epoch from clock_timestamp()) * 1000000)::bigint - $1";
    query_scalar(count).bind(LINGERING).fetch_one(connection).await
}

/// True if a server was heard of lately that has this database open, beside the one that asks.
pub(crate) async fn any_lately(database: &Database) -> Result<bool> {
    let tx = database.write().await?;
    let Some(now) = tx.database_time() else { return Ok(false) };
    drop(tx);
    let count: i64 = query_scalar("select count(*) from servers where seen_at > $1")
        .bind(now - LINGERING)
        .fetch_one(database.read())
        .await?;
    Ok(count > 0)
}
