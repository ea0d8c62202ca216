//! Tests against a small scripted server.

use std::{
    collections::VecDeque,
    sync::{Arc, Mutex},
};

use bendtwin_tls::Connector;
use tokio::{
    io::{AsyncReadExt as _, AsyncWriteExt as _},
    net::TcpListener,
};

use super::*;

const NAME: &str = "captures/0190a000-0000-7000-8000-000000000001";

/// An expected request, by method and offset, and the response to it. An empty response closes the
/// connection.
type Exchange = (&'static str, Option<u64>, String);

fn answer(status: &str, headers: &str) -> String {
    format!(
        "HTTP/1.1 {status}\r\ntus-resumable: 1.0.0\r\nconnection: close\r\ncontent-length: 0\r\n{headers}\r\n"
    )
}

/// Serves the exchanges in order, one connection each; returns the address.
async fn serve_script(exchanges: Vec<Exchange>) -> (String, Arc<Mutex<VecDeque<Exchange>>>) {
    let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
    let url = format!("http://{}", listener.local_addr().unwrap());
    let exchanges = Arc::new(Mutex::new(VecDeque::from(exchanges)));
    let left = exchanges.clone();
    tokio::spawn(async move {
        loop {
            let (mut stream, _) = listener.accept().await.unwrap();
            let Some((method, offset, answer)) = exchanges.lock().unwrap().pop_front() else {
                return;
            };
            let mut request = Vec::new();
            while !request.windows(4).any(|w| w == b"\r\n\r\n") {
                assert!(stream.read_buf(&mut request).await.unwrap() > 0);
            }
            let text = String::from_utf8_lossy(&request).to_lowercase();
            assert!(text.starts_with(&method.to_lowercase()), "{method}: {text}");
            let field = |name: &str| {
                let value = text.split(&format!("\r\n{name}: ")).nth(1)?.split("\r\n").next()?;
                Some(value.to_owned())
            };
            assert_eq!(field("tus-resumable").unwrap(), "1.0.0");
            assert_eq!(field("upload-offset").map(|o| o.parse().unwrap()), offset, "{text}");
            let body: usize = field("content-length").map_or(0, |n| n.parse().unwrap());
            let mut there = request.len() - text.find("\r\n\r\n").unwrap() - 4;
            while there < body {
                there += stream.read_buf(&mut request).await.unwrap();
            }
            stream.write_all(answer.as_bytes()).await.unwrap();
            stream.shutdown().await.ok();
        }
    });
    (url, left)
}

async fn push(exchanges: Vec<Exchange>) -> Result<CaptureId, Error> {
    let file = tempfile::NamedTempFile::new().unwrap();
    std::fs::write(file.path(), b"0123456789").unwrap();
    let (url, left) = serve_script(exchanges).await;
    let http = Http::new(Connector::new(Duration::from_secs(10)), None).unwrap();
    let sender = Sender::new(&http, &url, file.path(), "digest", &"rope".into()).await.unwrap();
    let pushed = sender.send(&|_| ()).await;
    assert!(left.lock().unwrap().is_empty(), "the client gave up early: {pushed:?}");
    pushed
}

fn created() -> Exchange {
    ("POST", None, answer("201 Created", "location: /v1/uploads/a\r\nupload-offset: 0\r\n"))
}

fn done() -> String {
    answer("204 No Content", &format!("upload-offset: 10\r\nbendtwin-capture: {NAME}\r\n"))
}

fn at(offset: u64) -> Exchange {
    ("HEAD", None, answer("200 OK", &format!("upload-offset: {offset}\r\n")))
}

#[tokio::test]
async fn resumes_at_the_server_offset_after_every_kind_of_failure() {
    let name = push(vec![
        ("POST", None, String::new()),
        created(),
        ("PATCH", Some(0), String::new()),
        ("HEAD", None, answer("503 Service Unavailable", "")),
        at(4),
        ("PATCH", Some(4), answer("409 Conflict", "")),
        at(7),
        ("PATCH", Some(7), answer("423 Locked", "")),
        ("HEAD", None, answer("423 Locked", "")),
        at(7),
        ("PATCH", Some(7), answer("429 Too Many Requests", "")),
        at(7),
        ("PATCH", Some(7), done()),
    ]);
    assert_eq!(name.await.unwrap().to_string(), NAME);
}

#[tokio::test]
async fn starts_over_where_the_upload_is_gone() {
    let name = push(vec![
        created(),
        ("PATCH", Some(0), String::new()),
        ("HEAD", None, answer("410 Gone", "")),
        created(),
        ("PATCH", Some(0), done()),
    ]);
    assert_eq!(name.await.unwrap().to_string(), NAME);
}

/// A proxy may pass `/bendtwin/v1` on as `/v1`, so that the server names another path or host than
/// its clients see.
#[test]
fn an_upload_lies_below_the_address_of_the_server() {
    for location in [
        "/v1/uploads/a",
        "/bendtwin/v1/uploads/a",
        "http://10.0.0.1:8080/v1/uploads/a",
        "https://lab/bendtwin/v1/uploads/a?x=1",
    ] {
        let found = address("https://lab/bendtwin", location).unwrap();
        assert_eq!(found, "https://lab/bendtwin/v1/uploads/a", "{location}");
    }
    for location in ["", "/v1/uploads/", "/v1/uploads/a/b", "/v1/captures/a"] {
        assert_eq!(address("http://lab", location).unwrap_err().reason(), "MALFORMED_REPLY");
    }
}

#[tokio::test]
async fn an_upload_that_is_never_found_is_not_begun_without_end() {
    let lost = || [created(), ("PATCH", Some(0), answer("404 Not Found", ""))];
    let exchanges = (0..=MOST_GONE).flat_map(|_| lost()).collect();
    assert_eq!(push(exchanges).await.unwrap_err().reason(), "UPLOAD_LOST");
}

#[tokio::test]
async fn does_not_send_stored_content() {
    let known =
        format!("location: /v1/uploads/a\r\nupload-offset: 10\r\nbendtwin-capture: {NAME}\r\n");
    push(vec![("POST", None, answer("201 Created", &known))]).await.unwrap();
    // Whole, and the capture is made when asked for.
    let whole = "location: /v1/uploads/a\r\nupload-offset: 10\r\n";
    let made = answer("200 OK", &format!("upload-offset: 10\r\nbendtwin-capture: {NAME}\r\n"));
    push(vec![("POST", None, answer("201 Created", whole)), ("HEAD", None, made)]).await.unwrap();
}

#[tokio::test]
async fn permanent_failures_are_not_retried() {
    let refused = push(vec![created(), ("PATCH", Some(0), answer("400 Bad Request", ""))]).await;
    assert_eq!(refused.unwrap_err().category(), Category::InvalidArgument);
    let malformed = push(vec![("POST", None, answer("201 Created", ""))]).await;
    assert_eq!(malformed.unwrap_err().reason(), "MALFORMED_REPLY");
}

#[tokio::test]
async fn a_request_id_tells_which_fact_a_text_is() {
    let file = tempfile::NamedTempFile::new().unwrap();
    let http = Http::new(Connector::new(Duration::from_secs(10)), None).unwrap();
    let id = async |facts: CaptureFacts| {
        let sender = Sender::new(&http, "", file.path(), "digest", &facts).await.unwrap();
        let mut pairs = sender.metadata.split(',').map(|pair| pair.split_once(' ').unwrap());
        let (_, id) = pairs.find(|(name, _)| *name == "request_id").unwrap();
        String::from_utf8(BASE64_STANDARD.decode(id).unwrap()).unwrap()
    };
    let recorded_by = Some("rope".to_owned());
    let recorded = CaptureFacts { recorded_by: recorded_by.clone(), ..CaptureFacts::default() };
    let both = CaptureFacts { recorded_by, ..CaptureFacts::from("rope") };
    let named = id("rope".into()).await;
    assert_ne!(named, id(recorded).await);
    assert_ne!(named, id(both).await);
    // As clients of before made it.
    assert_eq!(named, format!("tus-{}", &blake3::hash(b"digestrope").to_hex()[..32]));
}
