//! Opening, locking, and recovery from a crash at every failpoint.

use std::{sync::Arc, time::Duration};

use bendtwin_core::ids::WorkerId;
use bytes::Bytes;

use crate::{
    Capture, Clock, Creator, DatabaseUrl, Error, Job, Kind, Lease, LeaseTerms, Loss, ManualClock,
    NewCapture, NewFit, Options, Requirements, Staged, State, Store, TwinFacts,
    failpoint::Failpoint,
    sql,
    test_database::{On, TestDatabase, on_both},
};

on_both! {
    one_server_per_folder_of_sqlite,
    captures_survive_crashes_whole,
    completion_survives_crashes,
    checkpoints_survive_crashes,
}

pub(crate) const LEASE: Duration = Duration::from_secs(30);
pub(crate) const TERMS: LeaseTerms = LeaseTerms { lease: LEASE, step: Duration::from_secs(2) };

/// A store in a folder of its own, with a stopped clock.
pub(crate) struct Bench {
    pub(crate) dir: tempfile::TempDir,
    pub(crate) clock: Arc<ManualClock>,
    pub(crate) store: Store,
    /// Its database, if that is not in the folder.
    pub(crate) postgres: Option<TestDatabase>,
}

impl Bench {
    pub(crate) async fn new(on: On) -> Self {
        let dir = tempfile::tempdir().unwrap();
        let clock = Arc::new(ManualClock::default());
        let postgres = match on {
            On::Sqlite => None,
            On::Postgres => Some(TestDatabase::new().await),
        };
        let url = postgres.as_ref().map(|database| database.url.clone());
        let store = open(dir.path(), url, clock.clone()).await.unwrap();
        Self { dir, clock, store, postgres }
    }

    /// The URL of its database, if that is not in the folder.
    pub(crate) fn url(&self) -> Option<DatabaseUrl> {
        self.postgres.as_ref().map(|database| database.url.clone())
    }

    /// The store as a process sees it that starts after this one has died.
    pub(crate) async fn reopen(self) -> Self {
        self.store.close().await;
        let url = self.url();
        drop(self.store);
        let store = open(self.dir.path(), url, self.clock.clone()).await.unwrap();
        Self { store, ..self }
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
        self.store.jobs().sweep(TERMS, |_| Loss::Worker).await.unwrap()
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

    pub(crate) async fn blob_count(&self) -> usize {
        self.store.blobs().list().await.unwrap().len()
    }
}

async fn open(
    dir: &std::path::Path,
    database: Option<DatabaseUrl>,
    clock: Arc<dyn Clock>,
) -> crate::Result<Store> {
    Store::open(Options { data_dir: dir.to_owned(), database, clock }).await
}

pub(crate) fn new_capture(name: &str, content: Staged) -> NewCapture {
    let display_name = name.to_owned();
    let (request_id, ingest) = (None, "{}".to_owned());
    NewCapture { display_name, request_id, content, ingest, creator: Creator::default() }
}

pub(crate) fn lease_of(job: &Job) -> Lease {
    Lease { job: job.id, epoch: job.lease_epoch }
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

/// One server has a folder with SQLite. Several may have one whose rows are in PostgreSQL, and a
/// repair none of them.
async fn one_server_per_folder_of_sqlite(on: On) {
    let bench = Bench::new(on).await;
    let upload = bench.store.blobs().upload(1).await.unwrap();
    let second = open(bench.dir.path(), bench.url(), bench.clock.clone()).await;
    if on == On::Sqlite {
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
