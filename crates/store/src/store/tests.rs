//! Opening, locking, and recovery from a crash at every failpoint.

use std::{sync::Arc, time::Duration};

use bendtwin_core::ids::{UploadId, WorkerId};
use bytes::Bytes;
use futures::TryStreamExt as _;

use crate::{
    Capture, CaptureFacts, Creator, DatabaseUrl, Digest, Error, Job, Kind, Lease, LeaseTerms,
    ManualClock, NewCapture, NewFit, ObjectsUrl, Options, Requirements, Staged, State, Store,
    TwinFacts, WorkerEnd,
    blobs::{Place, published},
    database::testing::{On, TestDatabase, on_both},
    failpoint::Failpoint,
    sql,
};

on_both! {
    one_server_per_folder_of_sqlite,
    captures_survive_crashes_whole,
    completion_survives_crashes,
    checkpoints_survive_crashes,
}

pub(crate) const LEASE: Duration = Duration::from_secs(30);
pub(crate) const TERMS: LeaseTerms = LeaseTerms { lease: LEASE, step: Duration::from_secs(2) };

/// A store in a temporary folder, with a stopped clock.
pub(crate) struct Bench {
    pub(crate) dir: tempfile::TempDir,
    pub(crate) clock: Arc<ManualClock>,
    pub(crate) store: Store,
    /// Database, if that is not in the folder.
    pub(crate) postgres: Option<TestDatabase>,
    /// The place of content, if that is not in the folder.
    pub(crate) objects: Option<ObjectsUrl>,
}

/// Another server beside that of a bench.
pub(crate) struct Second {
    pub(crate) store: Store,
    _dir: tempfile::TempDir,
}

impl Bench {
    pub(crate) async fn new(on: On) -> Self {
        let dir = tempfile::tempdir().unwrap();
        let clock = Arc::new(ManualClock::default());
        if on == On::Bucket {
            // Its objects have the true time.
            clock.set(super::clock::micros(jiff::Timestamp::now()));
        }
        let postgres = match on {
            On::Sqlite | On::Bucket => None,
            On::Postgres => Some(TestDatabase::new().await),
        };
        Self::begin(dir, clock, postgres, on.objects()).await
    }

    /// A store with rows and content in these places.
    pub(crate) async fn begin(
        dir: tempfile::TempDir,
        clock: Arc<ManualClock>,
        postgres: Option<TestDatabase>,
        objects: Option<ObjectsUrl>,
    ) -> Self {
        let database = postgres.as_ref().map(|database| database.url.clone());
        let data_dir = dir.path().to_owned();
        let options = Options {
            data_dir,
            database,
            objects: objects.clone(),
            clock: clock.clone(),
            observer: None,
        };
        let store = Store::open(options).await.unwrap();
        Self { dir, clock, store, postgres, objects }
    }

    /// Another server with the same database and the same place of content.
    pub(crate) async fn second(&self) -> Second {
        let dir = tempfile::tempdir().unwrap();
        let options = Options {
            data_dir: dir.path().to_owned(),
            database: self.url(),
            objects: self.objects.clone(),
            clock: self.clock.clone(),
            observer: None,
        };
        Second { store: Store::open(options).await.unwrap(), _dir: dir }
    }

    /// The URL of its database, if that is not in the folder.
    pub(crate) fn url(&self) -> Option<DatabaseUrl> {
        self.postgres.as_ref().map(|database| database.url.clone())
    }

    /// The store as a process sees it that starts after this one has died.
    pub(crate) async fn reopen(self) -> Self {
        self.store.close().await;
        let Self { dir, clock, store, postgres, objects } = self;
        drop(store);
        Self::begin(dir, clock, postgres, objects).await
    }

    /// An attempt to open the store once more.
    pub(crate) async fn opened(&self) -> crate::Result<Store> {
        self.store.close().await;
        let (database, objects) = (self.url(), self.objects.clone());
        let data_dir = self.dir.path().to_owned();
        let clock = self.clock.clone();
        Store::open(Options { data_dir, database, objects, clock, observer: None }).await
    }

    /// The folder alone, after the process has died.
    pub(crate) async fn close(self) -> tempfile::TempDir {
        self.store.close().await;
        self.dir
    }

    /// Runs a statement.
    pub(crate) async fn tell(&self, statement: sql::Query) {
        let mut tx = self.store.inner.database.write().await.unwrap();
        statement.execute(&mut tx).await.unwrap();
        tx.commit().await.unwrap();
    }

    pub(crate) async fn stage(&self, content: &'static str) -> Staged {
        let mut upload = self.store.blobs().upload(1 << 20).await.unwrap();
        upload.write(Bytes::from_static(content.as_bytes())).await.unwrap();
        upload.finish(None).await.unwrap()
    }

    /// A capture whose ingest waits for a worker.
    pub(crate) async fn fresh_capture(&self, content: &'static str) -> Capture {
        let content = self.stage(content).await;
        self.store.captures().create(new_capture("a rope", content)).await.unwrap()
    }

    /// A capture whose ingest has ended.
    pub(crate) async fn capture(&self, content: &'static str) -> Capture {
        let capture = self.fresh_capture(content).await;
        let mut tx = self.store.inner.database.write().await.unwrap();
        let ended = "update jobs set state = 'succeeded' where capture = $1 and kind = 'ingest'";
        crate::sql::query(ended)
            .bind(capture.id.uuid().to_string())
            .execute(&mut tx)
            .await
            .unwrap();
        tx.commit().await.unwrap();
        capture
    }

    pub(crate) async fn claim(&self, kind: Kind) -> Option<Job> {
        self.store.jobs().claim(kind, WorkerId::generate(), LEASE).await.unwrap()
    }

    /// Ends the leases that have run out by now.
    pub(crate) async fn sweep(&self) -> Vec<Job> {
        self.store.jobs().sweep(TERMS, |_| Some(WorkerEnd::Lost)).await.unwrap()
    }

    /// Lets time pass in the steps of a server that runs; returns the jobs whose leases ran out.
    pub(crate) async fn pass(&self, time: Duration) -> Vec<Job> {
        let mut swept = self.sweep().await;
        for _ in 0..time.as_secs() {
            self.clock.advance(Duration::from_secs(1));
            swept.extend(self.sweep().await);
        }
        swept
    }

    /// Waits until no publication keeps content: a separate task releases it.
    pub(crate) async fn no_arrivals(&self) {
        loop {
            let left = sql::query_scalar("select count(*) from arrivals");
            let left: i64 = left.fetch_one(self.store.inner.database.read()).await.unwrap();
            if left == 0 {
                return;
            }
            tokio::task::yield_now().await;
        }
    }

    pub(crate) async fn blob_count(&self) -> usize {
        let place = self.store.blobs().place();
        if place.is_shared() {
            // What no row refers to goes by its age there.
            const DAYS: i64 = 2 * 86_400_000_000;
            self.clock.set(DAYS);
            self.store.collect_garbage().await.unwrap();
            self.clock.set(-DAYS);
        }
        self.published_count().await
    }

    /// Current number of blobs, including those that no row refers to.
    pub(crate) async fn published_count(&self) -> usize {
        match self.store.blobs().place() {
            Place::Folder(folder) => folder.list().await.unwrap().len(),
            Place::Bucket(bucket) => {
                bucket.published().try_collect::<Vec<_>>().await.unwrap().len()
            }
        }
    }

    /// Puts other bytes in the place of a blob, or none.
    pub(crate) async fn damage(&self, digest: &Digest, bytes: Option<Vec<u8>>) {
        let hex = digest.to_hex();
        match (self.store.blobs().place(), bytes) {
            (Place::Folder(folder), Some(bytes)) => {
                std::fs::write(folder.file(&hex), bytes).unwrap();
            }
            (Place::Folder(folder), None) => std::fs::remove_file(folder.file(&hex)).unwrap(),
            (Place::Bucket(bucket), Some(bytes)) => {
                bucket.put(&published(&hex), bytes).await.unwrap();
            }
            (Place::Bucket(bucket), None) => bucket.delete(&published(&hex)).await.unwrap(),
        }
    }

    /// Uploads with stored content.
    pub(crate) async fn partials(&self) -> Vec<UploadId> {
        match self.store.blobs().place() {
            Place::Folder(folder) => folder.partials().await.unwrap(),
            Place::Bucket(bucket) => bucket.partials().await.unwrap(),
        }
    }
}

pub(crate) fn new_capture(name: &str, content: Staged) -> NewCapture {
    let (display_name, ingest) = (name.to_owned(), "{}".to_owned());
    NewCapture {
        facts: CaptureFacts { display_name, ingest, ..CaptureFacts::default() },
        request_id: None,
        content,
        creator: Creator::default(),
        trace_parent: None,
    }
}

pub(crate) fn lease_of(job: &Job) -> Lease {
    job.lease().unwrap()
}

pub(crate) fn new_fit(capture: &Capture) -> NewFit {
    NewFit {
        capture: capture.id,
        settings: "{}".to_owned(),
        priority: 0,
        request_id: None,
        trace_parent: None,
        display_name: String::new(),
        creator: Creator::default(),
        requirements: Requirements::default(),
    }
}

/// A folder with SQLite belongs to one server. A folder whose rows are in PostgreSQL may have
/// several, but no repair beside them.
async fn one_server_per_folder_of_sqlite(on: On) {
    let bench = Bench::new(on).await;
    let upload = bench.store.blobs().upload(1).await.unwrap();
    let second = Options {
        data_dir: bench.dir.path().to_owned(),
        database: bench.url(),
        objects: bench.objects.clone(),
        clock: bench.clock.clone(),
        observer: None,
    };
    let second = Store::open(second).await;
    if bench.postgres.is_none() {
        assert!(matches!(second, Err(Error::DataDirInUse)));
    } else {
        // What the first one receives is not swept away.
        upload.finish(None).await.unwrap();
        second.unwrap().close().await;
        let repaired = crate::maintenance::repair(bench.dir.path()).await;
        assert!(matches!(repaired, Err(Error::DataDirInUse | Error::DatabaseElsewhere { .. })));
    }
    bench.reopen().await.store.ping().await.unwrap();
}

/// A crash at any point of a capture's life: afterwards it is either complete or absent, and no
/// content is left over.
async fn captures_survive_crashes_whole(on: On) {
    for point in Failpoint::ALL {
        let bench = Bench::new(on).await;
        let kept = bench.capture("kept").await;
        let doomed = bench.capture("doomed").await;
        let content = bench.stage("new").await;
        bench.store.inner.armed.arm(point);
        let new = new_capture("new", content);
        let created = bench.store.captures().create(new).await.is_ok();
        let _ = bench.store.captures().delete(doomed.id).await;

        let bench = bench.reopen().await;
        bench.store.captures().content(kept.id).await.unwrap();
        let rows = bench.store.captures().list(&Default::default()).await.unwrap().items;
        for row in &rows {
            bench.store.captures().content(row.id).await.unwrap();
        }
        assert_eq!(bench.blob_count().await, rows.len(), "{point:?}");
        let is_there = rows.iter().any(|c| c.labels.display_name == "new");
        assert_eq!(is_there, created || point == Failpoint::AfterCommit, "{point:?}");
    }
}

/// A crash at any point of a completion: the worker repeats its call, and there is one twin.
async fn completion_survives_crashes(on: On) {
    for point in Failpoint::ALL {
        let bench = Bench::new(on).await;
        let capture = bench.capture("capture").await;
        let fit = bench.store.jobs().create_fit(new_fit(&capture)).await.unwrap();
        let lease = lease_of(&bench.claim(Kind::Fit).await.unwrap());
        let checkpoint = bench.stage("checkpoint").await;
        bench.store.jobs().save_checkpoint(lease, checkpoint, LEASE).await.unwrap();

        let twin = bench.stage("twin").await;
        bench.store.inner.armed.arm(point);
        let facts = TwinFacts { quality: "{}".into(), ..TwinFacts::default() };
        assert!(bench.store.jobs().complete_fit(lease, &facts, twin).await.is_err(), "{point:?}");

        let bench = bench.reopen().await;
        let twin = bench.stage("twin").await;
        let twin = bench.store.jobs().complete_fit(lease, &facts, twin).await.unwrap();
        let fit = bench.store.jobs().get(fit.id).await.unwrap();
        assert_eq!((fit.state, fit.twin), (State::Succeeded, Some(twin)), "{point:?}");
        let twins = bench.store.twins().list(&Default::default()).await.unwrap().items;
        assert_eq!(twins.len(), 1, "{point:?}");
        bench.store.twins().content(twin).await.unwrap();
        // The checkpoint is gone with the job's end, at the latest at the next start.
        assert_eq!(bench.reopen().await.blob_count().await, 2, "{point:?}");
    }
}

/// A crash while a checkpoint is stored: the job has the old or the new one, whole.
async fn checkpoints_survive_crashes(on: On) {
    for point in Failpoint::ALL {
        let bench = Bench::new(on).await;
        let capture = bench.capture("capture").await;
        let fit = bench.store.jobs().create_fit(new_fit(&capture)).await.unwrap();
        let lease = lease_of(&bench.claim(Kind::Fit).await.unwrap());
        let old = bench.stage("old").await;
        bench.store.jobs().save_checkpoint(lease, old, LEASE).await.unwrap();
        let new = bench.stage("new").await;
        bench.store.inner.armed.arm(point);
        let _ = bench.store.jobs().save_checkpoint(lease, new, LEASE).await;

        let bench = bench.reopen().await;
        bench.store.jobs().checkpoint(fit.id).await.unwrap();
        assert_eq!(bench.blob_count().await, 2, "{point:?}");
    }
}
