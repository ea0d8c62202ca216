//! A server whose rows are in PostgreSQL, which crashes and restarts in the middle of a fit:
//! nothing acknowledged is lost, and the server recovers by itself. Also its backup.

use std::{path::Path, process::Command, time::Duration};

use bendtwin_proto::v1::{CreateFitRequest, Fit, job::State};
use bytes::Bytes;
use tonic::Code;

use crate::harness::{
    Postgres, Setup, TestCluster,
    api::fraction,
    reference::{FIT, SETTINGS, capture, reference},
    until,
};

const PASSWORD: &str = "not-to-be-shown";
const STATE: Duration = Duration::from_secs(60);

#[tokio::test]
async fn a_capture_becomes_a_twin_although_postgres_crashes() {
    let Some(postgres) = Postgres::start_or_skip().await else { return };
    let database = Some(postgres.url_with_password(PASSWORD));
    let mut server = TestCluster::start(Setup { database, ..Setup::default() }).await;
    let api = server.api();
    let archive = capture().await;
    let stored = api.upload(&archive, "the capture").await.unwrap();
    let under_way = |fit: &Fit| fit.state() == State::Running && fraction(fit) > 0.0;
    let fit = api.fit(&stored.name, SETTINGS, 0).await.unwrap();
    api.fit_when(&fit.name, "running", FIT, under_way).await;

    postgres.kill().await;
    let request = CreateFitRequest {
        capture: stored.name.clone(),
        settings_json: SETTINGS.to_owned(),
        request_id: "the second".to_owned(),
        ..CreateFitRequest::default()
    };
    let refused = api.fits().create_fit(request.clone()).await.unwrap_err();
    assert_eq!(refused.code(), Code::Unavailable, "{}", refused.message());
    assert!(!refused.message().contains(PASSWORD), "{}", refused.message());
    assert!(!server.http().is_ready().await);

    postgres.start().await;
    let second = until("the server to take requests again", STATE, async || {
        Some(api.fits().create_fit(request.clone()).await.ok()?.into_inner())
    })
    .await;
    for name in [&fit.name, &second.name] {
        let fitted = api.succeeded(name, FIT).await;
        let twin = api.export(&fitted.twin).await.unwrap();
        assert!(bendtwin_core::Twin::decode(&twin).is_ok());
    }
    assert!(server.is_alive(), "the server is the same");
    assert_eq!(api.list_captures().await.unwrap().len(), 1);
    assert_eq!(api.list_fits().await.unwrap().len(), 2);

    // Its own restart finds everything in the database, and the folder has none.
    server.kill();
    server.start_again().await;
    assert_eq!(server.api().list_twins().await.unwrap().len(), 2);
    let content = server.http().get(&format!("/v1/{}/content", stored.name)).await;
    assert_eq!(content.bytes().await.unwrap(), archive);
    assert!(!server.data_dir().join("bendtwin.sqlite").exists());
    assert!(!server.log().contains(PASSWORD), "the password is in a log");
}

/// A copy made beside a server that takes captures meanwhile, in the order of docs/run/storage.md.
#[tokio::test]
async fn a_copy_of_a_running_store_is_restored_with_all_its_content() {
    let (Some(postgres), Some(restored)) =
        (Postgres::start_or_skip().await, Postgres::start_or_skip().await)
    else {
        return;
    };
    let database = Some(postgres.url_with_password(PASSWORD));
    let server = TestCluster::start(Setup { database, ..Setup::default() }).await;
    let api = server.api();
    let archive = capture().await;
    let file = reference().await.file;
    let twin = api.import(&file).await.unwrap();
    let folder = tempfile::tempdir().unwrap();
    let copy = folder.path().join("data");
    let dump = folder.path().join("bendtwin.dump").to_string_lossy().into_owned();
    let before = api.upload(&archive, "before").await.unwrap();

    let busy = api.clone();
    let uploads = tokio::spawn(async move {
        for nth in 0_u64..200 {
            let content = Bytes::from(nth.to_le_bytes().repeat(100));
            if busy.upload(&content, &nth.to_string()).await.is_err() {
                return;
            }
        }
    });
    let some = until("some captures", STATE, async || {
        let count = api.list_captures().await.ok()?.len();
        (count > 5).then_some(count)
    })
    .await;
    copy_content(&server.data_dir(), &copy);
    let url = postgres.url_with_password(PASSWORD);
    run("pg_dump", &["--format=custom", &format!("--file={dump}"), &url]).await;
    copy_content(&server.data_dir(), &copy);
    uploads.abort();
    drop(server);

    let url = restored.url_with_password(PASSWORD);
    run("pg_restore", &["--no-owner", &format!("--dbname={url}"), &dump]).await;
    let setup = Setup { database: Some(url), data_dir: Some(copy), ..Setup::default() };
    let server = TestCluster::start(setup).await;
    let api = server.api();
    assert_eq!(api.export(&twin.name).await.unwrap(), file);
    let captures = api.list_captures().await.unwrap();
    assert!(captures.len() >= some && captures.iter().any(|found| found.name == before.name));
    for found in captures {
        let content = server.http().get(&format!("/v1/{}/content", found.name)).await;
        assert_eq!(content.bytes().await.unwrap().len() as u64, found.size_bytes, "{}", found.name);
    }
}

/// Copies the content of a data folder, and what else belongs to a copy.
fn copy_content(data_dir: &Path, copy: &Path) {
    std::fs::create_dir_all(copy.join("blobs")).unwrap();
    for name in ["postgres", "blobs/identity", "blobs/blake3"] {
        let to = copy.join(name).parent().unwrap().to_owned();
        let copied = Command::new("cp").arg("-a").arg(data_dir.join(name)).arg(to).output();
        let copied = copied.unwrap();
        // What is on its way in or out may vanish while it is copied.
        let said = String::from_utf8_lossy(&copied.stderr);
        let vanished = said.lines().all(|line| line.contains("No such file or directory"));
        assert!(copied.status.success() || vanished, "{name}: {said}");
    }
}

/// Runs a program of PostgreSQL's.
async fn run(program: &'static str, arguments: &[&str]) {
    let mut command = Command::new(program);
    command.args(arguments);
    let done = tokio::task::spawn_blocking(move || command.output()).await.unwrap().unwrap();
    assert!(done.status.success(), "{program}: {}", String::from_utf8_lossy(&done.stderr));
}
