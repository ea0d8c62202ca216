//! Uploads of gigabytes over connections that break, between processes that die.

use std::{io::Read as _, process::Child, time::Duration};

use bytes::Bytes;
use futures::StreamExt as _;
use reqwest::{Body, Method, RequestBuilder, StatusCode};

use crate::harness::{
    Setup, TestCluster,
    command::{bendtwin, run_json, run_ok},
    http::Http,
    stalling_proxy::StallingProxy,
    until,
};

const MIB: u64 = 1 << 20;
/// Bytes of one request of the Rust client, as in `client/rust/src/captures/uploads.rs`.
const PART: u64 = 16 * MIB;
/// Bytes that the server makes durable at a time, as in `server/src/app/uploads.rs`.
const COMMIT: u64 = 32 * MIB;
const DEADLINE: Duration = Duration::from_secs(60);

fn no_workers() -> Setup {
    Setup { own_workers: 0, ..Setup::default() }
}

/// Content without repetition that can be generated again instead of kept.
fn content(from: u64, to: u64) -> Vec<u8> {
    let word = |i: u64| (i.wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 11).to_le_bytes();
    assert!(from.is_multiple_of(8) && to.is_multiple_of(8));
    (from / 8..to / 8).flat_map(word).collect()
}

fn tus(http: &Http, method: &str, path: &str) -> RequestBuilder {
    let method = Method::from_bytes(method.as_bytes()).unwrap();
    http.request(method, path).header("tus-resumable", "1.0.0")
}

/// Bytes of uploads that this run of the server has made durable.
async fn received(http: &Http) -> u64 {
    let metrics = http.get("/metrics").await.text().await.unwrap();
    let mut lines = metrics.lines();
    let line = lines.find_map(|line| line.strip_prefix("bendtwin_upload_bytes_total "));
    line.map_or(0, |n| n.parse().unwrap())
}

async fn received_at_least(http: &Http, bytes: u64) {
    until(&format!("{bytes} bytes at the server"), DEADLINE, async || {
        (received(http).await >= bytes).then_some(())
    })
    .await;
}

/// Peak of a process's memory [bytes].
fn peak_memory(pid: u32) -> u64 {
    let status = std::fs::read_to_string(format!("/proc/{pid}/status")).unwrap();
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:")).unwrap();
    line.trim().trim_end_matches(" kB").parse::<u64>().unwrap() * 1024
}

/// True if the capture has this content, read in pieces.
async fn has_content(http: &Http, capture: &str, size: u64) -> bool {
    let reply = http.get(&format!("/v1/{capture}/content")).await;
    let (mut at, mut left, mut same) = (0, Vec::new(), true);
    let mut chunks = reply.bytes_stream();
    while let Some(chunk) = chunks.next().await {
        left.extend_from_slice(&chunk.unwrap());
        let whole = left.len() as u64 / 8 * 8;
        let rest = left.split_off(whole as usize);
        same &= left == content(at, at + whole);
        (at, left) = (at + whole, rest);
    }
    same && at == size && left.is_empty()
}

/// Kills a process when dropped.
struct Killed(Child);

impl Drop for Killed {
    fn drop(&mut self) {
        self.0.kill().ok();
        self.0.wait().ok();
    }
}

#[tokio::test]
async fn a_push_survives_deaths_of_server_and_client() {
    let mut server = TestCluster::start(no_workers()).await;
    let size = 40 * MIB;
    let file = server.path("rope.zip");
    std::fs::write(&file, content(0, size)).unwrap();
    let push = ["capture", "push", &file, "--no-check"];

    // The first part arrives, the second gets stuck; then both sides die.
    let proxy = StallingProxy::to(&server.url(), PART + 4 * MIB).await;
    let mut command = bendtwin();
    command.args(push).args(["--json", "--server", proxy.url()]);
    let client = Killed(command.spawn().unwrap());
    received_at_least(&server.http(), PART).await;
    server.kill();
    drop(client);
    server.start_again().await;

    let url = server.url();
    let at = ["--server", &url];
    let pushed = run_json(&[&push[..], &at].concat());
    let name = pushed["name"].as_str().unwrap();
    let http = server.http();
    assert_eq!(received(&http).await, size - PART, "it resumed at the acknowledged offset");
    assert!(has_content(&http, name, size).await);
    // Pushed again it is the same capture, and nothing is sent.
    assert_eq!(run_json(&[&push[..], &at].concat()), pushed);
    assert_eq!(received(&http).await, size - PART);
}

#[tokio::test]
async fn a_server_killed_in_mid_request_keeps_what_it_saved_and_its_memory_stays_flat() {
    let mut server = TestCluster::start(no_workers()).await;
    let http = server.http();
    let size = 160 * MIB;
    let begun = tus(&http, "POST", "/v1/uploads").header("upload-length", size);
    let begun = begun.send().await.unwrap();
    assert_eq!(begun.status(), StatusCode::CREATED);
    let path = begun.headers()["location"].to_str().unwrap().to_owned();
    let patch = |http: &Http, offset: u64, body: Body| {
        let request = tus(http, "PATCH", &path).header("upload-offset", offset);
        request.header("content-type", "application/offset+octet-stream").body(body)
    };
    let pieces = |from: u64, to: u64| {
        let starts = (from / MIB..to / MIB).map(|i| i * MIB);
        futures::stream::iter(starts)
            .map(|i| Ok::<_, std::io::Error>(Bytes::from(content(i, i + MIB))))
    };

    // More than two savings' worth, and then neither data nor an end.
    let stuck = pieces(0, 2 * COMMIT + 8 * MIB).chain(futures::stream::pending());
    let request = patch(&http, 0, Body::wrap_stream(stuck));
    let sending = tokio::spawn(async move { request.send().await });
    received_at_least(&http, 2 * COMMIT).await;
    server.kill();
    sending.await.unwrap().unwrap_err();
    server.start_again().await;

    let http = server.http();
    let before = peak_memory(server.pid());
    let head = tus(&http, "HEAD", &path).send().await.unwrap();
    assert_eq!(head.headers()["upload-offset"], (2 * COMMIT).to_string());
    let rest = patch(&http, 2 * COMMIT, Body::wrap_stream(pieces(2 * COMMIT, size)));
    let whole = rest.send().await.unwrap();
    assert_eq!(whole.status(), StatusCode::NO_CONTENT);
    let capture = whole.headers()["bendtwin-capture"].to_str().unwrap();
    let grown = peak_memory(server.pid()) - before;
    assert!(grown < 32 * MIB, "the server took {grown} bytes more for {size}");
    assert!(has_content(&http, capture, size).await);
}

#[tokio::test]
async fn of_a_folder_the_files_that_are_read_are_pushed() {
    let server = TestCluster::start(no_workers()).await;
    let (archive, folder) = (server.path("rope.zip"), server.path("rope"));
    run_ok(&["capture", "make", "rope", &archive, "--tiny"]);
    zip::ZipArchive::new(std::fs::File::open(&archive).unwrap()).unwrap().extract(&folder).unwrap();
    std::fs::write(format!("{folder}/.hidden"), "x").unwrap();
    std::fs::write(format!("{folder}/notes.txt"), "x").unwrap();

    let pushed = run_json(&["capture", "push", &folder, "--server", &server.url()]);
    assert_eq!(pushed["display_name"], "rope");
    let content = format!("/v1/{}/content", pushed["name"].as_str().unwrap());
    let content = server.http().get(&content).await.bytes().await.unwrap();
    let got = server.path("got.zip");
    std::fs::write(&got, content).unwrap();
    run_ok(&["capture", "check", &got]);
    let mut packed = zip::ZipArchive::new(std::fs::File::open(&got).unwrap()).unwrap();
    let mut made = zip::ZipArchive::new(std::fs::File::open(&archive).unwrap()).unwrap();
    for i in 0..made.len() {
        let (mut before, mut after) = (Vec::new(), Vec::new());
        let mut file = made.by_index(i).unwrap();
        file.read_to_end(&mut before).unwrap();
        let name = file.name().unwrap().into_owned();
        packed.by_name(&format!("rope/{name}")).unwrap().read_to_end(&mut after).unwrap();
        assert_eq!(before, after, "{name}");
    }
    assert_eq!(packed.len(), made.len(), "notes and hidden files are nobody's to read");
}
