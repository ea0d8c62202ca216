//! Two servers with their rows in PostgreSQL and all content in one bucket: an upload that begins
//! at one, which dies during it, resumes at the other, and its capture becomes a twin there.

use std::time::Duration;

use bytes::Bytes;
use futures::StreamExt as _;
use reqwest::{Body, Method, RequestBuilder, StatusCode};

use super::tls_terminator::TlsTerminator;
use crate::harness::{
    Postgres, Setup, TestCluster,
    command::bendtwin,
    http::Http,
    reference::{FIT, SETTINGS, capture},
    until,
};

/// Environment variable with the address of an S3 server (`tests/s3`).
const S3: &str = "BENDTWIN_TEST_S3";
/// Environment variable with `ID:SECRET` of the one key of a server that checks signatures.
const KEY: &str = "BENDTWIN_TEST_S3_KEY";
const MIB: usize = 1 << 20;
const DEADLINE: Duration = Duration::from_secs(60);

/// A server's environment: the bucket, and keys for it.
pub(crate) fn environment(endpoint: &str, prefix: &str) -> Vec<(&'static str, String)> {
    let (id, secret) = key();
    vec![
        ("BENDTWIN_OBJECTS", format!("s3://bendtwin-test/{prefix}")),
        ("AWS_ENDPOINT_URL", endpoint.to_owned()),
        ("AWS_REGION", "us-east-1".to_owned()),
        ("AWS_ACCESS_KEY_ID", id),
        ("AWS_SECRET_ACCESS_KEY", secret),
    ]
}

/// Id and secret; of a server that checks no signatures, any.
fn key() -> (String, String) {
    let key = std::env::var(KEY).unwrap_or("test:secret-not-to-be-shown".to_owned());
    let (id, secret) = key.split_once(':').unwrap();
    (id.to_owned(), secret.to_owned())
}

pub(super) fn endpoint_or_skip() -> Option<String> {
    let endpoint = std::env::var(S3).ok();
    if endpoint.is_none() {
        eprintln!("SKIPPED: {S3} names no S3 server");
    }
    endpoint
}

fn tus(http: &Http, method: &str, path: &str) -> RequestBuilder {
    let method = Method::from_bytes(method.as_bytes()).unwrap();
    http.request(method, path).header("tus-resumable", "1.0.0")
}

fn patch(http: &Http, path: &str, offset: usize, body: impl Into<Body>) -> RequestBuilder {
    let request = tus(http, "PATCH", path).header("upload-offset", offset);
    request.header("content-type", "application/offset+octet-stream").body(body)
}

async fn begin(http: &Http, length: usize) -> String {
    let begun = tus(http, "POST", "/v1/uploads").header("upload-length", length);
    let begun = begun.send().await.unwrap();
    assert_eq!(begun.status(), StatusCode::CREATED, "{}", begun.text().await.unwrap());
    begun.headers()["location"].to_str().unwrap().to_owned()
}

/// The acknowledged bytes, once no dead server holds the upload any more.
async fn offset(http: &Http, path: &str) -> usize {
    until("the upload to be free", DEADLINE, async || {
        let head = tus(http, "HEAD", path).send().await.unwrap();
        head.headers().get("upload-offset")?.to_str().ok()?.parse().ok()
    })
    .await
}

/// Content that does not repeat.
fn noise(length: usize) -> Vec<u8> {
    let word = |i: u64| (i.wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 11).to_le_bytes();
    (0..length as u64 / 8).flat_map(word).collect()
}

#[tokio::test]
async fn a_capture_pushed_through_two_servers_becomes_a_twin() {
    let Some(endpoint) = endpoint_or_skip() else { return };
    let Some(postgres) = Postgres::start_or_skip().await else { return };
    let environment = environment(&endpoint, &format!("e2e-{}", std::process::id()));
    let database = Some(postgres.url_with_password("unused"));
    let setup = Setup { database, environment, own_workers: 0, ..Setup::default() };
    let mut first = TestCluster::start(setup.clone()).await;
    let second = TestCluster::start(Setup { own_workers: 1, ..setup }).await;

    // Half of a capture through either.
    let archive = capture().await;
    let half = archive.len() / 2;
    let path = begin(&first.http(), archive.len()).await;
    let sent = patch(&first.http(), &path, 0, archive[..half].to_vec()).send().await.unwrap();
    assert_eq!(sent.status(), StatusCode::NO_CONTENT, "{}", sent.text().await.unwrap());
    assert_eq!(offset(&second.http(), &path).await, half);
    let sent = patch(&second.http(), &path, half, archive[half..].to_vec()).send().await.unwrap();
    assert_eq!(sent.status(), StatusCode::NO_CONTENT, "{}", sent.text().await.unwrap());

    // A server dies while content of several parts arrives; what it had saved is at the other.
    let long = noise(80 * MIB);
    let large = begin(&first.http(), long.len()).await;
    let pieces: Vec<_> = long[..72 * MIB].chunks(MIB).map(Bytes::copy_from_slice).collect();
    let stuck = futures::stream::iter(pieces.into_iter().map(Ok::<_, std::io::Error>));
    let body = Body::wrap_stream(stuck.chain(futures::stream::pending()));
    let request = patch(&first.http(), &large, 0, body);
    let sending = tokio::spawn(async move { request.send().await });
    until("64 MiB to be saved", DEADLINE, async || {
        let listed: serde_json::Value = second.http().get("/v1/uploads").await.json().await.ok()?;
        let uploads = listed["uploads"].as_array()?;
        let saved = uploads.iter().filter_map(|upload| upload["offset_bytes"].as_u64()).max()?;
        (saved >= 64 * MIB as u64).then_some(())
    })
    .await;
    first.kill();
    sending.await.unwrap().unwrap_err();
    let at = offset(&second.http(), &large).await;
    assert_eq!(at, 64 * MIB);
    let sent = patch(&second.http(), &large, at, long[at..].to_vec()).send().await.unwrap();
    assert_eq!(sent.status(), StatusCode::NO_CONTENT, "{}", sent.text().await.unwrap());

    first.start_again().await;
    let api = first.api();
    let captures = api.list_captures().await.unwrap();
    assert_eq!(captures.len(), 2);
    for stored in &captures {
        let content = first.http().get(&format!("/v1/{}/content", stored.name)).await;
        let content = content.bytes().await.unwrap();
        assert!(content == archive || content == long, "{}", stored.name);
    }
    let small = captures.iter().find(|c| c.size_bytes == archive.len() as u64).unwrap();
    let fit = second.api().fit(&small.name, SETTINGS, 0).await.unwrap();
    let fitted = second.api().succeeded(&fit.name, FIT).await;
    let twin = first.api().export(&fitted.twin).await.unwrap();
    assert!(bendtwin_core::Twin::decode(&twin).is_ok());

    // Neither logs nor workers have the keys.
    let (_, secret) = key();
    for server in [&first, &second] {
        assert!(!server.log().contains(&secret), "a key is in a log");
    }
    for worker in second.worker_pids() {
        let environment = std::fs::read(format!("/proc/{worker}/environ")).unwrap();
        let environment = String::from_utf8_lossy(&environment);
        assert!(!environment.contains("AWS_") && !environment.contains("BENDTWIN_OBJECTS"));
    }
}

#[tokio::test]
async fn an_unreachable_bucket_is_reported_without_delay() {
    let Some(endpoint) = endpoint_or_skip() else { return };
    let proxy = crate::harness::stalling_proxy::StallingProxy::to(&endpoint, u64::MAX).await;
    let environment = environment(proxy.url(), &format!("away-{}", std::process::id()));
    let server =
        TestCluster::start(Setup { own_workers: 0, environment, ..Setup::default() }).await;
    let stored = server.api().upload(&Bytes::from_static(b"content"), "kept").await.unwrap();
    let path = format!("/v1/{}/content", stored.name);
    assert_eq!(server.http().get(&path).await.bytes().await.unwrap(), b"content"[..]);
    // Connections end with each request there, so no connection is left.
    drop(proxy);
    let refused = server.http().get(&path).await;
    assert_eq!(refused.status(), StatusCode::SERVICE_UNAVAILABLE);
    let problem: serde_json::Value = refused.json().await.unwrap();
    assert_eq!(problem["reason"], "OBJECTS_UNAVAILABLE", "{problem}");
    assert!(!server.http().is_ready().await);
}

#[tokio::test]
async fn a_wrong_secret_is_reported_and_not_shown() {
    let Some(endpoint) = endpoint_or_skip() else { return };
    if std::env::var_os(KEY).is_none() {
        return eprintln!("SKIPPED: {KEY} has no key of an S3 server that checks signatures");
    }
    let mut environment = environment(&endpoint, &format!("wrong-{}", std::process::id()));
    const WRONG: &str = "another-secret-than-that-of-the-key";
    for (name, value) in &mut environment {
        if *name == "AWS_SECRET_ACCESS_KEY" {
            WRONG.clone_into(value);
        }
    }
    let said = refused_start(environment).await;
    for words in ["the keys are wrong or do not allow it", "AWS_"] {
        assert!(said.contains(words), "{said}");
    }
    let (_, secret) = key();
    assert!(!said.contains(WRONG) && !said.contains(&secret), "{said}");
}

/// Over TLS of a private authority, which the server is configured with.
#[tokio::test]
async fn a_bucket_has_a_certificate_of_a_private_authority() {
    let Some(endpoint) = endpoint_or_skip() else { return };
    let behind = TlsTerminator::to(endpoint.strip_prefix("http://").unwrap()).await;
    let mut environment = environment(behind.url(), &format!("tls-{}", std::process::id()));
    let said = refused_start(environment.clone()).await;
    for words in ["of an authority that is not trusted here", "AWS_CA_BUNDLE"] {
        assert!(said.contains(words), "{said}");
    }
    environment.push(("AWS_CA_BUNDLE", behind.authority()));
    let server =
        TestCluster::start(Setup { own_workers: 0, environment, ..Setup::default() }).await;
    let stored = server.api().upload(&Bytes::from_static(b"content"), "kept").await.unwrap();
    let content = server.http().get(&format!("/v1/{}/content", stored.name)).await;
    assert_eq!(content.bytes().await.unwrap(), b"content"[..]);
}

/// The words of a server that does not start with this environment.
async fn refused_start(environment: Vec<(&'static str, String)>) -> String {
    let folder = tempfile::tempdir().unwrap();
    let run = move || {
        let mut command = bendtwin();
        command.args(["server", "--workers", "0", "--listen", "127.0.0.1:0", "--data-dir"]);
        command.arg(folder.path().join("data")).envs(environment).output().unwrap()
    };
    let done = tokio::task::spawn_blocking(run).await.unwrap();
    assert!(!done.status.success(), "it has started and stopped");
    String::from_utf8_lossy(&[done.stdout, done.stderr].concat()).into_owned()
}
