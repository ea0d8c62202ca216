//! The store as a whole: opening, closing, and access to the aggregates.

pub(crate) mod clock;
pub(crate) mod identity;
pub(crate) mod meter;

use std::{path::PathBuf, sync::Arc, time::Duration};

use jiff::Timestamp;
use tokio::sync::{Notify, broadcast};

use self::clock::micros;
use crate::{
    Blobs, Captures, Clock, DatabaseUrl, Error, JobId, Jobs, Keys, ObjectsUrl, Owners, Projects,
    Result, Retention, Servers, SystemClock, Trash, Twins, Uploads, Usage, Workers,
    blobs::{Place, arrivals, files, own},
    database::{self, Database, Wakes, migrations},
    failpoint::{Armed, Failpoint},
    folder::{
        self,
        disk::{Disk, Reserve},
    },
    jobs::LeaseTimes,
    sql::{Transaction, query},
    store::meter::{Meter, Observer, Part},
    uploads::Seats,
};

/// Options for opening a store.
#[derive(Clone, Debug)]
pub struct Options {
    /// The folder of all data; made if missing.
    pub data_dir: PathBuf,
    /// The database, if it is PostgreSQL; else SQLite in the folder.
    pub database: Option<DatabaseUrl>,
    /// The place of content, if it is not the folder.
    pub objects: Option<ObjectsUrl>,
    /// The clocks: of rows, and of leases.
    pub clock: Arc<dyn Clock>,
    /// Receiver of measurements of the database and of the place of content, if there is one.
    pub observer: Option<Arc<dyn Observer>>,
}

impl Options {
    /// A folder with SQLite in it, and the system's clock.
    pub fn new(data_dir: impl Into<PathBuf>) -> Self {
        Self {
            data_dir: data_dir.into(),
            database: None,
            objects: None,
            clock: Arc::new(SystemClock),
            observer: None,
        }
    }
}

/// An open store. Clones share it.
#[derive(Clone, Debug)]
pub struct Store {
    pub(crate) inner: Arc<Inner>,
}

#[derive(Debug)]
pub(crate) struct Inner {
    data_dir: PathBuf,
    reserve: Arc<Reserve>,
    pub(crate) database: Database,
    pub(crate) blobs: Blobs,
    pub(crate) clock: Arc<dyn Clock>,
    /// Ids of jobs that changed.
    pub(crate) changes: broadcast::Sender<JobId>,
    /// Notified when a job enters the queue.
    pub(crate) queued: Arc<Notify>,
    /// Notified when a worker registers, goes or is to end, by any server.
    pub(crate) members: Arc<Notify>,
    pub(crate) armed: Arc<Armed>,
    /// Current writer of each resumable upload.
    pub(crate) seats: Seats,
    /// Name of this open store among the servers that share its database.
    pub(crate) instance: String,
    /// Ends of the leases of running jobs.
    pub(crate) leases: LeaseTimes,
}

impl Store {
    /// Opens the folder, migrates its tables, moves blobs that no row refers to into the trash,
    /// deletes half-written uploads, queues the ingests of captures from before ingests existed,
    /// and fills in what older rows are searched and sorted by.
    ///
    /// # Errors
    /// [`Error::DataDirInUse`] if another server has it open; [`Error::DatabaseMissing`],
    /// [`Error::DatabaseElsewhere`], [`Error::StoreNotMigrated`] and [`Error::StoreMismatch`] if
    /// database and blobs do not belong together; [`Error::IsBackup`], [`Error::RestoreUnfinished`]; [`Error::DatabaseDamaged`],
    /// [`Error::DatabaseUnavailable`], [`Error::DatabaseUnfit`]; [`Error::DatabaseNewer`],
    /// [`Error::OlderServersRun`]; database and file errors.
    pub async fn open(options: Options) -> Result<Self> {
        let Options { data_dir, database: url, objects, clock, observer } = options;
        let meter = |part| Meter::new(part, observer.clone());
        folder::make(&data_dir)?;
        database::require_settled(&data_dir)?;
        let lock = match url {
            None => database::lock(&data_dir)?,
            // Rows are shared with other servers, and their content may be in one folder.
            Some(_) => database::lock_shared(&data_dir).await?,
        };
        database::require_objects(&data_dir, objects.as_ref())?;
        let own = own(&data_dir);
        if objects.is_some() && files::any(&own)? {
            return Err(Error::ObjectsNotMigrated { folder: own });
        }
        let place = Place::open(objects.as_ref(), &data_dir, url.is_some(), meter(Part::Content))?;
        if url.is_none() {
            database::require_none(&data_dir)?;
            identity::require_database(&data_dir, &place).await?;
        }
        let reserve = Arc::new(Reserve::open(&data_dir));
        let of_database = meter(Part::Database);
        let database =
            Database::open(&data_dir, url.as_ref(), lock, reserve.clone(), of_database).await?;
        identity::require_content(&database, &place).await?;
        identity::settle(&database, &data_dir, &place, micros(clock.now())).await?;
        if let Some(url) = &url {
            database::leave_marker(&data_dir, url)?;
        }
        if let Some(objects) = &objects {
            database::leave_objects(&data_dir, objects)?;
        }
        let armed = Arc::new(Armed::default());
        let blobs = Blobs::open(place, &data_dir, armed.clone(), reserve.clone()).await?;
        database.share_folder()?;
        let (changes, _) = broadcast::channel(1024);
        let (seats, leases) = (Seats::default(), LeaseTimes::default());
        let (queued, members) = (Arc::new(Notify::new()), Arc::new(Notify::new()));
        let (of_queue, of_members) = (queued.clone(), members.clone());
        database.wake(Wakes { queued: of_queue, changes: changes.clone(), members: of_members });
        let inner = Inner {
            data_dir,
            reserve,
            database,
            blobs,
            clock,
            changes,
            queued,
            members,
            armed,
            seats,
            instance: uuid::Uuid::new_v4().to_string(),
            leases,
        };
        let store = Self { inner: Arc::new(inner) };
        if store.blobs().place().is_shared() {
            // Alone with its database, it has none under way.
            let remote = store.inner.database.is_remote();
            let age = if remote { arrivals::TAKEN_OVER } else { Duration::ZERO };
            store.take_over_deletions(age).await?;
        }
        if !store.is_shared() {
            store.forget_reservations().await?;
        }
        match store.collect_garbage().await {
            Err(Error::DiskFull) => tracing::warn!("unused content stays while the disk is full"),
            collected => collected?,
        }
        store.uploads().collect_garbage().await?;
        store.captures().ingest_old().await?;
        store.label_old().await?;
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

    /// The trash: what was deleted and can be restored.
    pub fn trash(&self) -> Trash<'_> {
        Trash { store: self }
    }

    /// Rules by which resources are deleted.
    pub fn retention(&self) -> Retention<'_> {
        Retention { store: self }
    }

    /// Resumable uploads.
    pub fn uploads(&self) -> Uploads<'_> {
        Uploads { store: self }
    }

    /// Worker processes.
    pub fn workers(&self) -> Workers<'_> {
        Workers { store: self }
    }

    /// Server processes.
    pub fn servers(&self) -> Servers<'_> {
        Servers { store: self }
    }

    /// True if other servers may have the database open, too.
    pub fn is_shared(&self) -> bool {
        self.inner.database.is_remote()
    }

    /// Waits until a worker registered, went or was asked to end, at any server; at most until the
    /// connection to the database broke and came back.
    pub async fn members_changed(&self) {
        self.inner.members.notified().await;
    }

    /// Keys of clients.
    pub fn keys(&self) -> Keys<'_> {
        Keys { store: self }
    }

    /// Projects of owners.
    pub fn projects(&self) -> Projects<'_> {
        Projects { store: self }
    }

    /// Owners of resources.
    pub fn owners(&self) -> Owners<'_> {
        Owners { store: self }
    }

    /// What is stored and under way by owner.
    pub fn usage(&self) -> Usage<'_> {
        Usage { store: self }
    }

    /// Content: uploads and downloads.
    pub fn blobs(&self) -> &Blobs {
        &self.inner.blobs
    }

    /// The time of day.
    pub fn now(&self) -> Timestamp {
        self.inner.clock.now()
    }

    /// The time by which leases end: the time for which [`Jobs::sweep`] saw this process run,
    /// unaffected by changes of the time of day, and with hardly any of the time in which the
    /// process stood still.
    pub fn lease_time(&self) -> Duration {
        self.inner.leases.now(self.inner.clock.monotonic())
    }

    /// Checks that the database answers.
    ///
    /// # Errors
    /// If it does not.
    pub async fn ping(&self) -> Result<()> {
        query("select 1").execute(self.inner.database.read()).await?;
        Ok(())
    }

    /// Proves that a change can be made to last, by making one in the database and one among the
    /// blobs. Also restores the reserve of a disk that was full.
    ///
    /// # Errors
    /// [`Error::DiskFull`] while new content is refused; [`Error::DatabaseNewer`]; database and file
    /// errors.
    pub async fn probe_write(&self) -> Result<()> {
        let mut tx = self.inner.database.write().await?;
        migrations::newer(&mut tx).await?;
        query("update store set probed_at = $1 where id = 1")
            .bind(self.now_micros())
            .execute(&mut tx)
            .await?;
        tx.commit().await?;
        self.admit()?;
        self.inner.blobs.probe().await
    }

    /// Space of the disk that has the data folder.
    ///
    /// # Errors
    /// If the system does not report it.
    pub fn disk(&self) -> Result<Disk> {
        Disk::of(&self.inner.data_dir)
    }

    /// Refuses what would grow on a full disk.
    pub(crate) fn admit(&self) -> Result<()> {
        self.inner.reserve.admit()
    }

    /// Closes the database. Work under way fails.
    pub async fn close(&self) {
        self.inner.database.close().await;
    }

    pub(crate) fn now_micros(&self) -> i64 {
        micros(self.now())
    }

    /// The database's time in a transaction [us], by which all servers that use it measure leases;
    /// `None` if the database has no clock.
    pub(crate) fn database_time(&self, tx: &Transaction) -> Option<i64> {
        tx.database_time().filter(|_| !self.inner.clock.is_simulated())
    }

    /// End of a lease that begins in this transaction [us].
    pub(crate) fn lease_until(&self, tx: &Transaction, lease: Duration) -> i64 {
        let lease = i64::try_from(lease.as_micros()).unwrap_or(i64::MAX);
        self.database_time(tx).unwrap_or_else(|| self.now_micros()).saturating_add(lease)
    }

    pub(crate) fn pass(&self, point: Failpoint) -> Result<()> {
        self.inner.armed.pass(point)
    }
}

#[cfg(test)]
pub(crate) mod tests;
