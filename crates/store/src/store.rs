//! The store as a whole: opening, closing, and access to the aggregates.

use std::{path::PathBuf, sync::Arc};

use jiff::Timestamp;
use tokio::sync::{Notify, broadcast};

use crate::{
    Blobs, Captures, Clock, JobId, Jobs, Result, SystemClock, Twins, Uploads, Workers,
    clock::micros,
    database::Database,
    failpoint::{Armed, Failpoint},
    uploads::Seats,
};

/// Options for opening a store.
#[derive(Clone, Debug)]
pub struct Options {
    /// The folder of all data; made if missing.
    pub data_dir: PathBuf,
    /// The clock by which leases end.
    pub clock: Arc<dyn Clock>,
}

impl Options {
    /// A folder, with the system's clock.
    pub fn new(data_dir: impl Into<PathBuf>) -> Self {
        Self { data_dir: data_dir.into(), clock: Arc::new(SystemClock) }
    }
}

/// An open store. Clones share it.
#[derive(Clone, Debug)]
pub struct Store {
    pub(crate) inner: Arc<Inner>,
}

#[derive(Debug)]
pub(crate) struct Inner {
    pub(crate) database: Database,
    pub(crate) blobs: Blobs,
    pub(crate) clock: Arc<dyn Clock>,
    /// Ids of jobs that changed.
    pub(crate) changes: broadcast::Sender<JobId>,
    /// Notified when a job enters the queue.
    pub(crate) queued: Notify,
    pub(crate) armed: Arc<Armed>,
    /// Current writer of each resumable upload.
    pub(crate) seats: Seats,
}

impl Store {
    /// Opens the folder, migrates its tables, deletes the remains of crashes (half-written uploads
    /// and blobs that no row refers to), and queues the ingests of captures from before ingests
    /// existed.
    ///
    /// # Errors
    /// [`crate::Error::DataDirInUse`] if another server has it open; database and file errors.
    pub async fn open(options: Options) -> Result<Self> {
        tokio::fs::create_dir_all(&options.data_dir).await?;
        let database = Database::open(&options.data_dir).await?;
        let armed = Arc::new(Armed::default());
        let blobs = Blobs::open(&options.data_dir.join("blobs"), armed.clone()).await?;
        let (changes, _) = broadcast::channel(1024);
        let queued = Notify::new();
        let (clock, seats) = (options.clock, Seats::default());
        let inner = Inner { database, blobs, clock, changes, queued, armed, seats };
        let store = Self { inner: Arc::new(inner) };
        store.collect_garbage().await?;
        store.uploads().collect_garbage().await?;
        store.captures().ingest_old().await?;
        Ok(store)
    }

    /// Captures.
    pub fn captures(&self) -> Captures<'_> {
        Captures { store: self }
    }

    /// Jobs: the queue.
    pub fn jobs(&self) -> Jobs<'_> {
        Jobs { store: self }
    }

    /// Twins.
    pub fn twins(&self) -> Twins<'_> {
        Twins { store: self }
    }

    /// Resumable uploads.
    pub fn uploads(&self) -> Uploads<'_> {
        Uploads { store: self }
    }

    /// Worker processes.
    pub fn workers(&self) -> Workers<'_> {
        Workers { store: self }
    }

    /// Content: uploads and downloads.
    pub fn blobs(&self) -> &Blobs {
        &self.inner.blobs
    }

    /// The time by the clock of leases.
    pub fn now(&self) -> Timestamp {
        self.inner.clock.now()
    }

    /// Checks that the database answers.
    ///
    /// # Errors
    /// If it does not.
    pub async fn ping(&self) -> Result<()> {
        sqlx::query("select 1").execute(self.inner.database.read()).await?;
        Ok(())
    }

    /// Closes the database. Work under way fails.
    pub async fn close(&self) {
        self.inner.database.close().await;
    }

    /// Deletes blobs that no row refers to, left by callers that went away in the middle of a call.
    /// Safe at any time.
    ///
    /// # Errors
    /// Database and file errors.
    pub async fn collect_garbage(&self) -> Result<()> {
        for digest in self.inner.blobs.list().await? {
            self.release(&digest).await?;
        }
        Ok(())
    }

    pub(crate) fn now_micros(&self) -> i64 {
        micros(self.now())
    }

    pub(crate) fn pass(&self, point: Failpoint) -> Result<()> {
        self.inner.armed.pass(point)
    }

    /// Deletes a blob unless a row refers to it.
    pub(crate) async fn release(&self, digest: &str) -> Result<()> {
        // Most are in use: do not bar others for those.
        if self.is_referred(digest).await? {
            return Ok(());
        }
        let _gate = self.inner.blobs.close_gate().await;
        if self.is_referred(digest).await? {
            return Ok(());
        }
        self.inner.blobs.delete(digest).await
    }

    async fn is_referred(&self, digest: &str) -> Result<bool> {
        let referred = sqlx::query_scalar(
            "select exists (select 1 from captures where digest = $1)
                 or exists (select 1 from twins where digest = $1)
                 or exists (select 1 from jobs where checkpoint = $1)
                 or exists (select 1 from observations where digest = $1)
                 or exists (select 1 from reports where json_digest = $1 or html_digest = $1)
                 or exists (select 1 from uploads where digest = $1)",
        );
        Ok(referred.bind(digest).fetch_one(self.inner.database.read()).await?)
    }
}

#[cfg(test)]
pub(crate) mod tests;
