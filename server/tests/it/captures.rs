mod ingests;
mod masks;
mod supplements;
mod thumbnails;
mod tus;

use base64::{Engine as _, prelude::BASE64_STANDARD};
use bendtwin_proto::v1::{
    CaptureMetadata, CreateCaptureRequest, DeleteCaptureRequest, GetCaptureRequest,
    ListCapturesRequest, create_capture_request::Part,
};
use bytes::Bytes;
use serde_json::json;
use tokio::io::AsyncWriteExt;

use crate::harness::{Server, read};

#[tokio::test]
async fn http_round_trip() {
    let server = Server::start().await;
    let content = vec![7u8; 3_000_000];
    let digest = blake3::hash(&content);
    let upload = |key: &str, name: &str| {
        let url = server.url(&format!("/v1/captures?display_name={name}"));
        let request = server.http.post(url).header("content-type", "application/zip");
        let request = request.header("idempotency-key", key);
        request.header("x-content-blake3", digest.to_hex().as_str()).body(content.clone()).send()
    };
    let response = upload("key", "a%20rope").await.unwrap();
    let location = response.headers()["location"].to_str().unwrap().to_owned();
    let (status, created) = read(response).await;
    assert_eq!(status, 201);
    assert_eq!(created["display_name"], "a rope");
    assert_eq!(created["digest"], digest.to_hex().as_str());
    assert_eq!(created["size_bytes"], 3_000_000);
    assert!(created["create_time"].as_str().unwrap().parse::<jiff::Timestamp>().is_ok());

    let (_, again) = read(upload("key", "a%20rope").await.unwrap()).await;
    assert_eq!(again, created);
    let (status, other) = read(upload("key", "another").await.unwrap()).await;
    assert_eq!((status, &other["reason"]), (409, &json!("REQUEST_ID_TAKEN")));

    assert_eq!(server.get(&location).await, (200, created.clone()));
    let (_, list) = server.get("/v1/captures?page_size=1").await;
    assert_eq!(list, json!({"captures": [created], "next_page_token": "", "total_size": 1}));
    let got = server.http.get(server.url(&format!("{location}/content"))).send().await.unwrap();
    assert_eq!(got.headers()["content-length"], "3000000");
    let tag = format!("\"{}\"", digest.to_hex());
    assert_eq!(got.headers()["etag"], tag.as_str());
    let declared = format!("blake3=:{}:", BASE64_STANDARD.encode(digest.as_bytes()));
    assert_eq!(got.headers()["content-digest"], declared.as_str());
    assert_eq!(got.headers()["repr-digest"], declared.as_str());
    assert!(got.bytes().await.unwrap() == content);

    assert_eq!(server.purge(&location).await.0, 204);
    let (status, gone) = server.get(&location).await;
    assert_eq!((status, &gone["reason"]), (404, &json!("NOT_FOUND")));
    assert_eq!(server.blob_files(), 0);
}

/// A client gives an upload up whose server stands still, repeats it, and deletes what that made. Then
/// the first attempt comes to its end.
#[tokio::test]
async fn a_deleted_capture_does_not_come_back() {
    let server = Server::start().await;
    let upload = |body: reqwest::Body| {
        let request = server.http.post(server.url("/v1/captures?display_name=rope"));
        let request = request.header("content-type", "application/zip");
        request.header("idempotency-key", "key").body(body).send()
    };
    let (mut sender, body) = futures::channel::mpsc::channel::<std::io::Result<&[u8]>>(1);
    sender.try_send(Ok(b"an ")).unwrap();
    let first = tokio::spawn(upload(reqwest::Body::wrap_stream(body)));
    let (status, made) = read(upload("an archive".into()).await.unwrap()).await;
    assert_eq!(status, 201);
    let path = format!("/v1/{}", made["name"].as_str().unwrap());
    assert_eq!(server.purge(&path).await.0, 204);
    sender.try_send(Ok(b"archive")).unwrap();
    drop(sender);
    for late in [first.await.unwrap().unwrap(), upload("an archive".into()).await.unwrap()] {
        let (status, problem) = read(late).await;
        assert_eq!((status, &problem["reason"]), (409, &json!("DELETED_SINCE")));
    }
    assert_eq!(server.get("/v1/captures").await.1["captures"], json!([]));
    assert_eq!(server.blob_files(), 0);
}

/// The worker recognizes an archive by its content.
#[tokio::test]
async fn archives_of_every_kind_are_taken() {
    let server = Server::start().await;
    for (media_type, expected) in [
        ("application/zip", 201),
        ("application/x-tar", 201),
        ("application/gzip", 201),
        ("application/octet-stream", 201),
        ("text/plain", 415),
    ] {
        let upload = server.http.post(server.url("/v1/captures"));
        let upload = upload.header("content-type", media_type).body(media_type);
        assert_eq!(read(upload.send().await.unwrap()).await.0, expected, "{media_type}");
    }
}

#[tokio::test]
async fn damaged_content_is_never_served_whole() {
    let server = Server::start().await;
    let content = vec![7u8; 3_000_000];
    let upload = server.http.post(server.url("/v1/captures"));
    let upload = upload.header("content-type", "application/zip").body(content.clone());
    let (_, created) = read(upload.send().await.unwrap()).await;
    let digest = created["digest"].as_str().unwrap();
    let file = server.dir.path().join("data/blobs/blake3").join(&digest[..2]).join(digest);
    let path = format!("/v1/{}/content", created["name"].as_str().unwrap());
    for size in [0, content.len() - 1, content.len() + 1] {
        let mut other = content.clone();
        other.resize(size, 7);
        std::fs::write(&file, other).unwrap();
        let (status, problem) = server.get(&path).await;
        assert_eq!((status, &problem["reason"]), (500, &json!("CONTENT_DAMAGED")), "{size}");
    }
    let mut other = content.clone();
    other[1_500_000] = 8;
    std::fs::write(&file, other).unwrap();
    let got = server.http.get(server.url(&path)).send().await.unwrap();
    assert_eq!(got.status(), 200);
    assert!(got.bytes().await.is_err(), "the transfer breaks off");
}

#[tokio::test]
async fn grpc_round_trip() {
    let server = Server::start().await;
    let mut captures = server.captures();
    let metadata = CaptureMetadata { display_name: "rope".into(), ..CaptureMetadata::default() };
    let chunk = |b: &'static [u8]| Part::Chunk(Bytes::from_static(b));
    let parts = [Part::Metadata(metadata), chunk(b"an "), chunk(b"archive")];
    let parts = parts.map(|part| CreateCaptureRequest { part: Some(part) });
    let created = captures.create_capture(futures::stream::iter(parts)).await.unwrap();
    let created = created.into_inner().capture.unwrap();
    assert_eq!(created.digest, blake3::hash(b"an archive").to_hex().as_str());
    let name = created.name.clone();
    let got = captures.get_capture(GetCaptureRequest { name: name.clone() }).await.unwrap();
    assert_eq!(got.into_inner(), created);
    let list = captures.list_captures(ListCapturesRequest::default()).await.unwrap().into_inner();
    assert_eq!((list.captures, list.next_page_token), (vec![created], String::new()));
    captures.delete_capture(DeleteCaptureRequest { name, purge: false }).await.unwrap();
}

#[tokio::test]
async fn uploads_that_break_or_fall_silent_leave_nothing() {
    let server = Server::start_with(|o| {
        o.limits.upload_idle_s = 0.2;
        o.limits.capture_bytes = 1000;
    })
    .await;
    let address = server.handle.local_addr();
    let head = "POST /v1/captures HTTP/1.1\r\nhost: localhost\r\ncontent-type: application/zip\r\n\
                content-length: 500\r\n\r\nsome bytes";
    // Closed in mid-body.
    let mut broken = tokio::net::TcpStream::connect(address).await.unwrap();
    broken.write_all(head.as_bytes()).await.unwrap();
    drop(broken);
    // Silent in mid-body.
    let mut silent = tokio::net::TcpStream::connect(address).await.unwrap();
    silent.write_all(head.as_bytes()).await.unwrap();
    let mut answer = vec![0; 12];
    tokio::io::AsyncReadExt::read_exact(&mut silent, &mut answer).await.unwrap();
    assert_eq!(answer, b"HTTP/1.1 400");
    // Too large; wrong digest; empty.
    let post = |body: Vec<u8>, digest: &'static str| {
        let request = server.http.post(server.url("/v1/captures")).body(body);
        let request = request.header("content-type", "application/zip");
        async move { read(request.header("x-content-blake3", digest).send().await.unwrap()).await }
    };
    let none = "0000000000000000000000000000000000000000000000000000000000000000";
    for (body, digest, reason) in [
        (vec![0; 1001], "", "CONTENT_TOO_LARGE"),
        (vec![0; 10], none, "DIGEST_MISMATCH"),
        (vec![0; 10], "xyz", "INVALID_FIELD"),
        (vec![], "", "INVALID_FIELD"),
    ] {
        let (status, problem) = post(body, digest).await;
        assert_eq!((status, problem["reason"].as_str()), (400, Some(reason)));
    }
    assert_eq!(server.get("/v1/captures").await.1["captures"], json!([]));
    // Removal is asynchronous.
    let emptied = async {
        while server.blob_files() > 0 {
            tokio::time::sleep(std::time::Duration::from_millis(5)).await;
        }
    };
    tokio::time::timeout(std::time::Duration::from_secs(5), emptied).await.unwrap();
}

/// A page whose own name points at loopback has an `Origin` equal to its `Host`, or none at all.
#[tokio::test]
async fn other_names_for_loopback_are_refused() {
    let server = Server::start_with(|_| {}).await;
    let ask = async |host: &str| {
        let request = server.http.get(server.url("/v1/captures")).header("host", host);
        request.send().await.unwrap().status().as_u16()
    };
    assert_eq!(ask("evil.example:7070").await, 403);
    for host in ["localhost:7070", "127.0.0.1", "[::1]:7070"] {
        assert_eq!(ask(host).await, 200, "{host}");
    }
}

#[tokio::test]
async fn an_interrupted_download_continues() {
    let server = Server::start().await;
    let content: Vec<u8> =
        (0..1 << 20).map(|i: u32| i.to_le_bytes()[0] ^ i.to_le_bytes()[1]).collect();
    let upload = server.http.post(server.url("/v1/captures")).body(content.clone());
    let upload = upload.header("content-type", "application/zip");
    let (_, capture) = read(upload.send().await.unwrap()).await;
    let url = server.url(&format!("/v1/{}/content", capture["name"].as_str().unwrap()));
    let get = async |headers: &[(&str, &str)]| {
        let request = server.http.get(&url);
        let request = headers.iter().fold(request, |r, (name, value)| r.header(*name, *value));
        let response = request.send().await.unwrap();
        let (status, headers) = (response.status().as_u16(), response.headers().clone());
        (status, headers, response.bytes().await.unwrap())
    };
    let (status, headers, whole) = get(&[]).await;
    assert_eq!((status, &whole[..]), (200, &content[..]));
    let tag = headers["etag"].to_str().unwrap();
    assert_eq!(tag, format!("\"{}\"", capture["digest"].as_str().unwrap()));
    assert_eq!(headers["accept-ranges"], "bytes");
    assert!(headers["content-digest"].to_str().unwrap().starts_with("blake3=:"));

    let (status, headers, rest) = get(&[("range", "bytes=700000-"), ("if-range", tag)]).await;
    assert_eq!((status, &rest[..]), (206, &content[700_000..]));
    assert_eq!(headers["content-range"], "bytes 700000-1048575/1048576");
    assert_eq!(headers["content-length"], "348576");
    let (status, _, part) = get(&[("range", "bytes=5-9")]).await;
    assert_eq!((status, &part[..]), (206, &content[5..10]));
    let (status, _, other) = get(&[("range", "bytes=5-9"), ("if-range", "\"other\"")]).await;
    assert_eq!((status, other.len()), (200, content.len()));
    let (status, headers, _) = get(&[("range", "bytes=1048576-")]).await;
    assert_eq!(status, 416);
    assert_eq!(headers["content-range"], "bytes */1048576");
}
