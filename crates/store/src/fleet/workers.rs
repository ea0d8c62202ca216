//! Registered worker processes: the members of a fleet, as all servers of a database know them. Their
//! current state is kept in memory by each server's dispatch, not here.

use bendtwin_core::ids::{ServerId, WorkerId};
use jiff::Timestamp;
use uuid::Uuid;

use crate::{
    Error, Result, Store,
    sql::{
        query,
        row::{self, row},
    },
    store::clock::from_micros,
};

/// A worker as it registered.
#[derive(Clone, Debug, PartialEq)]
pub struct NewWorker {
    /// Id, new at every start.
    pub id: WorkerId,
    /// Endpoint at which it answers rollouts.
    pub endpoint: String,
    /// cpu or cuda.
    pub backend: String,
    /// The device's name.
    pub device: String,
    /// The software's version.
    pub build: String,
    /// Number of instances that the worker runs concurrently.
    pub lanes: u32,
    /// Words that it was started with, which fits can ask for.
    pub labels: Vec<String>,
    /// The server that started it and with which it ends, if one did: it answers that one alone.
    pub server: Option<ServerId>,
}

/// A worker that the store knows.
#[derive(Clone, Debug, PartialEq)]
pub struct Worker {
    /// Registration of the worker.
    pub registration: NewWorker,
    /// Time of registration.
    pub started: Timestamp,
    /// True if a server started it; which one is not known of those from before that was stored.
    pub is_supervised: bool,
    /// A number that changes while any server hears of it.
    pub sign: i64,
    /// True if it is to take no more jobs and rollouts, and to end.
    pub is_draining: bool,
}

/// The workers of a store.
#[derive(Clone, Copy, Debug)]
pub struct Workers<'a> {
    pub(crate) store: &'a Store,
}

row! {
    struct Row {
        id: String,
        endpoint: String,
        backend: String,
        device: String,
        build: String,
        lanes: i64,
        supervised: bool,
        labels: String,
        started_at: i64,
        server: Option<String>,
        seen_at: i64,
        draining: bool,
    }
}

impl TryFrom<Row> for Worker {
    type Error = Error;
    fn try_from(row: Row) -> Result<Self> {
        let id = row::id("workers", &row.id)?;
        Ok(Self {
            registration: NewWorker {
                id: id.into(),
                endpoint: row.endpoint,
                backend: row.backend,
                device: row.device,
                build: row.build,
                lanes: u32::try_from(row.lanes).unwrap_or(0),
                labels: serde_json::from_str(&row.labels).unwrap_or_default(),
                server: row.server.and_then(|id| Some(Uuid::try_parse(&id).ok()?.into())),
            },
            started: from_micros(row.started_at),
            is_supervised: row.supervised,
            sign: row.seen_at,
            is_draining: row.draining,
        })
    }
}

impl Workers<'_> {
    /// Registers a worker, or renews its registration.
    ///
    /// # Errors
    /// Database errors.
    pub async fn register(&self, new: NewWorker) -> Result<Worker> {
        let mut tx = self.store.inner.database.write().await?;
        let now = self.store.server_time(&tx);
        let row: Row = query(
            "insert into workers (id, endpoint, backend, device, build, lanes, supervised,
                 started_at, server, seen_at, labels)
             values ($1, $2, $3, $4, $5, $6, $7, $8, $9, $10, $11)
             on conflict (id) do update set endpoint = excluded.endpoint,
                 backend = excluded.backend, device = excluded.device, build = excluded.build,
                 lanes = excluded.lanes, labels = excluded.labels, seen_at = excluded.seen_at
             returning *",
        )
        .bind(new.id.uuid().to_string())
        .bind(new.endpoint)
        .bind(new.backend)
        .bind(new.device)
        .bind(new.build)
        .bind(i64::from(new.lanes))
        .bind(new.server.is_some())
        .bind(self.store.now_micros())
        .bind(new.server.map(|server| server.uuid().to_string()))
        .bind(now)
        .bind(serde_json::to_string(&new.labels).unwrap_or_default())
        .fetch_one(&mut tx)
        .await?;
        tx.commit().await?;
        row.try_into()
    }

    /// All workers, newest first. There are few: one for each device.
    ///
    /// # Errors
    /// Database errors.
    pub async fn all(&self) -> Result<Vec<Worker>> {
        let rows: Vec<Row> = query("select * from workers order by id desc")
            .fetch_all(self.store.inner.database.read())
            .await?;
        rows.into_iter().map(Worker::try_from).collect()
    }

    /// Returns a worker, if it is known.
    ///
    /// # Errors
    /// Database errors.
    pub async fn find(&self, id: WorkerId) -> Result<Option<Worker>> {
        let row: Option<Row> = query("select * from workers where id = $1")
            .bind(id.uuid().to_string())
            .fetch_optional(self.store.inner.database.read())
            .await?;
        row.map(Worker::try_from).transpose()
    }

    /// Notes that a worker is heard of. False if it is not known.
    ///
    /// # Errors
    /// Database errors.
    pub async fn seen(&self, id: WorkerId) -> Result<bool> {
        let mut tx = self.store.inner.database.write().await?;
        let now = self.store.server_time(&tx);
        let updated = query("update workers set seen_at = $2 where id = $1")
            .bind(id.uuid().to_string())
            .bind(now)
            .execute(&mut tx)
            .await?;
        tx.commit().await?;
        Ok(updated > 0)
    }

    /// Notes that a worker is to take no more work, and to end.
    ///
    /// # Errors
    /// [`Error::NotFound`].
    pub async fn drain(&self, id: WorkerId) -> Result<Worker> {
        let mut tx = self.store.inner.database.write().await?;
        let row: Option<Row> =
            query("update workers set draining = true where id = $1 returning *")
                .bind(id.uuid().to_string())
                .fetch_optional(&mut tx)
                .await?;
        tx.commit().await?;
        self.store.inner.members.notify_one();
        row.ok_or_else(|| Error::NotFound { name: id.to_string() })?.try_into()
    }

    /// Forgets a worker. Returns true if it was known.
    ///
    /// # Errors
    /// Database errors.
    pub async fn forget(&self, id: WorkerId) -> Result<bool> {
        let mut tx = self.store.inner.database.write().await?;
        let deleted = query("delete from workers where id = $1")
            .bind(id.uuid().to_string())
            .execute(&mut tx)
            .await?;
        tx.commit().await?;
        Ok(deleted > 0)
    }
}
