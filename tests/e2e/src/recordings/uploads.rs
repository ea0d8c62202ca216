//! Uploads: acknowledged ones survive, others leave nothing behind.

use std::{path::Path, time::Duration};

use bendtwin_proto::v1::{CaptureMetadata, CreateCaptureRequest, create_capture_request::Part};
use bytes::Bytes;
use tonic::Code;

use crate::harness::{Setup, TestCluster, reference::capture, until};

fn no_workers() -> Setup {
    Setup { own_workers: 0, ..Setup::default() }
}

#[tokio::test]
async fn acknowledged_uploads_survive_kill_9() {
    let mut server = TestCluster::start(no_workers()).await;
    let api = server.api();
    let archive = capture().await;
    let mut names = Vec::new();
    for round in 0..5 {
        // Other bytes each time, so that each upload is a separate blob.
        let content = Bytes::from([&archive[..], &[round; 64]].concat());
        let stored = api.upload(&content, &format!("upload-{round}")).await.unwrap();
        server.kill();
        server.start_again().await;
        names.push((stored.name, stored.digest, content));
    }
    let mut kept = server.api().list_captures().await.unwrap();
    kept.reverse();
    assert_eq!(kept.len(), names.len());
    for (kept, (name, digest, content)) in kept.iter().zip(&names) {
        assert_eq!((&kept.name, &kept.digest), (name, digest));
        assert_eq!(kept.size_bytes, content.len() as u64);
        // The content is there too: the same upload again is the same capture.
    }
    let (name, _, content) = &names[0];
    assert_eq!(api.upload(content, "upload-0").await.unwrap().name, *name);
}

#[tokio::test]
async fn a_server_killed_during_an_upload_keeps_nothing_of_it() {
    let mut server = TestCluster::start(no_workers()).await;
    let empty = size_of_folder(&server.data_dir());
    let api = server.api();
    let (sender, receiver) = futures::channel::mpsc::unbounded();
    let metadata = CaptureMetadata { display_name: "half".to_owned(), ..Default::default() };
    sender.unbounded_send(message(Part::Metadata(metadata))).unwrap();
    let half = Bytes::from(vec![7; 256 * 1024]);
    for _ in 0..32 {
        sender.unbounded_send(message(Part::Chunk(half.clone()))).unwrap();
    }
    let mut captures = api.captures();
    let upload = tokio::spawn(async move { captures.create_capture(receiver).await });
    let folder = server.data_dir();
    until("the upload to reach the disk", Duration::from_secs(30), async || {
        (size_of_folder(&folder) > empty + (4 << 20)).then_some(())
    })
    .await;
    server.kill();
    drop(sender);
    assert!(upload.await.unwrap().is_err(), "an upload that was cut off was acknowledged");
    server.start_again().await;
    assert_eq!(server.api().list_captures().await.unwrap(), []);
    let left = size_of_folder(&server.data_dir());
    assert!(left < empty + (1 << 20), "{left} bytes are left of {empty} before the upload");
}

#[tokio::test]
async fn a_client_that_goes_away_during_an_upload_leaves_nothing() {
    let server = TestCluster::start(no_workers()).await;
    let folder = server.data_dir();
    let empty = size_of_folder(&folder);
    let api = server.api();
    let (sender, receiver) = futures::channel::mpsc::unbounded();
    sender.unbounded_send(message(Part::Metadata(CaptureMetadata::default()))).unwrap();
    for _ in 0..32 {
        sender.unbounded_send(message(Part::Chunk(Bytes::from(vec![1; 256 * 1024])))).unwrap();
    }
    let mut captures = api.captures();
    let upload = tokio::spawn(async move { captures.create_capture(receiver).await });
    until("the upload to begin", Duration::from_secs(30), async || {
        (size_of_folder(&folder) > empty + (4 << 20)).then_some(())
    })
    .await;
    upload.abort();
    until("the upload to be forgotten", Duration::from_secs(30), async || {
        (size_of_folder(&folder) < empty + (1 << 20)).then_some(())
    })
    .await;
    assert_eq!(api.list_captures().await.unwrap(), []);
}

#[tokio::test]
async fn a_digest_that_does_not_match_is_refused() {
    let server = TestCluster::start(no_workers()).await;
    let metadata = CaptureMetadata { digest: "00".repeat(32), ..Default::default() };
    let messages = vec![message(Part::Metadata(metadata)), message(Part::Chunk(capture().await))];
    let refused = server.api().captures().create_capture(futures::stream::iter(messages)).await;
    assert_eq!(refused.unwrap_err().code(), Code::InvalidArgument);
    assert_eq!(server.api().list_captures().await.unwrap(), []);
}

fn message(part: Part) -> CreateCaptureRequest {
    CreateCaptureRequest { part: Some(part) }
}

fn size_of_folder(folder: &Path) -> u64 {
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    entries
        .map(|entry| match entry.metadata() {
            Ok(about) if about.is_dir() => size_of_folder(&entry.path()),
            Ok(about) => about.len(),
            Err(_) => 0,
        })
        .sum()
}
