//! Resumable uploads by the tus protocol, 1.0.0: its requirements on servers, with the prescribed
//! statuses, and additions of this server.

use std::time::Duration;

use base64::{Engine as _, prelude::BASE64_STANDARD};
use bendtwin_server::ClientTokenPolicy;
use reqwest::{Method, RequestBuilder, Response};
use serde_json::Value;
use tokio::io::{AsyncReadExt as _, AsyncWriteExt as _};

use crate::harness::{Server, read};

const TYPE: &str = "application/offset+octet-stream";

impl Server {
    fn tus(&self, method: &str, path: &str) -> RequestBuilder {
        let method = Method::from_bytes(method.as_bytes()).unwrap();
        self.http.request(method, self.url(path)).header("tus-resumable", "1.0.0")
    }

    /// Begins an upload; returns its path.
    async fn begin(&self, length: usize, metadata: &str) -> String {
        let request = self.tus("POST", "/v1/uploads").header("upload-length", length);
        let response = request.header("upload-metadata", metadata).send().await.unwrap();
        assert_eq!(response.status(), 201);
        assert!(header(&response, "upload-expires").unwrap().ends_with(" GMT"));
        header(&response, "location").unwrap()
    }

    fn patch(&self, path: &str, offset: usize, body: &[u8]) -> RequestBuilder {
        let request = self.tus("PATCH", path).header("content-type", TYPE);
        request.header("upload-offset", offset).body(body.to_vec())
    }

    async fn offset(&self, path: &str) -> Option<String> {
        header(&self.tus("HEAD", path).send().await.unwrap(), "upload-offset")
    }
}

fn header(response: &Response, name: &str) -> Option<String> {
    response.headers().get(name).map(|v| v.to_str().unwrap().to_owned())
}

/// Status and reason of a refusal, which must have the headers of tus and a problem document.
async fn refusal(request: RequestBuilder) -> (u16, String) {
    let response = request.send().await.unwrap();
    assert_eq!(header(&response, "tus-resumable").unwrap(), "1.0.0");
    assert_eq!(header(&response, "content-type").unwrap(), "application/problem+json");
    let (status, problem) = read(response).await;
    assert_eq!(problem["status"], status);
    (status, problem["reason"].as_str().unwrap_or_default().to_owned())
}

fn expect(got: (u16, String), status: u16, reason: &str) {
    assert_eq!(got, (status, reason.to_owned()));
}

fn base64(bytes: impl AsRef<[u8]>) -> String {
    BASE64_STANDARD.encode(bytes)
}

fn content(length: usize) -> Vec<u8> {
    (0..length).map(|i| (i % 251) as u8).collect()
}

#[tokio::test]
async fn options_say_what_is_understood() {
    let server = Server::start().await;
    // Clients should not name a version here, and one that is named does not matter.
    let request = server.http.request(Method::OPTIONS, server.url("/v1/uploads"));
    let response = request.header("tus-resumable", "0.2.2").send().await.unwrap();
    assert_eq!(response.status(), 204);
    let list = |name| header(&response, name).unwrap();
    assert_eq!((list("tus-resumable"), list("tus-version")), ("1.0.0".into(), "1.0.0".into()));
    assert_eq!(
        list("tus-extension"),
        "creation,creation-with-upload,creation-defer-length,checksum,expiration,termination"
    );
    assert_eq!(list("tus-max-size"), (8u64 << 30).to_string());
    assert_eq!(list("tus-checksum-algorithm"), "sha1,sha256,blake3");
}

/// Clients ask what is understood before they show who they are; all else takes the token.
#[tokio::test]
async fn options_need_no_token() {
    let server = Server::start_with(|o| o.client_token = ClientTokenPolicy::Required).await;
    let token = server.handle.client_token().unwrap().to_owned();
    let ask = |method: Method| server.http.request(method, server.url("/v1/uploads"));
    assert_eq!(ask(Method::OPTIONS).send().await.unwrap().status(), 204);
    assert_eq!(ask(Method::GET).send().await.unwrap().status(), 401);
    let overridden = ask(Method::OPTIONS).header("x-http-method-override", "GET").send();
    assert_eq!(overridden.await.unwrap().status(), 403);
    for method in [Method::OPTIONS, Method::GET] {
        let shown = ask(method).bearer_auth(&token).send().await.unwrap();
        assert!(shown.status().is_success(), "{}", shown.status());
    }
}

#[tokio::test]
async fn an_upload_in_parts_becomes_a_capture() {
    let server = Server::start().await;
    let content = content(3_000_000);
    let digest = blake3::hash(&content).to_hex();
    let metadata = format!(
        "filename {},display_name {},digest {},mine AAEC,empty",
        base64("rope.zip"),
        base64("ein Seil, geknüpft"),
        base64(digest.as_bytes())
    );
    let path = server.begin(content.len(), &metadata).await;
    let first = server.tus("HEAD", &path).send().await.unwrap();
    assert_eq!(first.status(), 200);
    assert_eq!(header(&first, "upload-offset").unwrap(), "0");
    assert_eq!(header(&first, "upload-length").unwrap(), "3000000");
    assert_eq!(header(&first, "upload-metadata").unwrap(), metadata);
    assert_eq!(header(&first, "cache-control").unwrap(), "no-store");

    let sent = server.patch(&path, 0, &content[..1_000_001]).send().await.unwrap();
    assert_eq!(sent.status(), 204);
    assert_eq!(header(&sent, "upload-offset").unwrap(), "1000001");
    assert!(header(&sent, "upload-expires").unwrap().ends_with(" GMT"));
    assert_eq!(header(&sent, "tus-resumable").unwrap(), "1.0.0");
    let (_, shown) = server.get(&path).await;
    assert_eq!((&shown["state"], &shown["offset_bytes"]), (&"RECEIVING".into(), &1_000_001.into()));

    let last = server.patch(&path, 1_000_001, &content[1_000_001..]).send().await.unwrap();
    assert_eq!(last.status(), 204);
    assert_eq!(header(&last, "upload-offset").unwrap(), "3000000");
    let name = header(&last, "bendtwin-capture").unwrap();
    let location = header(&last, "content-location").unwrap();
    assert_eq!(location, format!("/v1/{name}"));
    let (_, capture) = server.get(&location).await;
    assert_eq!(capture["display_name"], "ein Seil, geknüpft");
    assert_eq!(capture["digest"], digest.as_str());
    let got = server.http.get(server.url(&format!("{location}/content"))).send().await.unwrap();
    assert!(got.bytes().await.unwrap() == content);
    assert_eq!(server.blob_files(), 1, "the partial file became the blob");

    // Afterwards it answers as before, and an empty part at its end changes nothing.
    let whole = server.tus("HEAD", &path).send().await.unwrap();
    assert_eq!(header(&whole, "upload-offset").unwrap(), "3000000");
    assert_eq!(header(&whole, "bendtwin-capture").unwrap(), name);
    let empty = server.patch(&path, 3_000_000, b"").send().await.unwrap();
    assert_eq!((empty.status().as_u16(), header(&empty, "bendtwin-capture")), (204, Some(name)));
    expect(refusal(server.patch(&path, 3_000_000, b"x")).await, 413, "CONTENT_TOO_LARGE");
    let (_, shown) = server.get(&path).await;
    assert_eq!((&shown["state"], &shown["capture"]), (&"STORED".into(), &capture["name"]));
}

#[tokio::test]
async fn requests_that_break_the_protocol_are_refused_with_its_statuses() {
    let server = Server::start_with(|o| o.limits.capture_bytes = 1000).await;
    let path = server.begin(10, "").await;
    server.patch(&path, 0, b"abc").send().await.unwrap();

    // Versions: none, another.
    for request in [
        server.http.head(server.url(&path)),
        server.http.post(server.url("/v1/uploads")).header("upload-length", 5),
        server.http.patch(server.url(&path)).header("tus-resumable", "0.2.2"),
    ] {
        let response = request.send().await.unwrap();
        assert_eq!(response.status(), 412);
        assert_eq!(header(&response, "tus-version").unwrap(), "1.0.0");
    }
    // Offsets.
    for offset in [0, 2, 4] {
        expect(refusal(server.patch(&path, offset, b"d")).await, 409, "UPLOAD_OFFSET");
    }
    for offset in ["", "-1", "3.0", "99999999999999999999", "x"] {
        let request = server.tus("PATCH", &path).header("content-type", TYPE);
        let request = request.header("upload-offset", offset).body("d");
        expect(refusal(request).await, 400, "INVALID_FIELD");
    }
    let missing = server.tus("PATCH", &path).header("content-type", TYPE).body("d");
    expect(refusal(missing).await, 400, "INVALID_FIELD");
    // Types.
    let typed = server.tus("PATCH", &path).header("upload-offset", 3).body("d");
    expect(refusal(typed).await, 415, "UNSUPPORTED_MEDIA_TYPE");
    let typed = server.tus("PATCH", &path).header("content-type", "application/zip");
    let typed = typed.header("upload-offset", 3).body("d");
    expect(refusal(typed).await, 415, "UNSUPPORTED_MEDIA_TYPE");
    // Sizes.
    expect(refusal(server.patch(&path, 3, b"12345678")).await, 413, "CONTENT_TOO_LARGE");
    let create = |name: &'static str, value: &'static str| {
        server.tus("POST", "/v1/uploads").header(name, value)
    };
    expect(refusal(create("upload-length", "1001")).await, 413, "CONTENT_TOO_LARGE");
    for (name, value) in [
        ("upload-length", "0"),
        ("upload-length", "ten"),
        ("upload-defer-length", "2"),
        ("upload-metadata", "x"),
    ] {
        expect(refusal(create(name, value)).await, 400, "INVALID_FIELD");
    }
    for metadata in ["a YQ==,a YQ==", ",", "a ?", &format!("digest {}", base64("xyz"))] {
        let request = create("upload-length", "5").header("upload-metadata", metadata);
        expect(refusal(request).await, 400, "INVALID_FIELD");
    }
    // Names.
    let unknown = "/v1/uploads/0190a000-0000-7000-8000-00000000dead";
    expect(refusal(server.patch(unknown, 0, b"d")).await, 404, "NOT_FOUND");
    expect(refusal(server.tus("DELETE", unknown)).await, 404, "NOT_FOUND");
    let response = server.tus("HEAD", unknown).send().await.unwrap();
    assert_eq!((response.status().as_u16(), header(&response, "upload-offset")), (404, None));
    // Nothing of it changed anything.
    assert_eq!(server.offset(&path).await.unwrap(), "3");
}

#[tokio::test]
async fn a_body_longer_than_the_upload_is_refused_without_a_declared_size_too() {
    let server = Server::start().await;
    let path = server.begin(10, "").await;
    let parts = ["abcde", "fghij", "k"].map(Ok::<_, std::io::Error>);
    let body = reqwest::Body::wrap_stream(futures::stream::iter(parts));
    let request = server.tus("PATCH", &path).header("content-type", TYPE);
    let request = request.header("upload-offset", 0).body(body);
    expect(refusal(request).await, 413, "CONTENT_TOO_LARGE");
    assert_eq!(server.offset(&path).await.unwrap(), "0");
    assert_eq!(server.get("/v1/captures").await.1["captures"], Value::Array(vec![]));
}

#[tokio::test]
async fn parts_whose_checksum_differs_leave_no_trace() {
    let server = Server::start().await;
    let path = server.begin(11, "").await;
    let with = |algorithm: &str, sum: &[u8]| {
        let value = format!("{algorithm} {}", base64(sum));
        server.patch(&path, 0, b"hello world").header("upload-checksum", value)
    };
    expect(refusal(with("sha1", &[7; 20])).await, 460, "CHECKSUM_MISMATCH");
    expect(refusal(with("md5", &[7; 16])).await, 400, "INVALID_FIELD");
    expect(refusal(with("sha1", &[7; 16])).await, 400, "INVALID_FIELD");
    assert_eq!(server.offset(&path).await.unwrap(), "0");
    let right = server.patch(&path, 0, b"hello world");
    let right = right.header("upload-checksum", "sha1 Kq5sNclPz7QV2+lfQIuc6R7oRu0=");
    let sent = right.send().await.unwrap();
    assert_eq!(
        (sent.status().as_u16(), header(&sent, "upload-offset").unwrap().as_str()),
        (204, "11")
    );
    assert!(header(&sent, "bendtwin-capture").is_some());
}

#[tokio::test]
async fn the_length_may_come_later_but_once() {
    let server = Server::start().await;
    let request = server.tus("POST", "/v1/uploads").header("upload-defer-length", 1);
    let path = header(&request.send().await.unwrap(), "location").unwrap();
    server.patch(&path, 0, b"abc").send().await.unwrap();
    let head = server.tus("HEAD", &path).send().await.unwrap();
    assert_eq!(header(&head, "upload-defer-length").unwrap(), "1");
    assert_eq!(
        (header(&head, "upload-length"), header(&head, "upload-offset")),
        (None, Some("3".into()))
    );
    let length = |n: u32, body: &[u8]| server.patch(&path, 3, body).header("upload-length", n);
    expect(refusal(length(2, b"")).await, 400, "UPLOAD_LENGTH");
    assert_eq!(length(6, b"").send().await.unwrap().status(), 204);
    expect(refusal(length(7, b"")).await, 400, "UPLOAD_LENGTH");
    let head = server.tus("HEAD", &path).send().await.unwrap();
    assert_eq!(
        (header(&head, "upload-defer-length"), header(&head, "upload-length")),
        (None, Some("6".into()))
    );
    let sent = length(6, b"def").send().await.unwrap();
    assert!(header(&sent, "bendtwin-capture").is_some());
}

#[tokio::test]
async fn content_may_come_with_the_creation() {
    let server = Server::start().await;
    let create = |body: &'static str, kind: &'static str| {
        let request = server.tus("POST", "/v1/uploads").header("upload-length", 6);
        request.header("idempotency-key", "key").header("content-type", kind).body(body)
    };
    expect(refusal(create("abc", "text/plain")).await, 415, "UNSUPPORTED_MEDIA_TYPE");
    let created = create("abc", TYPE).send().await.unwrap();
    assert_eq!(
        (created.status().as_u16(), header(&created, "upload-offset").unwrap().as_str()),
        (201, "3")
    );
    // The same again resumes where the first one stopped.
    let again = create("abc", TYPE).send().await.unwrap();
    assert_eq!(header(&again, "location"), header(&created, "location"));
    assert_eq!(header(&again, "upload-offset").unwrap(), "3");
    let path = header(&again, "location").unwrap();
    let sent = server.patch(&path, 3, b"def").send().await.unwrap();
    let name = header(&sent, "bendtwin-capture").unwrap();
    let known = create("abcdef", TYPE).send().await.unwrap();
    assert_eq!(header(&known, "bendtwin-capture").unwrap(), name);
    // Captures use the same key.
    let request = server.http.post(server.url("/v1/captures")).header("idempotency-key", "key");
    let (status, plain) = read(request.body("abcdef").send().await.unwrap()).await;
    assert_eq!((status, plain["name"].as_str().unwrap()), (201, name.as_str()));
    let request = server.tus("POST", "/v1/uploads").header("upload-length", 7);
    expect(refusal(request.header("idempotency-key", "key")).await, 409, "REQUEST_ID_TAKEN");
    // Deleted, it comes again only by an upload that begins without content.
    assert_eq!(server.delete(&format!("/v1/{name}")).await.0, 204);
    expect(refusal(create("abcdef", TYPE)).await, 409, "DELETED_SINCE");
    let request = server.tus("POST", "/v1/uploads").header("upload-length", 6);
    let begun = request.header("idempotency-key", "key").send().await.unwrap();
    let sent =
        server.patch(&header(&begun, "location").unwrap(), 0, b"abcdef").send().await.unwrap();
    assert_ne!(header(&sent, "bendtwin-capture").unwrap(), name);
}

#[tokio::test]
async fn terminated_uploads_are_gone() {
    let server = Server::start().await;
    let path = server.begin(10, "").await;
    server.patch(&path, 0, b"abc").send().await.unwrap();
    assert_eq!(server.blob_files(), 1);
    assert_eq!(server.tus("DELETE", &path).send().await.unwrap().status(), 204);
    assert_eq!(server.blob_files(), 0);
    expect(refusal(server.patch(&path, 3, b"def")).await, 410, "UPLOAD_GONE");
    expect(refusal(server.tus("DELETE", &path)).await, 410, "UPLOAD_GONE");
    let response = server.tus("HEAD", &path).send().await.unwrap();
    assert_eq!((response.status().as_u16(), header(&response, "upload-offset")), (410, None));
    assert_eq!(server.get(&path).await.1["state"], "GONE");
}

#[tokio::test]
async fn the_method_may_stand_in_a_header() {
    let server = Server::start().await;
    let path = server.begin(10, "").await;
    let meant =
        |method: &'static str| server.tus("POST", &path).header("x-http-method-override", method);
    let sent = meant("PATCH").header("content-type", TYPE).header("upload-offset", 0).body("abc");
    let sent = sent.send().await.unwrap();
    assert_eq!(
        (sent.status().as_u16(), header(&sent, "upload-offset").unwrap().as_str()),
        (204, "3")
    );
    assert_eq!(meant("DELETE").send().await.unwrap().status(), 204);
}

#[tokio::test]
async fn content_that_is_not_the_declared_one_is_refused_for_good() {
    let server = Server::start().await;
    let digest = format!("digest {}", base64(blake3::hash(b"right").to_hex().as_bytes()));
    let path = server.begin(5, &digest).await;
    expect(refusal(server.patch(&path, 0, b"wrong")).await, 400, "DIGEST_MISMATCH");
    expect(refusal(server.patch(&path, 5, b"")).await, 410, "UPLOAD_GONE");
    let why = server.get(&path).await.1["why"].as_str().unwrap().to_owned();
    assert!(why.contains("refused") && why.contains("digest"), "{why}");
    assert_eq!(server.get("/v1/captures").await.1["captures"], Value::Array(vec![]));
    assert_eq!(server.blob_files(), 0);
}

/// Headers of a PATCH that announces more than it sends.
fn half_a_patch(path: &str, body: &str) -> String {
    format!(
        "PATCH {path} HTTP/1.1\r\nhost: localhost\r\ntus-resumable: 1.0.0\r\ncontent-type: {TYPE}\r\n\
         upload-offset: 0\r\ncontent-length: 100\r\n\r\n{body}"
    )
}

/// The server has not noticed that a connection is dead; its client is back already.
#[tokio::test]
async fn a_client_that_is_back_takes_over_from_its_dead_connection() {
    let server = Server::start().await;
    let path = server.begin(100, "").await;
    let mut dead = tokio::net::TcpStream::connect(server.handle.local_addr()).await.unwrap();
    dead.write_all(half_a_patch(&path, "0123456789").as_bytes()).await.unwrap();
    // The bytes are on their way: ask until they are there. Asking disturbs no upload.
    let refused = async |stream: &tokio::net::TcpStream| {
        tokio::time::timeout(Duration::from_millis(100), stream.peek(&mut [0])).await.is_ok()
    };
    let arrived = async {
        loop {
            match server.offset(&path).await.unwrap().as_str() {
                "10" => break,
                // The holder has been refused, because it gave way before it had anything, and the
                // bytes are to be sent again; or it has not come so far.
                _ if refused(&dead).await => {
                    dead =
                        tokio::net::TcpStream::connect(server.handle.local_addr()).await.unwrap();
                    dead.write_all(half_a_patch(&path, "0123456789").as_bytes()).await.unwrap();
                }
                _ => {}
            }
        }
    };
    tokio::time::timeout(Duration::from_secs(60), arrived).await.unwrap();
    let sent = server.patch(&path, 10, &[b'x'; 90]).send().await.unwrap();
    assert!(header(&sent, "bendtwin-capture").is_some());
    let mut answer = vec![0; 12];
    dead.read_exact(&mut answer).await.unwrap();
    assert_eq!(answer, b"HTTP/1.1 423");
}

#[tokio::test]
async fn what_came_before_a_connection_broke_or_fell_silent_lasts() {
    let server = Server::start_with(|o| o.limits.upload_idle_s = 0.2).await;
    let path = server.begin(100, "").await;
    let mut silent = tokio::net::TcpStream::connect(server.handle.local_addr()).await.unwrap();
    silent.write_all(half_a_patch(&path, "0123456789").as_bytes()).await.unwrap();
    let mut answer = vec![0; 12];
    silent.read_exact(&mut answer).await.unwrap();
    assert_eq!(answer, b"HTTP/1.1 400");
    assert_eq!(server.offset(&path).await.unwrap(), "10");
    // What a checksum was announced for does not count without the rest.
    let path = server.begin(100, "").await;
    let patch = half_a_patch(&path, "0123456789").replace(
        "content-length",
        "upload-checksum: sha1 Kq5sNclPz7QV2+lfQIuc6R7oRu0=\r\ncontent-length",
    );
    let mut broken = tokio::net::TcpStream::connect(server.handle.local_addr()).await.unwrap();
    broken.write_all(patch.as_bytes()).await.unwrap();
    broken.read_exact(&mut answer).await.unwrap();
    assert_eq!(answer, b"HTTP/1.1 400");
    assert_eq!(server.offset(&path).await.unwrap(), "0");
}

#[tokio::test]
async fn uploads_survive_a_restart_and_expire_in_the_end() {
    let server = Server::start().await;
    let path = server.begin(10, "").await;
    server.patch(&path, 0, b"abcde").send().await.unwrap();
    let Server { dir, handle, .. } = server;
    handle.shutdown().await;

    let server = Server::start_in(dir, |_| ()).await;
    assert_eq!(server.offset(&path).await.unwrap(), "5");
    let sent = server.patch(&path, 5, b"fghij").send().await.unwrap();
    assert!(header(&sent, "bendtwin-capture").is_some());
    let Server { dir, handle, .. } = server;
    handle.shutdown().await;

    let server = Server::start_in(dir, |o| o.upload_expiry_s = 1.0).await;
    let path = server.begin(10, "").await;
    let gone = async {
        while server.get(&path).await.1["state"] != "GONE" {
            tokio::time::sleep(Duration::from_millis(20)).await;
        }
    };
    tokio::time::timeout(Duration::from_secs(60), gone).await.unwrap();
}

#[tokio::test]
async fn uploads_under_way_are_bounded() {
    let server = Server::start_with(|o| {
        o.limits.uploads = 2;
        o.limits.uploads_bytes = 100;
    })
    .await;
    let path = server.begin(60, "").await;
    let create = |n: u32| server.tus("POST", "/v1/uploads").header("upload-length", n);
    server.patch(&path, 0, b"abc").send().await.unwrap();
    expect(refusal(create(41)).await, 429, "UPLOADS_FULL");
    let other = server.begin(10, "").await;
    server.patch(&other, 0, b"d").send().await.unwrap();
    expect(refusal(create(1)).await, 429, "UPLOADS_FULL");
    let metrics =
        server.http.get(server.url("/metrics")).send().await.unwrap().text().await.unwrap();
    for line in ["bendtwin_uploads 2", "bendtwin_uploads_bytes 70", "bendtwin_upload_bytes_total 4"]
    {
        assert!(metrics.contains(line), "{line} is not in\n{metrics}");
    }
    // An administrator of the server needs no tus for it.
    assert_eq!(server.delete(&path).await.0, 204);
    server.begin(41, "").await;
}

/// Creations alone hold neither places nor disk space, so they lock nobody out.
#[tokio::test]
async fn empty_uploads_lock_no_client_out_and_soon_expire() {
    let server = Server::start_with(|o| {
        o.limits.uploads = 3;
        o.limits.uploads_bytes = 100;
        // Long enough for the one that is sent to begin.
        o.upload_start_s = 5.0;
    })
    .await;
    for _ in 0..10 {
        server.begin(90, "").await;
    }
    let path = server.begin(9, "").await;
    let sent = server.patch(&path, 0, b"abcdefghi").send().await.unwrap();
    assert!(header(&sent, "bendtwin-capture").is_some());
    let given_up = async {
        loop {
            let (_, list) = server.get("/v1/uploads?page_size=1000").await;
            let uploads = list["uploads"].as_array().unwrap();
            if uploads.iter().all(|u| u["state"] != "RECEIVING") {
                return uploads.iter().filter(|u| u["state"] == "STORED").count();
            }
            tokio::time::sleep(Duration::from_millis(50)).await;
        }
    };
    let stored = tokio::time::timeout(Duration::from_secs(60), given_up).await.unwrap();
    assert_eq!(stored, 1);
}

#[tokio::test]
async fn uploads_are_listed_with_what_has_come() {
    let server = Server::start().await;
    let mut paths = Vec::new();
    for length in [10, 20, 30] {
        paths.push(server.begin(length, "").await);
    }
    server.patch(&paths[1], 0, b"abcde").send().await.unwrap();
    let (mut listed, mut token) = (Vec::new(), String::new());
    loop {
        let page = format!("/v1/uploads?page_size=2&page_token={token}");
        let (status, page) = server.get(&page).await;
        assert_eq!(status, 200, "{page}");
        listed.extend(page["uploads"].as_array().unwrap().clone());
        token = page["next_page_token"].as_str().unwrap().to_owned();
        if token.is_empty() {
            break;
        }
    }
    listed.sort_by_key(|upload| upload["length_bytes"].as_u64());
    let name = |upload: &Value| format!("/v1/{}", upload["name"].as_str().unwrap());
    assert_eq!(listed.iter().map(name).collect::<Vec<_>>(), paths);
    let offsets: Vec<_> = listed.iter().map(|upload| upload["offset_bytes"].as_u64()).collect();
    assert_eq!(offsets, [Some(0), Some(5), Some(0)]);
    assert!(listed.iter().all(|upload| upload["expire_time"].is_string()));
    assert_eq!(server.get("/v1/uploads?page_token=x").await.0, 400);
}

/// A file to which nothing can be appended stands in for a full disk.
#[cfg(target_os = "linux")]
#[tokio::test]
async fn a_full_disk_is_reported_and_destroys_nothing() {
    let server = Server::start().await;
    let path = server.begin(10, "").await;
    let folder = server.dir.path().join("data/blobs/partial");
    std::fs::create_dir_all(&folder).unwrap();
    let file = folder.join(path.rsplit('/').next().unwrap());
    std::os::unix::fs::symlink("/dev/full", &file).unwrap();
    expect(refusal(server.patch(&path, 0, b"abc")).await, 429, "DISK_FULL");
    std::fs::remove_file(&file).unwrap();
    assert_eq!(server.offset(&path).await.unwrap(), "0");
    let sent = server.patch(&path, 0, b"abcdefghij").send().await.unwrap();
    assert!(header(&sent, "bendtwin-capture").is_some());
}
