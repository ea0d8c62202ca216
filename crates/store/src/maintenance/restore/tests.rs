use super::*;
use crate::{
    Kind, ListQuery, NewWorker, Options, State as JobState, Store,
    database::testing::{On, TestDatabase, own_bucket},
    maintenance::{
        backup,
        tests::{content, file, half_way, observed},
    },
    store::tests::{Bench, lease_of, new_fit},
};

fn site(bench: &Bench) -> Site {
    Site { database: bench.url(), objects: bench.objects.clone(), ..Site::new(bench.dir.path()) }
}

/// The kinds of stores that can be made here: SQLite and files always.
fn kinds() -> Vec<(bool, bool)> {
    let (postgres, bucket) = (On::postgres_or_skip().is_some(), On::bucket_or_skip().is_some());
    let all = [(false, false), (true, false), (false, true), (true, true)];
    all.into_iter().filter(|kind| (!kind.0 || postgres) && (!kind.1 || bucket)).collect()
}

#[tokio::test]
async fn a_store_of_any_kind_becomes_one_of_any_other_kind() {
    for (of_postgres, of_bucket) in kinds() {
        let database = if of_postgres { Some(TestDatabase::new().await) } else { None };
        let objects = of_bucket.then(own_bucket);
        let dir = tempfile::tempdir().unwrap();
        let bench = Bench::begin(dir, std::sync::Arc::default(), database, objects).await;
        let capture = observed(&bench, "archive").await;
        half_way(&bench, &capture).await;
        let run_by = NewWorker {
            id: bendtwin_core::ids::WorkerId::generate(),
            endpoint: "http://127.0.0.1:1".to_owned(),
            backend: "cpu".to_owned(),
            device: "a processor".to_owned(),
            build: "a build".to_owned(),
            lanes: 1,
            labels: Vec::new(),
            server: None,
        };
        bench.store.workers().register(run_by).await.unwrap();
        let folder = tempfile::tempdir().unwrap();
        backup(&site(&bench), folder.path()).await.unwrap();
        for (to_postgres, to_bucket) in kinds() {
            let database = if to_postgres { Some(TestDatabase::new().await) } else { None };
            let target = tempfile::tempdir().unwrap();
            let site = Site {
                database: database.as_ref().map(|database| database.url.clone()),
                objects: to_bucket.then(own_bucket),
                ..Site::new(target.path())
            };
            let done = restore(folder.path(), &site).await.unwrap();
            assert!(done.lost.is_empty() && done.blobs == 8, "{done:?}");
            let store = open(&site).await.unwrap();
            assert_eq!(content(&store, capture.id).await.unwrap(), 7);
            store.captures().observation_content(capture.id).await.unwrap();
            let query = ListQuery::default();
            let fit = store.jobs().fits(&query).await.unwrap().items.remove(0);
            assert_eq!((fit.state, fit.attempts), (JobState::Queued, 0), "its worker is not here");
            store.jobs().checkpoint(fit.id).await.unwrap();
            assert!(store.workers().all().await.unwrap().is_empty());
            let theirs = bench.store.captures().list(&query).await.unwrap().items;
            assert_eq!(store.captures().list(&query).await.unwrap().items, theirs);
            store.close().await;
            // The same again finds a store there.
            let again = restore(folder.path(), &site).await.unwrap_err();
            assert!(matches!(again, Error::DataDirNotEmpty { .. }), "{again}");
        }
    }
}

async fn open(site: &Site) -> Result<Store> {
    let Site { data_dir, database, objects, .. } = site.clone();
    Store::open(Options { database, objects, ..Options::new(data_dir) }).await
}

/// A restore that ended in the middle of the content, and one that ended after the rows.
#[tokio::test]
async fn an_interrupted_restore_continues_and_no_server_starts_before() {
    let bench = Bench::new(On::Sqlite).await;
    let capture = observed(&bench, "archive").await;
    let other = Bench::new(On::Sqlite).await;
    other.capture("of another").await;
    let (folder, foreign) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    backup(&site(&bench), folder.path()).await.unwrap();
    backup(&site(&other), foreign.path()).await.unwrap();
    for (to_postgres, to_bucket) in kinds().into_iter().filter(|kind| !kind.1) {
        let database = if to_postgres { Some(TestDatabase::new().await) } else { None };
        let target = tempfile::tempdir().unwrap();
        let site = Site {
            database: database.as_ref().map(|database| database.url.clone()),
            objects: to_bucket.then(own_bucket),
            ..Site::new(target.path())
        };
        // A file in the place of a folder.
        let place = file(target.path(), "archive");
        let place = place.parent().unwrap();
        fs::create_dir_all(place.parent().unwrap()).unwrap();
        fs::write(place, "in the way").unwrap();
        restore(folder.path(), &site).await.unwrap_err();
        let refused = open(&site).await.unwrap_err();
        assert!(matches!(refused, Error::RestoreUnfinished { .. }), "{refused}");
        let refused = restore(foreign.path(), &site).await.unwrap_err();
        assert!(matches!(refused, Error::AnotherRestore { .. }), "{refused}");
        fs::remove_file(place).unwrap();
        let staging = target.path().join(database::RESTORING);
        let state = fs::read(staging.join(database::RESTORE_STATE)).unwrap();
        let done = restore(folder.path(), &site).await.unwrap();
        assert!(done.lost.is_empty(), "{done:?}");
        // Killed before it was over.
        fs::create_dir(&staging).unwrap();
        fs::write(staging.join(database::RESTORE_STATE), state).unwrap();
        let again = restore(folder.path(), &site).await.unwrap();
        assert_eq!((&again.tables, again.blobs), (&done.tables, done.blobs));
        let store = open(&site).await.unwrap();
        assert_eq!(content(&store, capture.id).await.unwrap(), 7);
        store.close().await;
    }
}

/// The restored store is another one: neither takes the content of the other for its own.
#[tokio::test]
async fn a_restored_store_does_not_touch_the_content_of_the_original() {
    let (Some(on), Some(_)) = (On::bucket_or_skip(), On::postgres_or_skip()) else { return };
    let bench = Bench::new(on).await;
    let capture = bench.capture("archive").await;
    let folder = tempfile::tempdir().unwrap();
    backup(&site(&bench), folder.path()).await.unwrap();
    let database = TestDatabase::new().await;
    let (target, away) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    let url = Some(database.url.clone());
    let new =
        Site { database: url.clone(), objects: Some(own_bucket()), ..Site::new(target.path()) };
    let onto = Site { database: url, objects: bench.objects.clone(), ..Site::new(away.path()) };
    let refused = restore(folder.path(), &onto).await.unwrap_err();
    assert!(matches!(refused, Error::ObjectsNotEmpty { .. }), "{refused}");
    restore(folder.path(), &new).await.unwrap();
    let mixed = open(&onto).await.unwrap_err();
    assert!(matches!(mixed, Error::StoreMismatch { .. }), "{mixed}");
    assert_eq!(content(&bench.store, capture.id).await.unwrap(), 7);
    let again = Site { objects: Some(own_bucket()), ..onto };
    fs::remove_dir_all(away.path()).unwrap();
    let refused = restore(folder.path(), &again).await.unwrap_err();
    assert!(matches!(refused, Error::DatabaseNotEmpty { .. }), "{refused}");
}

#[tokio::test]
async fn damaged_content_is_left_out_and_named() {
    let bench = Bench::new(On::Sqlite).await;
    let (good, bad) = (bench.capture("archive").await, bench.capture("another").await);
    let folders = tempfile::tempdir().unwrap();
    let folder = folders.path().join("backup");
    backup(&site(&bench), &folder).await.unwrap();
    // Not into the file that the store has in common with the backup.
    fs::remove_file(file(&folder, "another")).unwrap();
    fs::write(file(&folder, "another"), "ANOTHER").unwrap();
    let target = folders.path().join("target");
    let done = restore(&folder, &Site::new(&target)).await.unwrap();
    assert_eq!((done.blobs, done.lost.len()), (1, 1), "{done:?}");
    assert_eq!(
        (&*done.lost[0].name, &*done.lost[0].fault),
        (&*bad.id.to_string(), "other content")
    );
    let store = Store::open(Options::new(&target)).await.unwrap();
    assert_eq!(content(&store, good.id).await.unwrap(), 7);
    assert!(content(&store, bad.id).await.is_err());
    store.close().await;

    // A database that cannot be read is refused before anything is made.
    let file = folder.join(sqlite::FILE);
    let mut bytes = fs::read(&file).unwrap();
    bytes[4096..].iter_mut().for_each(|byte| *byte ^= 0x55);
    fs::write(&file, bytes).unwrap();
    let second = folders.path().join("second");
    restore(&folder, &Site::new(&second)).await.unwrap_err();
    assert!(!second.exists());
}

/// What versions before manifests made: a data folder that no server has open.
#[tokio::test]
async fn a_data_folder_is_restored_unless_a_server_has_it() {
    let bench = Bench::new(On::Sqlite).await;
    let capture = bench.capture("archive").await;
    bench.store.jobs().create_fit(new_fit(&capture)).await.unwrap();
    let lease = lease_of(&bench.claim(Kind::Fit).await.unwrap());
    assert_eq!(lease.epoch, 1);
    let targets = tempfile::tempdir().unwrap();
    let target = Site::new(targets.path().join("target"));
    let busy = restore(bench.dir.path(), &target).await.unwrap_err();
    assert!(matches!(busy, Error::BackupInUse { .. }), "{busy}");
    let dir = bench.close().await;
    let done = restore(dir.path(), &target).await.unwrap();
    assert_eq!((done.manifest, done.blobs), (None, 1));
    let store = open(&target).await.unwrap();
    assert_eq!(
        store
            .jobs()
            .claim(
                Kind::Fit,
                bendtwin_core::ids::WorkerId::generate(),
                std::time::Duration::from_secs(9)
            )
            .await
            .unwrap()
            .unwrap()
            .attempts,
        1
    );
    store.close().await;
}
