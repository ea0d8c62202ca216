//! Quotas of bytes over every transport, with the bytes that reach the disk; and usage by owner.

use std::time::Duration;

use bendtwin_proto::v1::{
    CaptureMetadata, CreateCaptureRequest, GetUsageRequest, ListOwnerUsageRequest,
    capture_service_client::CaptureServiceClient, create_capture_request::Part,
    usage_service_client::UsageServiceClient,
};
use serde_json::{Value, json};
use tokio::{
    io::{AsyncReadExt as _, AsyncWriteExt as _},
    net::TcpStream,
};
use tonic::Code;

use super::keys::{bearer, locked, make};
use crate::harness::{Server, read};

const QUOTA: u64 = 400_000;
const FAR_BEYOND: usize = 120_000_000;

/// A key whose owner, ada, may have [`QUOTA`] bytes.
async fn key(server: &Server) -> String {
    let scopes =
        json!(["captures:read", "captures:write", "fits:write", "twins:read", "twins:write"]);
    let quotas = json!({"stored_bytes": QUOTA});
    make(server, json!({"display_name": "ada", "scopes": scopes, "quotas": quotas})).await.1
}

/// Sends a request without all of its body: `body` bytes in chunks, or none; until the server
/// answers or closes. Returns what it answered, and the most bytes of content that were on its disk
/// meanwhile.
async fn send(server: &Server, head: String, body: usize) -> (String, u64) {
    let stream = TcpStream::connect(server.handle.local_addr()).await.unwrap();
    let (mut answers, mut requests) = stream.into_split();
    requests.write_all(head.as_bytes()).await.unwrap();
    let sending = tokio::spawn(async move {
        let mut chunk = b"10000\r\n".to_vec();
        chunk.resize(chunk.len() + 0x10000, b'x');
        chunk.extend_from_slice(b"\r\n");
        for _ in 0..body.div_ceil(0x10000) {
            if requests.write_all(&chunk).await.is_err() {
                break;
            }
        }
        if body > 0 {
            let _ = requests.write_all(b"0\r\n\r\n").await;
        }
        // Not before the answer.
        requests
    });
    let (mut answer, mut most) = (String::new(), 0);
    let answered = async {
        let mut buffer = [0; 4096];
        loop {
            most = most.max(server.blob_bytes());
            match tokio::time::timeout(Duration::from_millis(5), answers.read(&mut buffer)).await {
                Err(_) => {}
                Ok(Ok(n)) if n > 0 => answer.push_str(&String::from_utf8_lossy(&buffer[..n])),
                Ok(_) => break,
            }
            if answer.contains("\"reason\"") {
                break;
            }
        }
    };
    tokio::time::timeout(Duration::from_secs(60), answered).await.unwrap();
    sending.abort();
    (answer, most)
}

/// The head of a request that keys make.
fn head(server: &Server, line: &str, key: &str, more: &str) -> String {
    let host = server.handle.local_addr();
    format!(
        "{line} HTTP/1.1\r\nhost: {host}\r\nauthorization: Bearer {key}\r\n\
         tus-resumable: 1.0.0\r\n{more}\r\n"
    )
}

/// A connection that is cut off in mid-body may lose the answer.
fn expect(answer: &str) {
    assert!(
        answer.is_empty()
            || answer.starts_with("HTTP/1.1 429") && answer.contains("QUOTA_STORED_BYTES"),
        "{answer}"
    );
}

async fn stored(server: &Server, key: &str) -> Value {
    let request = server.http.get(server.url("/v1/usage")).bearer_auth(key);
    let (status, usage) = read(request.send().await.unwrap()).await;
    assert_eq!(status, 200, "{usage}");
    usage["stored_bytes"].clone()
}

/// Waits until nothing is set aside for uploads.
async fn nothing_arrives(server: &Server, key: &str) {
    let settled = async {
        while stored(server, key).await["uploads"] != 0 {
            tokio::task::yield_now().await;
        }
    };
    tokio::time::timeout(Duration::from_secs(60), settled).await.unwrap();
}

#[tokio::test]
async fn an_upload_of_deferred_length_ends_where_the_quota_does() {
    let server = locked().await;
    let key = key(&server).await;
    let begin = || {
        let request = server.http.post(server.url("/v1/uploads")).bearer_auth(&key);
        request.header("tus-resumable", "1.0.0")
    };
    let begun = begin().header("upload-defer-length", "1").send().await.unwrap();
    assert_eq!(begun.status(), 201);
    let path = begun.headers()["location"].to_str().unwrap().to_owned();
    let patch = "content-type: application/offset+octet-stream\r\nupload-offset: 0\r\n";
    let line = format!("PATCH {path}");

    // A length that is declared is compared before the body.
    let declared = format!("{patch}content-length: {FAR_BEYOND}\r\n");
    let (answer, most) = send(&server, head(&server, &line, &key, &declared), 0).await;
    assert!(
        answer.starts_with("HTTP/1.1 429") && answer.contains("QUOTA_STORED_BYTES"),
        "{answer}"
    );
    assert_eq!(most, 0);

    let chunked = format!("{patch}transfer-encoding: chunked\r\n");
    let (answer, most) = send(&server, head(&server, &line, &key, &chunked), FAR_BEYOND).await;
    expect(&answer);
    assert!(most <= QUOTA, "{most}");
    // What came before is kept, and counts.
    let state = server.http.head(server.url(&path)).bearer_auth(&key);
    let state = state.header("tus-resumable", "1.0.0").send().await.unwrap();
    let offset: u64 = state.headers()["upload-offset"].to_str().unwrap().parse().unwrap();
    assert!((1..=QUOTA).contains(&offset), "{offset}");
    assert_eq!(server.blob_bytes(), offset);
    assert_eq!(stored(&server, &key).await["uploads"], offset);
    // Others of the owner have the rest alone, and all again once the upload is gone.
    let too_long = begin().header("upload-length", QUOTA - offset + 1).send().await.unwrap();
    assert_eq!(read(too_long).await.1["reason"], "QUOTA_STORED_BYTES");
    let terminated = server.http.delete(server.url(&path)).bearer_auth(&key);
    let terminated = terminated.header("tus-resumable", "1.0.0").send().await.unwrap();
    assert_eq!(terminated.status(), 204);
    assert_eq!(begin().header("upload-length", QUOTA).send().await.unwrap().status(), 201);
    let second = begin().header("upload-length", 1).send().await.unwrap();
    assert_eq!(read(second).await.1["reason"], "QUOTA_STORED_BYTES");
}

#[tokio::test]
async fn a_declared_length_beyond_the_quota_is_refused_before_the_body_is_read() {
    let server = locked().await;
    let key = key(&server).await;
    let upload = server.http.post(server.url("/v1/captures")).bearer_auth(&key).body("an archive");
    let (_, capture) = read(upload.send().await.unwrap()).await;
    let capture = capture["name"].as_str().unwrap();
    let cancel = server.http.post(server.url(&format!("/v1/{capture}/ingest/cancel")));
    assert_eq!(cancel.bearer_auth(&key).send().await.unwrap().status(), 200);
    let before = server.blob_bytes();
    for line in [
        "POST /v1/captures?display_name=rope".to_owned(),
        "POST /v1/twins?display_name=rope".to_owned(),
        format!("PUT /v1/{capture}/supplements/masks"),
    ] {
        let length = format!("content-length: {QUOTA}\r\n");
        let (answer, most) = send(&server, head(&server, &line, &key, &length), 0).await;
        assert!(answer.starts_with("HTTP/1.1 429"), "{line}: {answer}");
        assert!(answer.contains("QUOTA_STORED_BYTES"), "{line}: {answer}");
        assert_eq!(most, before, "{line}");
    }
    let length = format!("content-length: {}\r\n", 9u64 << 30);
    let large = head(&server, "POST /v1/captures?display_name=rope", &key, &length);
    let (answer, _) = send(&server, large, 0).await;
    assert!(answer.contains("CONTENT_TOO_LARGE"), "{answer}");
}

#[tokio::test]
async fn content_without_a_declared_length_is_cut_off_at_the_quota() {
    let server = locked().await;
    let key = key(&server).await;
    for line in ["POST /v1/captures?display_name=rope", "POST /v1/twins?display_name=rope"] {
        let chunked = head(&server, line, &key, "transfer-encoding: chunked\r\n");
        let (answer, most) = send(&server, chunked, FAR_BEYOND).await;
        expect(&answer);
        assert!(most <= QUOTA, "{line}: {most}");
        nothing_arrives(&server, &key).await;
    }
    let mut captures = CaptureServiceClient::with_interceptor(server.channel.clone(), bearer(&key));
    let metadata = CaptureMetadata { display_name: "rope".to_owned(), ..Default::default() };
    let chunk = || Part::Chunk(vec![b'x'; 65_536].into());
    let parts = std::iter::once(Part::Metadata(metadata)).chain((0..1_000).map(move |_| chunk()));
    let messages = parts.map(|part| CreateCaptureRequest { part: Some(part) });
    let refused = captures.create_capture(futures::stream::iter(messages)).await.unwrap_err();
    assert_eq!(refused.code(), Code::ResourceExhausted, "{refused}");
    nothing_arrives(&server, &key).await;
    assert_eq!(stored(&server, &key).await["total"], 0);
    assert_eq!(server.blob_bytes(), 0);
}

#[tokio::test]
async fn uploads_at_a_time_do_not_exceed_the_quota_together() {
    let server = locked().await;
    let key = key(&server).await;
    let uploads = (0..12).map(|_| {
        let request = server.http.post(server.url("/v1/captures")).bearer_auth(&key);
        let request = request.body(vec![b'x'; 90_000]);
        async move {
            let (status, answer) = read(request.send().await.unwrap()).await;
            assert!(status == 201 || answer["reason"] == "QUOTA_STORED_BYTES", "{status} {answer}");
            u64::from(status == 201)
        }
    });
    let made: u64 = futures::future::join_all(uploads).await.into_iter().sum();
    assert!((1..=4).contains(&made), "{made}");
    nothing_arrives(&server, &key).await;
    assert_eq!(stored(&server, &key).await["captures"], 90_000 * made);
}

/// A lost answer is asked for again by an owner who has nothing left.
#[tokio::test]
async fn a_repetition_needs_no_room() {
    let server = locked().await;
    let key = key(&server).await;
    let post = async |content: &'static [u8]| {
        let request = server.http.post(server.url("/v1/captures?display_name=rope"));
        let request = request.bearer_auth(&key).header("idempotency-key", "rope-1");
        read(request.body(content).send().await.unwrap()).await
    };
    static ALL: [u8; QUOTA as usize] = [b'x'; QUOTA as usize];
    static OTHER: [u8; QUOTA as usize] = [b'y'; QUOTA as usize];
    let (status, first) = post(&ALL[..]).await;
    assert_eq!(status, 201, "{first}");
    let (status, again) = post(&ALL[..]).await;
    assert_eq!((status, &again["name"]), (201, &first["name"]), "{again}");
    let (status, other) = post(&OTHER[..]).await;
    assert_eq!((status, &other["reason"]), (409, &json!("REQUEST_ID_TAKEN")), "{other}");
    assert_eq!(server.blob_bytes(), QUOTA);
}

#[tokio::test]
async fn users_see_their_usage_and_operators_that_of_all() {
    let server = crate::harness::Server::start_with(|o| {
        o.client_token = bendtwin_server::ClientTokenPolicy::Required;
        o.quotas.queued_jobs = Some(7);
        o.quotas.stored_bytes = Some(5);
    })
    .await;
    let key = key(&server).await;
    let (_, other) = make(
        &server,
        json!({"display_name": "b\"ob\\", "scopes": ["captures:write", "captures:read"]}),
    )
    .await;
    let upload = |key: &str, body: &'static str| {
        server.http.post(server.url("/v1/captures")).bearer_auth(key).body(body).send()
    };
    assert_eq!(upload(&key, "an archive").await.unwrap().status(), 201);
    // The server's bound for keys that state none.
    let refused = read(upload(&other, "an archive").await.unwrap()).await.1;
    assert_eq!(refused["reason"], "QUOTA_STORED_BYTES");
    assert_eq!(upload(&other, "small").await.unwrap().status(), 201);

    let get = async |path: &str, key: &str| {
        read(server.http.get(server.url(path)).bearer_auth(key).send().await.unwrap()).await
    };
    let (_, usage) = get("/v1/usage", &key).await;
    let expected = json!({
        "owner": "ada",
        "captures": 1,
        "fits": 0,
        "twins": 0,
        "stored_bytes": {
            "total": 10, "captures": 10, "derived": 0, "twins": 0, "checkpoints": 0, "uploads": 0,
        },
        "queued_jobs": 1,
        "running_jobs": 0,
        "quotas": {"queued_jobs": 7, "stored_bytes": QUOTA, "rollouts": null,
            "running_jobs": null, "fit_run_s": null, "priority": null},
    });
    assert_eq!(usage, expected);
    assert_eq!(get("/v1/usage/owners", &key).await.1["reason"], "SCOPE_MISSING");
    let token = server.handle.client_token().unwrap();
    let (_, all) = get("/v1/usage/owners?page_size=1", token).await;
    assert_eq!(all["owners"], json!([expected]));
    let rest = format!("/v1/usage/owners?page_token={}", all["next_page_token"].as_str().unwrap());
    let (_, rest) = get(&rest, token).await;
    assert_eq!(rest["owners"][0]["owner"], "b\"ob\\");
    assert_eq!(rest["owners"][0]["quotas"]["stored_bytes"], 5);

    let mut usage = UsageServiceClient::with_interceptor(server.channel.clone(), bearer(&other));
    let own = usage.get_usage(GetUsageRequest {}).await.unwrap().into_inner();
    assert_eq!(own.stored_bytes.unwrap().total, 5);
    let refused = usage.list_owner_usage(ListOwnerUsageRequest::default()).await.unwrap_err();
    assert_eq!(refused.code(), Code::PermissionDenied);

    let metrics = server.http.get(server.url("/metrics")).bearer_auth(token).send().await.unwrap();
    let metrics = metrics.text().await.unwrap();
    for line in [
        "bendtwin_owner_stored_bytes{owner=\"ada\"} 10",
        "bendtwin_owner_stored_bytes{owner=\"b_ob_\"} 5",
        "bendtwin_owner_stored_bytes{owner=\"other\"} 0",
        "bendtwin_owner_jobs{owner=\"ada\",state=\"queued\"} 1",
    ] {
        assert!(metrics.lines().any(|found| found == line), "{line}: {metrics}");
    }
}
