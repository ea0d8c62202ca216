use std::{fs, path::Path, time::Duration};

use crate::{
    Error, Options, Store,
    blobs::files,
    database::{
        self,
        testing::{On, on_databases},
    },
    store::tests::Bench,
};

on_databases! {
    blobs_that_are_exchanged_beside_a_server_are_no_garbage,
    stores_from_before_identities_get_one,
    content_without_a_row_stays_in_the_trash_for_a_day,
}

async fn open(data_dir: &Path) -> crate::Result<Store> {
    Store::open(Options::new(data_dir)).await
}

fn move_database(from: &Path, to: &Path) {
    for suffix in ["", "-wal", "-shm"] {
        let name = format!("{}{suffix}", database::FILE);
        match fs::rename(from.join(&name), to.join(&name)) {
            Err(error) if error.kind() != std::io::ErrorKind::NotFound => panic!("{error}"),
            _ => {}
        }
    }
}

#[tokio::test]
async fn content_without_its_database_is_not_touched() {
    let bench = Bench::new(On::Sqlite).await;
    let capture = bench.capture("precious").await;
    let (dir, away) = (bench.close().await, tempfile::tempdir().unwrap());
    let data_dir = dir.path();
    move_database(data_dir, away.path());
    let refused = open(data_dir).await.unwrap_err();
    assert!(matches!(refused, Error::DatabaseMissing { .. }), "{refused}");
    assert!(refused.to_string().contains("bendtwin store repair"), "{refused}");
    assert!(!data_dir.join(database::FILE).exists(), "it must not stand in the way of the old one");
    // With the database back, everything works again.
    move_database(away.path(), data_dir);
    let store = open(data_dir).await.unwrap();
    store.captures().content(capture.id).await.unwrap();
}

#[tokio::test]
async fn a_database_beside_the_blobs_of_another_is_refused() {
    let (bench, other) = (Bench::new(On::Sqlite).await, Bench::new(On::Sqlite).await);
    bench.capture("precious").await;
    other.capture("another").await;
    let (dir, other) = (bench.close().await, other.close().await);
    move_database(other.path(), dir.path());
    for _ in 0..2 {
        let refused = open(dir.path()).await.unwrap_err();
        assert!(matches!(refused, Error::StoreMismatch { .. }), "{refused}");
        assert_eq!(files::all(&dir.path().join("blobs")).unwrap().len(), 1);
    }
    // Nor do they belong together where the blobs are too old to have an identity.
    fs::remove_file(dir.path().join("blobs/identity")).unwrap();
    let refused = open(dir.path()).await.unwrap_err();
    assert!(matches!(refused, Error::StoreMismatch { .. }), "{refused}");
}

async fn blobs_that_are_exchanged_beside_a_server_are_no_garbage(on: On) {
    let bench = Bench::new(on).await;
    fs::write(bench.dir.path().join("blobs/identity"), "another").unwrap();
    let digest = "f".repeat(64);
    let foreign = files::published(&bench.dir.path().join("blobs"), &digest);
    fs::create_dir_all(foreign.parent().unwrap()).unwrap();
    fs::write(&foreign, "precious").unwrap();
    let refused = bench.store.collect_garbage().await;
    assert!(matches!(refused, Err(Error::StoreMismatch { .. })), "{refused:?}");
    assert!(foreign.exists());
}

async fn stores_from_before_identities_get_one(on: On) {
    let bench = Bench::new(on).await;
    let capture = bench.capture("old").await;
    let mut tx = bench.store.inner.database.write().await.unwrap();
    crate::sql::query("delete from store").execute(&mut tx).await.unwrap();
    tx.commit().await.unwrap();
    fs::remove_file(bench.dir.path().join("blobs/identity")).unwrap();
    let bench = bench.reopen().await;
    bench.store.captures().content(capture.id).await.unwrap();
    let mine = super::of_database(bench.store.inner.database.read()).await.unwrap();
    assert!(mine.is_some());
    assert_eq!(mine, files::identity(&bench.dir.path().join("blobs")).unwrap());
}

async fn content_without_a_row_stays_in_the_trash_for_a_day(on: On) {
    let bench = Bench::new(on).await;
    let capture = bench.capture("wanted").await;
    let digest = capture.digest.to_hex();
    let forget = async |sql: &'static str| {
        let mut tx = bench.store.inner.database.write().await.unwrap();
        crate::sql::query(sql).execute(&mut tx).await.unwrap();
        tx.commit().await.unwrap();
        bench.no_arrivals().await;
        bench.store.collect_garbage().await.unwrap();
    };
    let trashed = bench.dir.path().join("blobs/trash").join(digest.as_str());
    forget("update captures set digest = replace(digest, 'a', 'A')").await;
    assert_eq!((bench.published_count().await, trashed.exists()), (0, true));
    // When a row refers to it again, it is restored.
    forget("update captures set digest = lower(digest)").await;
    let (_, content) = bench.store.captures().content(capture.id).await.unwrap();
    assert_eq!(content.size_bytes, 6);
    assert_eq!((bench.published_count().await, trashed.exists()), (1, false));
    // Else it goes, a day later.
    forget("update captures set digest = replace(digest, 'a', 'A')").await;
    bench.clock.advance(Duration::from_secs(86_000));
    bench.store.collect_garbage().await.unwrap();
    assert!(trashed.exists());
    bench.clock.advance(Duration::from_secs(500));
    bench.store.collect_garbage().await.unwrap();
    assert!(!trashed.exists());
}
