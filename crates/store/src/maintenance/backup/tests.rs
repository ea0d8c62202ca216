use bytes::Bytes;

use super::*;
use crate::{
    Capture, Options, Store,
    database::testing::{On, on_both},
    maintenance::{
        Depth, check, restore,
        source::Source,
        tests::{content, file, half_way, observed},
    },
    store::tests::{Bench, new_capture},
};

on_both! {
    a_backup_beside_a_busy_server_is_complete,
    what_a_backup_is_about_to_copy_is_not_deleted,
}

pub(crate) fn site(bench: &Bench) -> Site {
    Site { database: bench.url(), objects: bench.objects.clone(), ..Site::new(bench.dir.path()) }
}

/// Captures come and go all the time while the backup is made.
async fn a_backup_beside_a_busy_server_is_complete(on: On) {
    let bench = Bench::new(on).await;
    let kept = observed(&bench, "archive").await;
    half_way(&bench, &kept).await;
    let store = bench.store.clone();
    let busy = tokio::spawn(async move {
        let mut last: Option<Capture> = None;
        for number in 0_u64.. {
            let mut upload = store.blobs().upload(1 << 20).await.unwrap();
            upload.write(Bytes::from(number.to_string())).await.unwrap();
            let content = upload.finish(None).await.unwrap();
            let new = store.captures().create(new_capture("", content)).await.unwrap();
            if let Some(old) = last.replace(new) {
                store.captures().delete(old.id).await.unwrap();
            }
        }
    });
    let folders = tempfile::tempdir().unwrap();
    let to = folders.path().join("backup");
    for number in 0..4 {
        let done = backup(&site(&bench), &to).await.unwrap();
        assert!(done.lost.is_empty(), "{done:?}");
        let found = check(&to, Depth::Digests).await.unwrap();
        assert!(found.is_sound() && found.unreferenced.is_empty(), "{found:?}");
        assert_eq!(found.blobs, done.blobs);
        assert!(number == 0 || done.brought < done.blobs, "the rest was there: {done:?}");
        let target = folders.path().join(number.to_string());
        let restored = restore(&to, &Site::new(&target)).await.unwrap();
        assert!(restored.lost.is_empty() && restored.blobs == done.blobs, "{restored:?}");
        let store = Store::open(Options::new(&target)).await.unwrap();
        assert_eq!(content(&store, kept.id).await.unwrap(), 7);
        store.close().await;
    }
    busy.abort();
}

/// A deletion between the snapshot and the copy, as of content that takes long to copy.
async fn what_a_backup_is_about_to_copy_is_not_deleted(on: On) {
    let bench = Bench::new(on).await;
    let capture = bench.capture("archive").await;
    let digest = capture.digest.to_hex().to_string();
    bench.no_arrivals().await;
    let mut source = Source::open(&site(&bench)).await.unwrap();
    let wanted = source.snapshot(&BTreeMap::new()).await.unwrap();
    assert_eq!(wanted.iter().map(|r| &r.digest).collect::<Vec<_>>(), [&digest]);
    bench.store.captures().delete(capture.id).await.unwrap();
    assert!(source.place.has(&digest).await.unwrap(), "the snapshot refers to it");
    source.close().await.unwrap();
    bench.store.collect_garbage().await.unwrap();
    assert_eq!(bench.blob_count().await, 0, "once the backup has ended, it is garbage");
}

#[tokio::test]
async fn a_folder_is_brought_up_to_date_and_whole_at_every_moment() {
    let bench = Bench::new(On::Sqlite).await;
    let first = bench.capture("archive").await;
    let second = bench.capture("another").await;
    fs::write(bench.dir.path().join(CLIENT_TOKEN), "the token").unwrap();
    let folders = tempfile::tempdir().unwrap();
    let to = folders.path().join("backup");
    let done = backup(&site(&bench), &to).await.unwrap();
    assert_eq!((done.blobs, done.brought, done.client_token), (2, 2, true));

    bench.store.captures().delete(second.id).await.unwrap();
    let third = bench.capture("a third").await;
    // Killed before the new database took the place of the old one.
    fs::write(to.join("database.partial"), "half").unwrap();
    fs::write(file(&to, "a third").with_extension("partial"), "half")
        .or_else(|_| {
            fs::create_dir_all(file(&to, "a third").parent().unwrap())?;
            fs::write(file(&to, "a third").with_extension("partial"), "half")
        })
        .unwrap();
    let target = folders.path().join("earlier");
    restore(&to, &Site::new(&target)).await.unwrap();
    let store = Store::open(Options::new(&target)).await.unwrap();
    assert_eq!(content(&store, second.id).await.unwrap(), 7);
    store.close().await;

    let done = backup(&site(&bench), &to).await.unwrap();
    assert_eq!((done.blobs, done.brought), (2, 1));
    assert!(!file(&to, "another").exists() && file(&to, "archive").exists());
    let target = folders.path().join("later");
    let restored = restore(&to, &Site::new(&target)).await.unwrap();
    assert!(restored.client_token);
    assert_eq!(fs::read_to_string(target.join(CLIENT_TOKEN)).unwrap(), "the token");
    for folder in [&to, &target] {
        use std::os::unix::fs::PermissionsExt as _;
        let mode = fs::metadata(folder.join(CLIENT_TOKEN)).unwrap().permissions().mode();
        assert_eq!(mode & 0o777, 0o600);
    }
    let store = Store::open(Options::new(&target)).await.unwrap();
    assert_eq!(content(&store, third.id).await.unwrap(), 7);
    assert_eq!(content(&store, first.id).await.unwrap(), 7);
    store.close().await;

    // Nothing but a backup of the same store, and no server works in it.
    let restored = backup(&Site::new(&target), &to).await.unwrap_err();
    assert!(matches!(restored, Error::BackupOfAnother { .. }), "{restored}");
    let other = backup(&site(&bench), folders.path()).await.unwrap_err();
    assert!(matches!(other, Error::BackupNotEmpty { .. }), "{other}");
    let started = Store::open(Options::new(&to)).await.unwrap_err();
    assert!(matches!(started, Error::IsBackup { .. }), "{started}");
    let source = backup(&Site::new(&to), &folders.path().join("second")).await.unwrap_err();
    assert!(matches!(source, Error::IsBackup { .. }), "{source}");
}

#[tokio::test]
async fn a_backup_names_what_the_store_lacks() {
    let bench = Bench::new(On::Sqlite).await;
    bench.capture("archive").await;
    bench.capture("another").await;
    fs::remove_file(file(bench.dir.path(), "another")).unwrap();
    let to = tempfile::tempdir().unwrap();
    let done = backup(&site(&bench), to.path()).await.unwrap();
    assert_eq!((done.blobs, done.lost.len()), (1, 1));
    assert_eq!(done.lost[0].fault, "missing");
}

#[tokio::test]
async fn a_store_that_is_not_there_is_said_to_be_missing_and_not_made() {
    let folder = tempfile::tempdir().unwrap();
    let (site, to) = (Site::new(folder.path().join("none")), folder.path().join("backup"));
    let missing = backup(&site, &to).await.unwrap_err();
    assert!(matches!(missing, Error::NotFound { .. }), "{missing}");
    assert!(!site.data_dir.exists() && !to.exists());
}
