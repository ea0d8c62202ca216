//! The administrator of a data folder: a check and a backup beside the running server, then damage,
//! a repair, and a database that went astray.

use std::path::{Path, PathBuf};

use serde_json::Value;

use crate::harness::{Setup, TestCluster, command::run, reference};

#[tokio::test]
async fn damage_is_found_and_mended_and_a_foreign_database_refused() {
    let setup = Setup { own_workers: 0, ..Setup::default() };
    let mut server = TestCluster::start(setup).await;
    let archive = reference::capture().await;
    let capture = server.api().upload(&archive, "").await.unwrap();
    let (data_dir, copy) = (server.data_dir(), server.path("copy"));

    // Beside the running server.
    let sound = store(&data_dir, &["check"]).await.unwrap();
    assert_eq!((&sound["references"], &sound["blobs"]), (&1.into(), &1.into()));
    let made = store(&data_dir, &["backup", &copy]).await.unwrap();
    assert_eq!(made["blobs"], 1);
    let sound = store(Path::new(&copy), &["check"]).await.unwrap();
    assert_eq!(sound["damaged"], Value::Array(Vec::new()));
    let busy = store(&data_dir, &["repair"]).await.unwrap_err();
    assert!(busy.contains("DATA_DIR_IN_USE"), "{busy}");

    // Another content under the same name, in place of the link that the copy has.
    server.kill();
    let blob = blob(&data_dir, &capture.digest);
    let mut other = archive.to_vec();
    other[100] ^= 1;
    std::fs::remove_file(&blob).unwrap();
    std::fs::write(&blob, other).unwrap();
    for command in ["check", "repair", "check"] {
        let found = store(&data_dir, &[command]).await.unwrap_err();
        assert!(found.contains("STORE_DAMAGED"), "{command}: {found}");
    }
    assert!(!blob.exists(), "what is damaged is set aside");

    // The same archive once more makes the capture whole.
    server.start_again().await;
    server.api().upload(&archive, "again").await.unwrap();
    let content = server.http().get(&format!("/v1/{}/content", capture.name)).await;
    assert_eq!(content.bytes().await.unwrap(), archive);
    store(&data_dir, &["check"]).await.unwrap();

    // Without its database the content is not touched.
    server.kill();
    for suffix in ["", "-wal", "-shm"] {
        let name = format!("bendtwin.sqlite{suffix}");
        if data_dir.join(&name).exists() {
            std::fs::rename(data_dir.join(&name), server.path(&name)).unwrap();
        }
    }
    let folder = data_dir.display().to_string();
    let started = tokio::task::spawn_blocking(move || {
        run(&["server", "--data-dir", &folder, "--listen", "127.0.0.1:0", "--workers", "0"])
    });
    let refused = started.await.unwrap();
    let message = String::from_utf8_lossy(&refused.stderr).into_owned();
    assert!(!refused.status.success() && message.contains("bendtwin store repair"), "{message}");
    assert!(blob.exists());
}

/// Runs a command on a data folder. An error is what it printed as one.
async fn store(data_dir: &Path, arguments: &[&str]) -> Result<Value, String> {
    let folder = data_dir.display().to_string();
    let arguments: Vec<String> = arguments.iter().map(|a| (*a).to_owned()).collect();
    let running = tokio::task::spawn_blocking(move || {
        let mut all = vec!["store"];
        all.extend(arguments.iter().map(String::as_str));
        all.extend(["--data-dir", &folder]);
        let done = run(&[&all[..], &["--json"]].concat());
        if done.status.success() {
            return Ok(serde_json::from_slice(&done.stdout).unwrap());
        }
        assert_eq!(done.status.code(), Some(1));
        Err(String::from_utf8_lossy(&done.stderr).into_owned())
    });
    running.await.unwrap()
}

fn blob(data_dir: &Path, digest: &str) -> PathBuf {
    data_dir.join("blobs/blake3").join(&digest[..2]).join(digest)
}
