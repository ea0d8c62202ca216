//! Uploads in a bucket, and among servers that share it.

use std::sync::Arc;

use super::*;
use crate::{
    ManualClock,
    blobs::PART,
    database::testing::{TestDatabase, own_bucket},
};

/// More than two parts, with bytes after them.
fn long() -> Vec<u8> {
    (0..2 * PART as u32 + 12_345).map(|i| (i % 251) as u8).collect()
}

async fn begin_long(bench: &Bench, declared: bool) -> UploadId {
    let content = long();
    let new = NewResumableUpload {
        request_id: None,
        expected_digest: declared.then(|| blake3::hash(&content)),
        length_bytes: Some(content.len() as u64),
        ..new("")
    };
    bench.store.uploads().create(new, BOUNDS).await.unwrap().id
}

/// Sends the bytes from the offset up to there.
async fn send(store: &Store, id: UploadId, to: usize) {
    let mut writer = store.uploads().claim(id, PATIENCE).await.unwrap();
    let from = writer.upload().offset_bytes as usize;
    for chunk in long()[from..to].chunks(700_001) {
        writer.write(&Bytes::copy_from_slice(chunk)).await.unwrap();
    }
    writer.commit(KEEP).await.unwrap();
    assert_eq!(writer.upload().offset_bytes, to as u64);
}

async fn finish_at(store: &Store, id: UploadId) -> Result<Capture> {
    let mut writer = store.uploads().claim(id, PATIENCE).await?;
    let content = writer.stage().await?;
    assert_eq!(content.head(7).await?, long()[..7]);
    store.captures().create(new_capture("rope", content)).await
}

/// A server in PostgreSQL and a bucket, if there are both.
async fn shared() -> Option<Bench> {
    On::postgres_or_skip()?;
    On::bucket_or_skip()?;
    let clock = Arc::new(ManualClock::default());
    clock.set(crate::store::clock::micros(jiff::Timestamp::now()));
    let dir = tempfile::tempdir().unwrap();
    let database = Some(TestDatabase::new().await);
    Some(Bench::begin(dir, clock, database, Some(own_bucket())).await)
}

#[tokio::test]
async fn any_server_resumes_an_upload() {
    let Some(bench) = shared().await else { return };
    let other = bench.second().await;
    for declared in [true, false] {
        let id = begin_long(&bench, declared).await;
        let stops = [1, PART - 1, PART + 1, 2 * PART, long().len()];
        for (nth, stop) in stops.into_iter().enumerate() {
            let store = if nth % 2 == 0 { &bench.store } else { &other.store };
            send(store, id, stop).await;
        }
        let capture = finish_at(&other.store, id).await.unwrap();
        assert!(content(&bench, &capture).await == long(), "declared: {declared}");
        assert!(bench.partials().await.is_empty());
        bench.store.captures().delete(capture.id).await.unwrap();
        assert_eq!(bench.blob_count().await, 0);
    }
}

/// Crashes after the last byte, of content that has parts.
#[tokio::test]
async fn parts_become_one_capture_despite_crashes() {
    let Some(on) = On::bucket_or_skip() else { return };
    for (point, declared) in [
        (Failpoint::ContentStaged, true),
        (Failpoint::ContentPublished, false),
        (Failpoint::BeforeCommit, true),
        (Failpoint::BeforeCommit, false),
    ] {
        let bench = Bench::new(on).await;
        let id = begin_long(&bench, declared).await;
        send(&bench.store, id, long().len()).await;
        bench.store.inner.armed.arm(point);
        finish_at(&bench.store, id).await.unwrap_err();
        let bench = bench.reopen().await;
        assert_eq!(bench.store.uploads().whole().await.unwrap(), [id]);
        let capture = finish_at(&bench.store, id).await.unwrap();
        assert!(content(&bench, &capture).await == long(), "{point:?}, declared: {declared}");
        let bench = bench.reopen().await;
        assert!(bench.partials().await.is_empty());
        assert_eq!(bench.blob_count().await, 1);
    }
}

#[tokio::test]
async fn an_upload_that_ends_leaves_nothing_in_the_bucket() {
    let Some(on) = On::bucket_or_skip() else { return };
    let bench = Bench::new(on).await;
    for declared in [true, false] {
        let id = begin_long(&bench, declared).await;
        send(&bench.store, id, 2 * PART).await;
        // What is not committed counts for nothing.
        let mut writer = claim(&bench, id).await;
        writer.write(&Bytes::from(vec![7; PART])).await.unwrap();
        writer.discard().await.unwrap();
        assert_eq!(writer.upload().offset_bytes, 2 * PART as u64);
        writer.end("enough", KEEP).await.unwrap();
        assert!(bench.partials().await.is_empty());
    }
    let parts = "select count(*) from upload_parts";
    let parts: i64 =
        query_scalar(parts).fetch_one(bench.store.inner.database.read()).await.unwrap();
    assert_eq!((parts, bench.blob_count().await), (0, 0));
}

#[tokio::test]
async fn a_server_that_waits_is_let_in_and_one_that_fell_silent_is_shut_out() {
    let Some(bench) = shared().await else { return };
    let other = bench.second().await;
    let id = begin_long(&bench, true).await;
    let mut first = claim(&bench, id).await;
    first.write(&Bytes::from_static(&[0])).await.unwrap();
    let stubborn = other.store.uploads().claim(id, Duration::from_millis(20)).await;
    assert!(matches!(stubborn, Err(Error::UploadLocked { .. })));
    let yields = async {
        first.wanted().await;
        first.commit(KEEP).await.unwrap();
        drop(first);
    };
    let uploads = other.store.uploads();
    let (second, ()) = tokio::join!(uploads.claim(id, PATIENCE), yields);
    let mut second = second.unwrap();
    assert_eq!(second.upload().offset_bytes, 1);
    second.write(&Bytes::from_static(&[9])).await.unwrap();
    // Its lease ends unrenewed; another writes on.
    bench.clock.advance(Duration::from_secs(11));
    send(&bench.store, id, 1000).await;
    let refused = second.commit(KEEP).await.unwrap_err();
    assert!(matches!(refused, Error::UploadLocked { .. }), "{refused}");
    drop(second);
    send(&other.store, id, long().len()).await;
    let capture = finish_at(&bench.store, id).await.unwrap();
    assert!(content(&bench, &capture).await == long());
}
