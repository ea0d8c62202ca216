//! Registered worker processes. Their current state is kept in memory by the server's dispatch, not
//! here.

use bendtwin_core::ids::WorkerId;
use jiff::Timestamp;
use uuid::Uuid;

use crate::{Error, Result, Store, clock::from_micros, row::row, sql::query};

/// A worker as it registered.
#[derive(Clone, Debug, PartialEq)]
pub struct NewWorker {
    /// Its id, new at every start.
    pub id: WorkerId,
    /// Endpoint at which it answers rollouts.
    pub endpoint: String,
    /// cpu or cuda.
    pub backend: String,
    /// The device's name.
    pub device: String,
    /// The software's version.
    pub build: String,
    /// Number of instances that it runs at once.
    pub lanes: u32,
    /// True if the server started it, so that it ends with the server.
    pub supervised: bool,
    /// Words that it was started with, which fits can ask for.
    pub labels: Vec<String>,
}

/// A worker that the store knows.
#[derive(Clone, Debug, PartialEq)]
pub struct Worker {
    /// Its registration.
    pub registration: NewWorker,
    /// Time of registration.
    pub started: Timestamp,
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
    }
}

impl TryFrom<Row> for Worker {
    type Error = Error;
    fn try_from(row: Row) -> Result<Self> {
        let id = Uuid::try_parse(&row.id).map_err(|_| Error::CorruptRow {
            name: format!("workers/{}", row.id),
            fault: "id".to_owned(),
        })?;
        Ok(Self {
            registration: NewWorker {
                id: id.into(),
                endpoint: row.endpoint,
                backend: row.backend,
                device: row.device,
                build: row.build,
                lanes: u32::try_from(row.lanes).unwrap_or(0),
                supervised: row.supervised,
                labels: serde_json::from_str(&row.labels).unwrap_or_default(),
            },
            started: from_micros(row.started_at),
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
        let row: Row = query(
            "insert into workers (id, endpoint, backend, device, build, lanes, supervised,
                 started_at, labels)
             values ($1, $2, $3, $4, $5, $6, $7, $8, $9)
             on conflict (id) do update set endpoint = excluded.endpoint,
                 backend = excluded.backend, device = excluded.device, build = excluded.build,
                 lanes = excluded.lanes, labels = excluded.labels
             returning *",
        )
        .bind(new.id.uuid().to_string())
        .bind(new.endpoint)
        .bind(new.backend)
        .bind(new.device)
        .bind(new.build)
        .bind(i64::from(new.lanes))
        .bind(new.supervised)
        .bind(self.store.now_micros())
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
