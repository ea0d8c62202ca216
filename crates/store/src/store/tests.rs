//! Opening, locking, and what crashes at every failpoint leave behind.

use std::{sync::Arc, time::Duration};

use bendtwin_core::ids::WorkerId;
use bytes::Bytes;

use crate::{
    Capture, Clock, Error, Lease, ManualClock, NewCapture, NewFit, Options, Staged, State, Store,
    TwinFacts, failpoint::Failpoint,
};

pub(crate) const LEASE: Duration = Duration::from_secs(30);

/// A store in a folder of its own, on a clock that stands still.
pub(crate) struct Bench {
    pub(crate) dir: tempfile::TempDir,
    pub(crate) clock: Arc<ManualClock>,
    pub(crate) store: Store,
}

impl Bench {
    pub(crate) async fn new() -> Self {
        let dir = tempfile::tempdir().unwrap();
        let clock = Arc::new(ManualClock::default());
        let store = open(dir.path(), clock.clone()).await.unwrap();
        Self { dir, clock, store }
    }

    /// What a process sees that starts after this one died.
    pub(crate) async fn reopen(self) -> Self {
        self.store.close().await;
        drop(self.store);
        let store = open(self.dir.path(), self.clock.clone()).await.unwrap();
        Self { store, ..self }
    }

    pub(crate) async fn stage(&self, content: &'static str) -> Staged {
        let mut upload = self.store.blobs().upload(1 << 20).await.unwrap();
        upload.write(Bytes::from_static(content.as_bytes())).await.unwrap();
        upload.finish(None).await.unwrap()
    }

    pub(crate) async fn capture(&self, content: &'static str) -> Capture {
        let new = NewCapture {
            display_name: content.to_owned(),
            request_id: None,
            content: self.stage(content).await,
        };
        self.store.captures().create(new).await.unwrap()
    }

    pub(crate) async fn blob_count(&self) -> usize {
        self.store.blobs().list().await.unwrap().len()
    }
}

async fn open(dir: &std::path::Path, clock: Arc<dyn Clock>) -> crate::Result<Store> {
    Store::open(Options { data_dir: dir.to_owned(), clock }).await
}

pub(crate) fn new_fit(capture: &Capture) -> NewFit {
    NewFit {
        capture: capture.id,
        settings: "{}".to_owned(),
        priority: 0,
        request_id: None,
        trace_parent: None,
    }
}

#[tokio::test]
async fn one_server_per_folder() {
    let bench = Bench::new().await;
    let second = open(bench.dir.path(), bench.clock.clone()).await;
    assert!(matches!(second, Err(Error::DataDirInUse)));
    bench.reopen().await.store.ping().await.unwrap();
}

/// A crash at any point of a capture's life: afterwards it is either wholly
/// there or wholly gone, and no content is left over.
#[tokio::test]
async fn captures_survive_crashes_whole() {
    for point in Failpoint::ALL {
        let bench = Bench::new().await;
        let kept = bench.capture("kept").await;
        let doomed = bench.capture("doomed").await;
        let content = bench.stage("new").await;
        bench.store.inner.armed.arm(point);
        let new = NewCapture { display_name: "new".into(), request_id: None, content };
        let created = bench.store.captures().create(new).await.is_ok();
        let _ = bench.store.captures().delete(doomed.id).await;

        let bench = bench.reopen().await;
        bench.store.captures().content(kept.id).await.unwrap();
        let rows = bench.store.captures().list(&Default::default()).await.unwrap().items;
        for row in &rows {
            bench.store.captures().content(row.id).await.unwrap();
        }
        assert_eq!(bench.blob_count().await, rows.len(), "{point:?}");
        let is_there = rows.iter().any(|c| c.display_name == "new");
        assert_eq!(is_there, created || point == Failpoint::AfterCommit, "{point:?}");
    }
}

/// A crash at any point of a completion: the worker asks again, and there is one twin.
#[tokio::test]
async fn completion_survives_crashes() {
    for point in Failpoint::ALL {
        let bench = Bench::new().await;
        let capture = bench.capture("capture").await;
        let fit = bench.store.fits().create(new_fit(&capture)).await.unwrap();
        let worker = WorkerId::generate();
        let epoch = bench.store.fits().claim(worker, LEASE).await.unwrap().unwrap().lease_epoch;
        let lease = Lease { fit: fit.id, epoch };
        let checkpoint = bench.stage("checkpoint").await;
        bench.store.fits().save_checkpoint(lease, checkpoint, LEASE).await.unwrap();

        let twin = bench.stage("twin").await;
        bench.store.inner.armed.arm(point);
        let facts = TwinFacts { quality: "{}".into(), ..TwinFacts::default() };
        assert!(bench.store.fits().complete(lease, &facts, twin).await.is_err(), "{point:?}");

        let bench = bench.reopen().await;
        let twin = bench.stage("twin").await;
        let twin = bench.store.fits().complete(lease, &facts, twin).await.unwrap();
        let fit = bench.store.fits().get(fit.id).await.unwrap();
        assert_eq!((fit.state, fit.twin), (State::Succeeded, Some(twin)), "{point:?}");
        let twins = bench.store.twins().list(&Default::default(), None).await.unwrap().items;
        assert_eq!(twins.len(), 1, "{point:?}");
        bench.store.twins().content(twin).await.unwrap();
        // The checkpoint is gone with the job's end, at the latest at the next start.
        assert_eq!(bench.reopen().await.blob_count().await, 2, "{point:?}");
    }
}

/// A crash while a checkpoint is stored: the job has the old or the new one, whole.
#[tokio::test]
async fn checkpoints_survive_crashes() {
    for point in Failpoint::ALL {
        let bench = Bench::new().await;
        let capture = bench.capture("capture").await;
        let fit = bench.store.fits().create(new_fit(&capture)).await.unwrap();
        let claimed = bench.store.fits().claim(WorkerId::generate(), LEASE).await.unwrap().unwrap();
        let lease = Lease { fit: fit.id, epoch: claimed.lease_epoch };
        let old = bench.stage("old").await;
        bench.store.fits().save_checkpoint(lease, old, LEASE).await.unwrap();
        let new = bench.stage("new").await;
        bench.store.inner.armed.arm(point);
        let _ = bench.store.fits().save_checkpoint(lease, new, LEASE).await;

        let bench = bench.reopen().await;
        bench.store.fits().checkpoint(fit.id).await.unwrap();
        assert_eq!(bench.blob_count().await, 2, "{point:?}");
    }
}
