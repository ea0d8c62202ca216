//! A disk that is really full: a file system in memory, in a mount namespace of a process of its
//! own.

use std::{
    path::{Path, PathBuf},
    process::Command,
    sync::Arc,
};

use bytes::Bytes;

use super::*;
use crate::{
    Kind, ManualClock, Options, State, Store,
    store::tests::{LEASE, lease_of, new_capture, new_fit},
};

/// Environment variable with the folder of the small disk, in the process that has it.
const SMALL_DISK: &str = "BENDTWIN_TEST_SMALL_DISK";

#[test]
fn a_full_disk_lets_deletions_through_and_recovers() {
    if let Some(folder) = std::env::var_os(SMALL_DISK) {
        let runtime = tokio::runtime::Builder::new_multi_thread().enable_all().build().unwrap();
        return runtime.block_on(fill_and_recover(&PathBuf::from(folder)));
    }
    let folder = tempfile::tempdir().unwrap();
    let mount = "mount -t tmpfs -o size=64m none \"$0\"";
    let unshare = |flags: &str, script: String| {
        let mut command = Command::new("unshare");
        command.args([flags, "sh", "-c", &script]).arg(folder.path());
        command
    };
    let mounts = |flags: &&str| {
        unshare(flags, mount.to_owned()).output().is_ok_and(|done| done.status.success())
    };
    let Some(flags) = ["-Urm", "-m"].into_iter().find(mounts) else {
        eprintln!("SKIPPED: this machine lets nobody mount a small disk (unshare -Urm)");
        return;
    };
    let status = unshare(flags, format!("{mount} && exec \"$@\""))
        .arg(std::env::current_exe().unwrap())
        .args(["--exact", "disk::tests::a_full_disk_lets_deletions_through_and_recovers"])
        .arg("--nocapture")
        .env(SMALL_DISK, folder.path())
        .status()
        .unwrap();
    assert!(status.success());
}

async fn fill_and_recover(disk: &Path) {
    let data_dir = disk.join("data");
    let clock = Arc::new(ManualClock::default());
    let store = Store::open(Options { clock, ..Options::new(&data_dir) }).await.unwrap();
    let create = async |content: Vec<u8>| {
        let mut upload = store.blobs().upload(1 << 30).await?;
        upload.write(Bytes::from(content)).await?;
        store.captures().create(new_capture("", upload.finish(None).await?)).await
    };
    let capture = create(vec![1; 1000]).await.unwrap();
    let obsolete = create(vec![2; 1000]).await.unwrap();
    for ended in [&capture, &obsolete] {
        store.jobs().cancel(store.jobs().ingest_of(ended.id).await.unwrap().id).await.unwrap();
    }
    let mut tx = store.inner.database.write().await.unwrap();
    crate::sql::query("update jobs set state = 'succeeded'").execute(&mut tx).await.unwrap();
    tx.commit().await.unwrap();
    store.jobs().create_fit(new_fit(&capture)).await.unwrap();
    let worker = bendtwin_core::ids::WorkerId::generate();
    let fit = store.jobs().claim(Kind::Fit, worker, LEASE).await.unwrap().unwrap();
    assert_eq!(std::fs::metadata(data_dir.join("reserve")).unwrap().len(), RESERVE);

    // Something else fills the disk to the last byte.
    let filler = disk.join("filler");
    let written = std::fs::write(&filler, vec![0; 64 << 20]).unwrap_err();
    assert!(is_full(&written), "{written}");
    assert_eq!(store.disk().unwrap().free_bytes, 0);

    // New content of any size is refused.
    for size in [10, 9 << 20] {
        let refused = create(vec![3; size]).await.unwrap_err();
        assert!(matches!(refused, Error::DiskFull), "{size}: {refused}");
    }
    // Deletions, and the ends of jobs with their twins, get through.
    store.captures().delete(obsolete.id).await.unwrap();
    let mut twin = store.blobs().upload(1 << 20).await.unwrap();
    twin.write(Bytes::from(vec![4; 100_000])).await.unwrap();
    let twin = twin.finish(None).await.unwrap();
    let facts = crate::TwinFacts { quality: "{}".into(), ..Default::default() };
    store.jobs().complete_fit(lease_of(&fit), &facts, twin).await.unwrap();
    assert_eq!(store.jobs().get(fit.id).await.unwrap().state, State::Succeeded);
    assert!(matches!(store.probe_write().await, Err(Error::DiskFull)));
    assert!(!data_dir.join("reserve").exists());

    // A start finds its way, too.
    store.close().await;
    drop(store);
    let store = Store::open(Options::new(&data_dir)).await.unwrap();
    store.captures().content(capture.id).await.unwrap();

    // With free space, everything works again immediately.
    std::fs::remove_file(filler).unwrap();
    store.probe_write().await.unwrap();
    assert!(data_dir.join("reserve").exists());
    let mut upload = store.blobs().upload(1 << 30).await.unwrap();
    upload.write(Bytes::from(vec![5; 9 << 20])).await.unwrap();
    let content = upload.finish(None).await.unwrap();
    store.captures().create(new_capture("", content)).await.unwrap();
}
