use std::{sync::Arc, time::Duration};

use bytes::Bytes;
use futures::TryStreamExt as _;

use super::*;
use crate::{
    Captures, Digest, ManualClock, ObjectsUrl,
    blobs::Place,
    database::testing::{On, TestDatabase, own_bucket},
    store::tests::{Bench, new_capture},
};

const CONTENT: &str = "contested";

fn digest() -> String {
    blake3::hash(CONTENT.as_bytes()).to_hex().to_string()
}

async fn stage(store: &Store) -> Staged {
    let mut upload = store.blobs().upload(1 << 20).await.unwrap();
    upload.write(Bytes::from_static(CONTENT.as_bytes())).await.unwrap();
    upload.finish(None).await.unwrap()
}

async fn is_there(store: &Store) -> bool {
    store.blobs().place().has(&digest()).await.unwrap()
}

/// A store in PostgreSQL, with content in a bucket if there is one, else in a folder, that another
/// server may use at the same time. The folder of content comes with it.
async fn shared() -> Option<(Bench, tempfile::TempDir)> {
    On::postgres_or_skip()?;
    let folder = tempfile::tempdir().unwrap();
    let url = match On::bucket_or_skip() {
        Some(_) => own_bucket(),
        None => ObjectsUrl::parse(&format!("file://{}", folder.path().display())).unwrap(),
    };
    Some((in_place(url).await, folder))
}

async fn in_place(url: ObjectsUrl) -> Bench {
    let clock = Arc::new(ManualClock::default());
    clock.set(crate::store::clock::micros(jiff::Timestamp::now()));
    let dir = tempfile::tempdir().unwrap();
    Bench::begin(dir, clock, Some(TestDatabase::new().await), Some(url)).await
}

#[tokio::test]
async fn content_without_a_row_stays_while_a_server_is_about_to_refer_to_it() {
    let Some((bench, _folder)) = shared().await else { return };
    let other = bench.second().await;
    let published = bench.store.publish(stage(&bench.store).await).await.unwrap();
    other.store.release(&digest()).await.unwrap();
    assert!(is_there(&bench.store).await);
    // A server that dies there leaves the arrival, which ends.
    std::mem::forget(published);
    bench.clock.advance(KEPT + KEPT);
    other.store.collect_garbage().await.unwrap();
    assert!(!is_there(&bench.store).await);
}

#[tokio::test]
async fn who_publishes_waits_for_a_deletion_under_way() {
    let Some((bench, _folder)) = shared().await else { return };
    let other = bench.second().await;
    drop(bench.store.publish(stage(&bench.store).await).await.unwrap());
    let deletion = loop {
        // The arrival goes in the background.
        if let Some(deletion) = other.store.begin_deletion(&digest()).await.unwrap() {
            break deletion;
        }
    };
    let again = stage(&bench.store).await;
    let publishing = bench.store.publish(again);
    tokio::pin!(publishing);
    let early = tokio::time::timeout(Duration::from_millis(300), &mut publishing).await;
    assert!(early.is_err(), "published into a deletion");
    other.store.finish_deletion(deletion).await.unwrap();
    let _published = publishing.await.unwrap();
    assert!(is_there(&bench.store).await, "deleted after it was published");
}

#[tokio::test]
async fn a_deletion_of_a_dead_server_is_taken_over_and_comes_to_nothing_there() {
    let Some((bench, _folder)) = shared().await else { return };
    let other = bench.second().await;
    let begun = bench.store.begin_deletion(&digest()).await.unwrap().unwrap();
    bench.clock.advance(TAKEN_OVER + Duration::from_secs(1));
    other.store.take_over_deletions(TAKEN_OVER).await.unwrap();
    let _published = other.store.publish(stage(&other.store).await).await.unwrap();
    // It was not dead after all, but comes too late.
    let late = Instant::now().checked_sub(LATEST + LATEST).unwrap();
    bench.store.finish_deletion(Deletion { began: late, ..begun }).await.unwrap();
    assert!(is_there(&other.store).await);
}

/// Two servers create and delete captures of the same content, while both search for garbage: the
/// content of every remaining capture exists.
#[tokio::test(flavor = "multi_thread", worker_threads = 4)]
async fn servers_that_share_content_never_lose_it() {
    let Some((bench, _folder)) = shared().await else { return };
    let other = bench.second().await;
    let race = async |store: &Store| {
        for round in 0..15 {
            let content = stage(store).await;
            let capture = store.captures().create(new_capture("", content)).await.unwrap();
            read(store.captures(), capture.id).await;
            if round % 5 == 0 {
                store.collect_garbage().await.unwrap();
            }
            store.captures().delete(capture.id).await.unwrap();
        }
    };
    tokio::join!(race(&bench.store), race(&other.store), race(&bench.store), race(&other.store));
}

async fn read(captures: Captures<'_>, id: bendtwin_core::ids::CaptureId) {
    let (_, content) = captures.content(id).await.unwrap();
    let bytes = content.chunks.try_collect::<Vec<_>>().await.unwrap().concat();
    assert_eq!(bytes, CONTENT.as_bytes());
}

/// Files of uploads, and the trash, of a folder that servers share.
#[tokio::test]
async fn a_server_that_starts_leaves_what_others_have_under_way_in_a_folder() {
    let Some(_) = On::postgres_or_skip() else { return };
    let folder = tempfile::tempdir().unwrap();
    let url = ObjectsUrl::parse(&format!("file://{}", folder.path().display())).unwrap();
    let bench = in_place(url).await;
    let staged = stage(&bench.store).await;
    let other = bench.second().await;
    let capture = bench.store.captures().create(new_capture("", staged)).await.unwrap();
    read(other.store.captures(), capture.id).await;
    // In the trash for a day, and taken back by a reader of the other server.
    let hex = Digest::from_hex(digest()).unwrap().to_hex();
    let Place::Folder(there) = bench.store.blobs().place() else { panic!("a folder") };
    there.discard(&hex, bench.store.now()).await.unwrap();
    assert!(!is_there(&bench.store).await);
    read(other.store.captures(), capture.id).await;
}
