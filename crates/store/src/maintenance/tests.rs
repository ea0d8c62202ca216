use std::{
    fs,
    path::{Path, PathBuf},
};

use bendtwin_core::ids::CaptureId;
use bytes::Bytes;
use sqlx::{ConnectOptions as _, Connection as _};

use super::*;
use crate::{
    Capture, Creator, Error, IngestOutcome, IngestResult, Kind, NewReport, NewSupplement, Options,
    State, Store, SupplementKind,
    blobs::files,
    database::{self, testing::On},
    store::tests::{Bench, LEASE, lease_of, new_capture, new_fit},
};

pub(super) fn file(dir: &Path, content: &str) -> PathBuf {
    files::published(&dir.join("blobs"), &blake3::hash(content.as_bytes()).to_hex())
}

/// A capture whose ingest has made `seen`, `played`, `followed`, `{}` and `<p>`, and to which `poses`
/// were added.
pub(super) async fn observed(bench: &Bench, content: &'static str) -> Capture {
    let capture = bench.fresh_capture(content).await;
    let lease = lease_of(&bench.claim(Kind::Ingest).await.unwrap());
    let report = NewReport {
        verdict: "good".to_owned(),
        json: bench.stage("{}").await,
        html: bench.stage("<p>").await,
    };
    let result = IngestResult {
        outcome: IngestOutcome::Observed(Box::new(bench.stage("seen").await)),
        playback: Some(bench.stage("played").await),
        masks: Some(bench.stage("followed").await),
        report,
    };
    bench.store.jobs().end_ingest(lease, result).await.unwrap();
    let (kind, content) = (SupplementKind::Calibration, bench.stage("poses").await);
    let new = NewSupplement { capture: capture.id, kind, content, creator: Creator::default() };
    bench.store.captures().add_supplement(new).await.unwrap();
    capture
}

/// A fit under way whose checkpoint is `half way`.
pub(super) async fn half_way(bench: &Bench, capture: &Capture) {
    bench.store.jobs().create_fit(new_fit(capture)).await.unwrap();
    let lease = lease_of(&bench.claim(Kind::Fit).await.unwrap());
    let checkpoint = bench.stage("half way").await;
    bench.store.jobs().save_checkpoint(lease, checkpoint, LEASE).await.unwrap();
}

async fn open(dir: &Path) -> Store {
    Store::open(Options::new(dir)).await.unwrap()
}

pub(super) async fn content(store: &Store, id: CaptureId) -> crate::Result<u64> {
    Ok(store.captures().content(id).await?.1.size_bytes)
}

#[tokio::test]
async fn a_check_beside_a_server_names_what_is_damaged_and_changes_nothing() {
    let bench = Bench::new(On::Sqlite).await;
    let capture = observed(&bench, "archive").await;
    half_way(&bench, &capture).await;
    let dir = bench.dir.path();
    let sound = check(dir, Depth::Digests).await.unwrap();
    assert!(sound.is_sound() && sound.unreferenced.is_empty(), "{sound:?}");
    assert_eq!((sound.references, sound.blobs), (8, 8));

    fs::write(file(dir, "archive"), "archi").unwrap();
    fs::write(file(dir, "seen"), "SEEN").unwrap();
    fs::write(file(dir, "played"), "PLAYED").unwrap();
    fs::write(file(dir, "followed"), "FOLLOWED").unwrap();
    fs::write(file(dir, "poses"), "POSES").unwrap();
    fs::remove_file(file(dir, "half way")).unwrap();
    fs::write(file(dir, "seen").with_file_name("f".repeat(64)), "stranger").unwrap();
    let found = check(dir, Depth::Digests).await.unwrap();
    let faults = |report: &CheckReport| {
        let mut faults: Vec<_> =
            report.damaged.iter().map(|d| (d.part.clone(), d.fault.clone())).collect();
        faults.sort();
        faults
    };
    let fault = |part: &str, fault: &str| (part.to_owned(), fault.to_owned());
    let archive = fault("archive", "5 bytes instead of 7");
    let checkpoint = fault("checkpoint", "missing");
    let observation = fault("observation", "other content");
    let playback = fault("playback", "other content");
    let masks = fault("masks", "other content");
    let poses = fault("calibration supplement", "other content");
    assert!(!found.is_sound());
    let all = [archive.clone(), poses, checkpoint.clone(), masks, observation, playback];
    assert_eq!(faults(&found), all);
    assert_eq!(found.unreferenced.len(), 1);
    // Without reading it, changed content goes unnoticed.
    let quick = check(dir, Depth::Sizes).await.unwrap();
    assert_eq!(faults(&quick), [archive, checkpoint]);
    assert_eq!(check(dir, Depth::Digests).await.unwrap(), found);
    assert!(matches!(repair(dir).await, Err(Error::DataDirInUse)));
}

#[tokio::test]
async fn a_repair_makes_again_what_it_can_and_deletes_nothing() {
    let bench = Bench::new(On::Sqlite).await;
    let capture = observed(&bench, "archive").await;
    half_way(&bench, &capture).await;
    let other = bench.capture("another").await;
    let dir = bench.close().await;
    let dir = dir.path();
    fs::write(file(dir, "followed"), "FOLLOWED").unwrap();
    fs::write(file(dir, "seen"), "SEEN").unwrap();
    fs::write(file(dir, "poses"), "POSES").unwrap();
    fs::remove_file(file(dir, "half way")).unwrap();
    fs::write(file(dir, "another"), "anoth").unwrap();
    let done = repair(dir).await.unwrap();
    assert_eq!(done.lost.len(), 2, "{done:?}");
    let lost: Vec<_> = done.lost.iter().map(|d| (d.name.clone(), d.part.as_str())).collect();
    assert!(lost.contains(&(other.id.to_string(), "archive")), "{lost:?}");
    assert!(lost.contains(&(capture.id.to_string(), "calibration supplement")), "{lost:?}");
    let said = done.actions.join("\n");
    for part in ["read again", "starts anew", "blobs/damaged"] {
        assert!(said.contains(part), "{said}");
    }
    let damaged = |content: &str| {
        let digest = blake3::hash(content.as_bytes()).to_hex();
        fs::read_to_string(dir.join("blobs/damaged").join(digest.as_str())).unwrap()
    };
    assert_eq!((damaged("seen").as_str(), damaged("another").as_str()), ("SEEN", "anoth"));

    let store = open(dir).await;
    let jobs = store.jobs();
    assert_eq!(jobs.ingest_of(capture.id).await.unwrap().state, State::Queued);
    let fits = jobs.fits(&Default::default()).await.unwrap().items;
    assert!(fits[0].capture == capture.id);
    assert_eq!(fits[0].checkpoint, None);
    assert!(matches!(content(&store, other.id).await, Err(Error::ContentLost { .. })));
    // The same archive also completes the old capture.
    let mut upload = store.blobs().upload(1 << 20).await.unwrap();
    upload.write(Bytes::from_static(b"another")).await.unwrap();
    let again = new_capture("again", upload.finish(None).await.unwrap());
    store.captures().create(again).await.unwrap();
    assert_eq!(content(&store, other.id).await.unwrap(), 7);
    // So does what was added to it, although its fit runs: it is the same.
    let mut upload = store.blobs().upload(1 << 20).await.unwrap();
    upload.write(Bytes::from_static(b"poses")).await.unwrap();
    let (kind, content) = (SupplementKind::Calibration, upload.finish(None).await.unwrap());
    let new = NewSupplement { capture: capture.id, kind, content, creator: Creator::default() };
    store.captures().add_supplement(new).await.unwrap();
    store.close().await;
    drop(store);
    assert!(check(dir, Depth::Digests).await.unwrap().is_sound());
    assert_eq!(repair(dir).await.unwrap(), Repair::default());
}

#[tokio::test]
async fn content_without_a_database_is_kept_until_the_database_is_back() {
    let bench = Bench::new(On::Sqlite).await;
    let capture = bench.capture("archive").await;
    let dir = bench.close().await;
    let dir = dir.path();
    let (here, away) = (dir.join(database::FILE), dir.join("away"));
    fs::rename(&here, &away).unwrap();
    let done = repair(dir).await.unwrap();
    assert!(done.actions.iter().any(|action| action.contains("blobs/found")), "{done:?}");
    let store = open(dir).await;
    assert!(store.captures().list(&Default::default()).await.unwrap().items.is_empty());
    store.close().await;
    drop(store);
    for suffix in ["-wal", "-shm"] {
        let _ = fs::remove_file(dir.join(format!("{}{suffix}", database::FILE)));
    }
    fs::rename(&away, &here).unwrap();
    assert!(check(dir, Depth::Digests).await.unwrap().mismatch);
    let done = repair(dir).await.unwrap();
    assert!(done.lost.is_empty(), "{done:?}");
    assert_eq!(content(&open(dir).await, capture.id).await.unwrap(), 7);
}

#[tokio::test]
async fn damaged_indexes_are_rebuilt() {
    let bench = Bench::new(On::Sqlite).await;
    bench.capture("archive").await;
    let dir = bench.close().await;
    let mut connection =
        database::options(&dir.path().join(database::FILE)).connect().await.unwrap();
    for statement in [
        "insert into workers (id, endpoint, backend, device, build, lanes, supervised, started_at)
         values ('a', 'b', 'c', 'd', 'e', 1, false, 0)",
        "create index of_workers on workers (build)",
        "pragma writable_schema = on",
        "update sqlite_master set sql = 'create index of_workers on workers (device)'
         where name = 'of_workers'",
    ] {
        sqlx::query(statement).execute(&mut connection).await.unwrap();
    }
    connection.close().await.unwrap();
    let found = check(dir.path(), Depth::Sizes).await.unwrap();
    assert!(!found.is_sound() && !found.database.is_empty(), "{found:?}");
    let done = repair(dir.path()).await.unwrap();
    assert!(done.actions[0].contains("rebuilt the indexes"), "{done:?}");
    assert!(check(dir.path(), Depth::Sizes).await.unwrap().is_sound());
}

#[tokio::test]
async fn damaged_files_are_rebuilt_and_kept() {
    let bench = Bench::new(On::Sqlite).await;
    let capture = bench.capture("archive").await;
    let dir = bench.close().await;
    let path = dir.path().join(database::FILE);
    // A page that neither a table nor the list of free pages has.
    let mut bytes = fs::read(&path).unwrap();
    let pages = u32::from_be_bytes(bytes[28..32].try_into().unwrap()) + 1;
    bytes[28..32].copy_from_slice(&pages.to_be_bytes());
    bytes.resize(bytes.len() + 4096, 0);
    fs::write(&path, &bytes).unwrap();
    let refused = Store::open(Options::new(dir.path())).await.unwrap_err();
    assert!(matches!(refused, Error::DatabaseDamaged { .. }), "{refused}");
    let done = repair(dir.path()).await.unwrap();
    assert!(done.actions[0].contains("rebuilt the database"), "{done:?}");
    assert!(check(dir.path(), Depth::Sizes).await.unwrap().is_sound());
    assert_eq!(content(&open(dir.path()).await, capture.id).await.unwrap(), 7);
    let kept = fs::read_dir(dir.path()).unwrap().filter_map(|entry| {
        let entry = entry.unwrap();
        entry.file_name().to_string_lossy().contains(".damaged-").then(|| entry.path())
    });
    assert_eq!(fs::read(kept.last().unwrap()).unwrap(), bytes);
}

#[tokio::test]
async fn beyond_repair_is_said_and_nothing_is_changed() {
    let bench = Bench::new(On::Sqlite).await;
    bench.capture("archive").await;
    let dir = bench.close().await;
    let path = dir.path().join(database::FILE);
    let mut bytes = fs::read(&path).unwrap();
    bytes[4096..].iter_mut().for_each(|byte| *byte ^= 0x55);
    fs::write(&path, &bytes).unwrap();
    assert!(!check(dir.path(), Depth::Sizes).await.unwrap().is_sound());
    let refused = repair(dir.path()).await.unwrap_err();
    assert!(matches!(refused, Error::BeyondRepair { .. }), "{refused}");
    assert_eq!(fs::read(&path).unwrap(), bytes);
    assert!(file(dir.path(), "archive").exists());
}

#[tokio::test]
async fn content_moves_to_a_bucket_and_an_interrupted_move_resumes() {
    let Some(on) = On::bucket_or_skip() else { return };
    let bench = Bench::new(On::Sqlite).await;
    let capture = observed(&bench, "archive").await;
    let other = bench.capture("another").await;
    let uploads = bench.store.uploads();
    let bounds = crate::UploadBounds { count: 1, bytes: 1 << 20 };
    let under_way = uploads.create(crate::uploads::tests::new("begun"), bounds).await.unwrap().id;
    crate::uploads::tests::append(&bench, under_way, "be").await;
    let to = on.objects().unwrap();
    let busy = relocate(bench.dir.path(), &to).await.unwrap_err();
    assert!(matches!(busy, Error::DataDirInUse), "{busy}");
    let dir = bench.close().await;
    let data_dir = dir.path();
    fs::write(file(data_dir, "another"), "anoth").unwrap();

    // A start with the place alone would have none of the content.
    let with = Options { objects: Some(to.clone()), ..Options::new(data_dir) };
    let early = Store::open(with.clone()).await.unwrap_err();
    assert!(matches!(early, Error::ObjectsNotMigrated { .. }), "{early}");

    let done = relocate(data_dir, &to).await.unwrap();
    assert_eq!((done.blobs, done.damaged), (7, vec![other.digest.to_hex().to_string()]));
    // Interrupted just before its end: the command is run again.
    fs::rename(data_dir.join("blobs.migrated"), data_dir.join("blobs")).unwrap();
    assert_eq!(relocate(data_dir, &to).await.unwrap().blobs, 7);
    assert!(!data_dir.join("blobs").exists());

    let without = Store::open(Options::new(data_dir)).await.unwrap_err();
    assert!(matches!(without, Error::ObjectsElsewhere { .. }), "{without}");
    for refused in [check(data_dir, Depth::Sizes).await.map(drop), repair(data_dir).await.map(drop)]
    {
        let refused = refused.unwrap_err();
        assert!(matches!(refused, Error::ObjectsNotLocal { .. }), "{refused}");
    }
    let refused = backup(&Site::new(data_dir), &data_dir.join("to")).await.unwrap_err();
    assert!(matches!(refused, Error::ObjectsElsewhere { .. }), "{refused}");
    let store = Store::open(with).await.unwrap();
    assert_eq!(content(&store, capture.id).await.unwrap(), 7);
    let lost = content(&store, other.id).await.unwrap_err();
    assert!(matches!(lost, Error::ContentLost { .. }), "{lost}");
    let gone = store.uploads().get(under_way).await.unwrap().state;
    assert!(matches!(gone, crate::UploadState::Gone(_)), "{gone:?}");
}

#[tokio::test]
async fn content_of_another_store_is_left_alone() {
    let Some(on) = On::bucket_or_skip() else { return };
    let owner = Bench::new(on).await;
    let capture = owner.capture("precious").await;
    let to = owner.objects.clone().unwrap();
    let bench = Bench::new(On::Sqlite).await;
    bench.capture("another").await;
    let dir = bench.close().await;
    let refused = relocate(dir.path(), &to).await.unwrap_err();
    assert!(matches!(refused, Error::StoreMismatch { .. }), "{refused}");
    let new = tempfile::tempdir().unwrap();
    let refused = Store::open(Options { objects: Some(to), ..Options::new(new.path()) }).await;
    assert!(refused.is_err());
    assert_eq!(content(&owner.store, capture.id).await.unwrap(), 8);
}
