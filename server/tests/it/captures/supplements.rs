//! Files that are added to captures after their upload.

use std::time::Duration;

use base64::{Engine as _, prelude::BASE64_STANDARD};
use bendtwin_proto::{
    v1::{
        AddSupplementRequest, DeleteSupplementRequest, ExportSupplementRequest, GetCaptureRequest,
        SupplementMetadata, add_supplement_request::Part,
    },
    worker::v1::lease_job_request::Kind,
};
use bytes::Bytes;
use serde_json::{Value, json};
use tonic::Code;

use crate::{
    access::keys::{locked, make},
    harness::{Server, read},
    worker::Worker,
};

const SOON: Duration = Duration::from_secs(5);
const CALIBRATION: &str = r#"{"format":"bendtwin-calibration","version":1,"cameras":[]}"#;

/// A capture whose ingest has been cancelled.
async fn idle(server: &Server) -> String {
    let capture = server.capture().await;
    server.post(&format!("/v1/{capture}/ingest/cancel"), json!(null)).await;
    capture
}

async fn put(server: &Server, path: &str, body: &'static str) -> (u16, Value) {
    read(server.http.put(server.url(path)).body(body).send().await.unwrap()).await
}

#[tokio::test]
async fn a_file_is_added_replaced_downloaded_and_removed() {
    let server = Server::start().await;
    let capture = idle(&server).await;
    let path = format!("/v1/{capture}/supplements/masks");
    let digest = blake3::hash(b"masks");
    let (status, added) = put(&server, &path, "masks").await;
    assert_eq!((status, &added["name"]), (200, &json!(capture)), "{added}");
    let supplement = &added["supplements"][0];
    assert_eq!((&supplement["kind"], &supplement["size_bytes"]), (&json!("masks"), &json!(5)));
    assert_eq!(supplement["digest"], digest.to_hex().as_str());
    assert!(supplement["create_time"].as_str().unwrap().parse::<jiff::Timestamp>().is_ok());
    assert_eq!(added["masks"], false, "they are not those of an ingest");
    assert_eq!(put(&server, &path, "masks").await, (200, added.clone()), "sent again");
    assert_eq!(server.get("/v1/captures").await.1["captures"], json!([added]));

    let got = server.http.get(server.url(&path)).header("range", "bytes=1-2").send().await.unwrap();
    let tag = format!("\"{}\"", digest.to_hex());
    assert_eq!((got.status().as_u16(), got.headers()["etag"].to_str().unwrap()), (206, &*tag));
    assert_eq!(got.bytes().await.unwrap(), "as");
    let (_, replaced) = put(&server, &path, "better masks").await;
    assert_eq!(replaced["supplements"][0]["size_bytes"], 12);
    let (status, _) = put(&server, &path.replace("masks", "calibration"), CALIBRATION).await;
    assert_eq!(status, 200);
    let poses = server.http.get(server.url(&path.replace("masks", "calibration")));
    let poses = poses.send().await.unwrap();
    assert_eq!(poses.headers()["content-type"], "application/json");
    assert_eq!(poses.text().await.unwrap(), CALIBRATION);
    // The archive, the masks and the calibration.
    assert_eq!(server.blob_files(), 3);

    assert_eq!(server.delete(&path).await.0, 204);
    let (status, problem) = server.delete(&path).await;
    assert_eq!((status, &problem["reason"]), (404, &json!("NOT_FOUND")));
    assert_eq!(server.get(&path).await.0, 404);
    assert_eq!(server.purge(&format!("/v1/{capture}")).await.0, 204);
    assert_eq!(server.blob_files(), 0);
    assert_eq!(put(&server, &path, "masks").await.0, 404);
}

#[tokio::test]
async fn what_cannot_be_a_supplement_is_refused_and_leaves_nothing() {
    let server = Server::start_with(|o| {
        o.limits.capture_bytes = 1000;
        o.limits.json_bytes = 1024;
    })
    .await;
    let capture = idle(&server).await;
    let send = async |kind: &str, body: Vec<u8>, headers: &[(&str, &str)]| {
        let request = server.http.put(server.url(&format!("/v1/{capture}/supplements/{kind}")));
        let request = headers.iter().fold(request, |r, (name, value)| r.header(*name, *value));
        let (status, problem) = read(request.body(body).send().await.unwrap()).await;
        (status, problem["reason"].as_str().unwrap_or_default().to_owned(), problem)
    };
    let none = "0".repeat(64);
    let encoded = format!("blake3=:{}:", BASE64_STANDARD.encode([0; 32]));
    let kalibr = b"cam0: {intrinsics: [600, 600, 320, 240]}".to_vec();
    let newer = br#"{"format":"bendtwin-calibration","version":0}"#.to_vec();
    for (kind, body, headers, status, reason) in [
        ("mesh", b"mesh".to_vec(), &[][..], 400, "INVALID_FIELD"),
        ("masks", Vec::new(), &[], 400, "INVALID_FIELD"),
        ("masks", vec![0; 1001], &[], 400, "CONTENT_TOO_LARGE"),
        ("masks", b"m".to_vec(), &[("x-content-blake3", none.as_str())], 400, "DIGEST_MISMATCH"),
        ("masks", b"m".to_vec(), &[("content-digest", encoded.as_str())], 400, "DIGEST_MISMATCH"),
        ("masks?digest=x", b"m".to_vec(), &[], 400, "INVALID_FIELD"),
        ("masks?color=red", b"m".to_vec(), &[], 400, "INVALID_FIELD"),
        ("masks", b"m".to_vec(), &[("content-type", "text/html")], 415, "UNSUPPORTED_MEDIA_TYPE"),
        ("calibration", vec![b' '; 1025], &[], 400, "CONTENT_TOO_LARGE"),
        ("calibration", kalibr, &[], 400, "INVALID_FIELD"),
        ("calibration", newer, &[], 400, "INVALID_FIELD"),
    ] {
        let (found, said, problem) = send(kind, body, headers).await;
        assert_eq!((found, said.as_str()), (status, reason), "{kind}: {problem}");
    }
    let (.., problem) = send("calibration", b"{}".to_vec(), &[]).await;
    assert!(problem["detail"].as_str().unwrap().contains("capture calibrate"), "{problem}");
    let good = blake3::hash(b"m").to_hex();
    assert_eq!(send(&format!("masks?digest={good}"), b"m".to_vec(), &[]).await.0, 200);
    // Removal of what was received is asynchronous.
    let emptied = async {
        while server.blob_files() > 2 {
            tokio::time::sleep(Duration::from_millis(5)).await;
        }
    };
    tokio::time::timeout(SOON, emptied).await.unwrap();
}

#[tokio::test]
async fn a_silent_or_broken_transfer_adds_nothing() {
    use tokio::io::{AsyncReadExt as _, AsyncWriteExt as _};
    let server = Server::start_with(|o| o.limits.upload_idle_s = 0.2).await;
    let capture = idle(&server).await;
    let address = server.handle.local_addr();
    let head = format!(
        "PUT /v1/{capture}/supplements/masks HTTP/1.1\r\nhost: localhost\r\n\
         content-length: 500\r\n\r\nsome bytes"
    );
    let mut broken = tokio::net::TcpStream::connect(address).await.unwrap();
    broken.write_all(head.as_bytes()).await.unwrap();
    drop(broken);
    let mut silent = tokio::net::TcpStream::connect(address).await.unwrap();
    silent.write_all(head.as_bytes()).await.unwrap();
    let mut answer = vec![0; 12];
    silent.read_exact(&mut answer).await.unwrap();
    assert_eq!(answer, b"HTTP/1.1 400");
    assert_eq!(server.get(&format!("/v1/{capture}")).await.1["supplements"], json!([]));
}

/// Refused while a job reads the capture; the next ingest gets the file.
#[tokio::test]
async fn the_next_ingest_reads_it_and_no_running_job_sees_a_change() {
    let server = Server::start().await;
    let capture = server.capture().await;
    let path = format!("/v1/{capture}/supplements/calibration");
    let mut worker = Worker::register(&server).await;
    let first = worker.lease_a(Kind::Ingest, SOON).await.unwrap();
    assert!(first.supplements.is_empty() && first.masks_digest.is_empty());
    let (status, problem) = put(&server, &path, CALIBRATION).await;
    assert_eq!((status, &problem["reason"]), (409, &json!("INGEST_UNDER_WAY")), "{problem}");
    worker.observe(&first).await.unwrap();
    assert_eq!(put(&server, &path, CALIBRATION).await.0, 200);
    // Another worker may not look at it, and this one only while it has the job.
    let input = format!("{capture}/supplements/calibration");
    assert_eq!(worker.download(&input).await.unwrap_err().code(), Code::PermissionDenied);

    let (status, _) = server.post(&format!("/v1/{capture}/ingest"), json!({})).await;
    assert_eq!(status, 202);
    let lease = worker.lease_a(Kind::Ingest, SOON).await.unwrap();
    let [supplement] = &lease.supplements[..] else { panic!("{:?}", lease.supplements) };
    assert_eq!(supplement.kind, "calibration");
    assert_eq!(supplement.digest, blake3::hash(CALIBRATION.as_bytes()).to_hex().as_str());
    assert_eq!(worker.download(&input).await.unwrap(), CALIBRATION.as_bytes());
    for other in [format!("{capture}/supplements/masks"), format!("{capture}/masks")] {
        assert_eq!(worker.download(&other).await.unwrap_err().code(), Code::NotFound, "{other}");
    }
    let unknown = worker.download(&format!("{capture}/supplements/mesh")).await.unwrap_err();
    assert_eq!(unknown.code(), Code::InvalidArgument);
    let mut other = Worker::register(&server).await;
    assert_eq!(other.download(&input).await.unwrap_err().code(), Code::PermissionDenied);
    worker.observe(&lease).await.unwrap();

    let (_, fit) = server.post("/v1/fits", json!({"capture": capture})).await;
    let (status, problem) = server.delete(&path).await;
    assert_eq!((status, &problem["reason"]), (409, &json!("CAPTURE_IN_USE")), "{problem}");
    // A fit reads the observation alone.
    let lease = worker.lease(SOON).await.unwrap();
    assert_eq!((json!(lease.job), lease.supplements.len()), (fit["name"].clone(), 0));
}

#[tokio::test]
async fn the_same_over_grpc() {
    let server = Server::start().await;
    let capture = idle(&server).await;
    let mut captures = server.captures();
    let add = |kind: &str, digest: &str| {
        let (name, kind, digest) = (capture.clone(), kind.to_owned(), digest.to_owned());
        let metadata = Part::Metadata(SupplementMetadata { name, kind, digest });
        let chunk = |b: &'static [u8]| Part::Chunk(Bytes::from_static(b));
        let parts = [metadata, chunk(b"ma"), chunk(b"sks")];
        futures::stream::iter(parts.map(|part| AddSupplementRequest { part: Some(part) }))
    };
    for (kind, digest) in [("mesh", ""), ("", ""), ("masks", "x"), ("calibration", "")] {
        let refused = captures.add_supplement(add(kind, digest)).await.unwrap_err();
        assert_eq!(refused.code(), Code::InvalidArgument, "{kind}");
    }
    let digest = blake3::hash(b"masks").to_hex();
    let added = captures.add_supplement(add("masks", &digest)).await.unwrap().into_inner();
    let added = added.capture.unwrap();
    assert_eq!((added.supplements[0].kind.as_str(), added.masks), ("masks", false));
    let name = capture.clone();
    let got = captures.get_capture(GetCaptureRequest { name }).await.unwrap().into_inner();
    assert_eq!(got, added);
    let of = |kind: &str| (capture.clone(), kind.to_owned());
    let (name, kind) = of("masks");
    let export = ExportSupplementRequest { name, kind };
    let mut chunks = captures.export_supplement(export.clone()).await.unwrap().into_inner();
    assert_eq!(chunks.message().await.unwrap().unwrap().chunk, "masks");
    let (name, kind) = of("masks");
    let delete = DeleteSupplementRequest { name, kind };
    captures.delete_supplement(delete.clone()).await.unwrap();
    assert_eq!(captures.delete_supplement(delete).await.unwrap_err().code(), Code::NotFound);
    assert_eq!(captures.export_supplement(export).await.unwrap_err().code(), Code::NotFound);
}

#[tokio::test]
async fn a_supplement_counts_in_the_quota_of_its_key_and_needs_its_scope() {
    let server = locked().await;
    let scopes = json!(["captures:read", "captures:write"]);
    let quotas = json!({"stored_bytes": 20});
    let order = json!({"display_name": "ada", "scopes": scopes, "quotas": quotas});
    let (_, key) = make(&server, order).await;
    let reads = json!({"display_name": "eve", "scopes": ["captures:read"]});
    let (_, reader) = make(&server, reads).await;
    let upload = server.http.post(server.url("/v1/captures")).bearer_auth(&key).body("an archive");
    let (_, capture) = read(upload.send().await.unwrap()).await;
    let capture = capture["name"].as_str().unwrap().to_owned();
    let cancel = server.http.post(server.url(&format!("/v1/{capture}/ingest/cancel")));
    assert_eq!(cancel.bearer_auth(&key).send().await.unwrap().status(), 200);
    let put = async |key: &str, body: &'static str| {
        let request = server.http.put(server.url(&format!("/v1/{capture}/supplements/masks")));
        let (status, answer) =
            read(request.bearer_auth(key).body(body).send().await.unwrap()).await;
        (status, answer["reason"].as_str().unwrap_or_default().to_owned())
    };
    assert_eq!(put(&reader, "masks").await, (403, "SCOPE_MISSING".to_owned()));
    assert_eq!(put(&key, "masks").await.0, 200);
    // A replacement counts beside what it replaces until it is stored.
    assert_eq!(put(&key, "0123456789").await, (429, "QUOTA_STORED_BYTES".to_owned()));
    let there = server.url(&format!("/v1/{capture}/supplements/masks"));
    let deleted = server.http.delete(there).bearer_auth(&key).send().await.unwrap();
    assert_eq!(deleted.status(), 204);
    assert_eq!(put(&key, "0123456789x").await, (429, "QUOTA_STORED_BYTES".to_owned()));
    assert_eq!(put(&key, "0123456789").await.0, 200);
    let get = server.http.get(server.url(&format!("/v1/{capture}/supplements/masks")));
    let got = get.bearer_auth(&reader).send().await.unwrap();
    assert_eq!(got.text().await.unwrap(), "0123456789");
}
