//! Malformed requests over HTTP, by a library and by hand.

use reqwest::{Method, RequestBuilder};
use serde_json::json;

use super::{Fixture, bad_names, fields};
use crate::harness::http::Http;

/// The server's default limit on JSON bodies [bytes].
const LARGEST_JSON: usize = 1 << 20;

#[tokio::test]
async fn malformed_requests_are_refused_with_a_problem_document() {
    let fixture = Fixture::new().await;
    let http = fixture.server.http();
    let twin = format!("/v1/{}", fixture.twin.name);
    let mut requests = paths(&http);
    requests.extend(methods(&http, &twin));
    requests.extend(queries(&http));
    requests.extend(fits(&http));
    requests.extend(uploads(&http));
    requests.extend(rollouts(&http, &twin));
    requests.extend(sessions(&http, &fixture.twin.name));
    let (count, mut wrong) = (requests.len(), Vec::new());
    assert!(count >= 200, "only {count} requests");
    for (what, request) in requests {
        let (client, request) = request.build_split();
        let request = request.unwrap();
        let size = request.body().and_then(|body| body.as_bytes()).map_or(0, <[u8]>::len);
        let reply = match client.execute(request).await {
            Ok(reply) => reply,
            // Who sends more than is read may find the connection closed before the answer.
            Err(_) if size > LARGEST_JSON => continue,
            Err(error) => {
                wrong.push(format!("{what}: {error:?}"));
                continue;
            }
        };
        let (status, kind) = (reply.status(), reply.headers().get("content-type").cloned());
        let kind = kind.map(|k| String::from_utf8_lossy(k.as_bytes()).into_owned());
        let body = reply.text().await.unwrap_or_default();
        if !status.is_client_error() {
            wrong.push(format!("{what}: {status} {}", body.chars().take(200).collect::<String>()));
        } else if kind.as_deref() != Some("application/problem+json") {
            wrong.push(format!("{what}: {status} but content type {kind:?}"));
        }
    }
    fixture.still_stands(count, &wrong).await;
}

#[tokio::test]
async fn bytes_that_are_no_http_end_the_connection_and_nothing_else() {
    let fixture = Fixture::new().await;
    let http = fixture.server.http();
    let line = "a".repeat(1 << 20);
    let many = "x: y\r\n".repeat(20_000);
    let requests: Vec<(&str, Vec<u8>)> = vec![
        ("nothing", vec![]),
        ("line ends", b"\r\n\r\n\r\n".to_vec()),
        ("zeros", vec![0; 4096]),
        ("noise", (0..4096u32).map(|i| (i.wrapping_mul(2_654_435_761) >> 24) as u8).collect()),
        ("no version", b"GET /healthz\r\n\r\n".to_vec()),
        ("version 9", b"GET /healthz HTTP/9.9\r\n\r\n".to_vec()),
        ("no method", b" /healthz HTTP/1.1\r\n\r\n".to_vec()),
        ("a method of noise", b"\x01\x02 / HTTP/1.1\r\n\r\n".to_vec()),
        ("TLS", b"\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03".to_vec()),
        ("half a preface", b"PRI * HTTP/2.0\r\n\r\nSM".to_vec()),
        ("HTTP/2 noise", [&b"PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n"[..], &[0xff; 512]].concat()),
        ("a line of a megabyte", format!("GET /{line} HTTP/1.1\r\n\r\n").into_bytes()),
        ("a header of a megabyte", format!("GET / HTTP/1.1\r\nx: {line}\r\n\r\n").into_bytes()),
        ("20,000 headers", format!("GET / HTTP/1.1\r\n{many}\r\n").into_bytes()),
        ("a header without a name", b"GET /healthz HTTP/1.1\r\n: y\r\n\r\n".to_vec()),
        ("a length of no number", b"POST /v1/fits HTTP/1.1\r\nhost: localhost\r\ncontent-length: many\r\n\r\n".to_vec()),
        ("a negative length", b"POST /v1/fits HTTP/1.1\r\nhost: localhost\r\ncontent-length: -5\r\n\r\n".to_vec()),
        ("two lengths", b"POST /v1/fits HTTP/1.1\r\nhost: localhost\r\ncontent-length: 1\r\ncontent-length: 2\r\n\r\nx".to_vec()),
        ("a chunk of 2^64 bytes", b"POST /v1/fits HTTP/1.1\r\nhost: localhost\r\ntransfer-encoding: chunked\r\n\r\nffffffffffffffff\r\n".to_vec()),
        ("a chunk of no number", b"POST /v1/fits HTTP/1.1\r\nhost: localhost\r\ntransfer-encoding: chunked\r\n\r\nzz\r\n".to_vec()),
        ("half a body", b"POST /v1/fits HTTP/1.1\r\nhost: localhost\r\ncontent-type: application/json\r\ncontent-length: 100\r\n\r\n{\"capture\"".to_vec()),
        ("half an upload", b"POST /v1/captures HTTP/1.1\r\nhost: localhost\r\ncontent-type: application/zip\r\ncontent-length: 100000\r\n\r\nPK".to_vec()),
    ];
    let count = requests.len();
    let mut wrong = Vec::new();
    for (what, bytes) in requests {
        if let Some(status) = http.send_raw(&bytes).await
            && !(400..500).contains(&status)
            && status != 505
        {
            wrong.push(format!("{what}: {status}"));
        }
    }
    fixture.still_stands(count, &wrong).await;
}

type Named = (String, RequestBuilder);

/// Bad names in every path that takes one, and paths that do not exist.
fn paths(http: &Http) -> Vec<Named> {
    const ROUTES: [(&str, Method, &str); 9] = [
        ("captures", Method::GET, ""),
        ("captures", Method::DELETE, ""),
        ("captures", Method::GET, "/content"),
        ("fits", Method::GET, ""),
        ("fits", Method::POST, "/cancel"),
        ("fits", Method::GET, "/events"),
        ("twins", Method::GET, ""),
        ("twins", Method::GET, "/content"),
        ("workers", Method::GET, ""),
    ];
    let mut requests = Vec::new();
    for (collection, method, suffix) in ROUTES {
        for name in bad_names(collection) {
            let id = name.strip_prefix(&format!("{collection}/")).unwrap_or(&name);
            let id: String = id.bytes().map(|b| format!("%{b:02x}")).collect();
            if !id.is_empty() {
                let path = format!("/v1/{collection}/{id}{suffix}");
                let shown: String = name.chars().take(60).collect();
                let what = format!("{method} /v1/{collection}/ {shown:?} {suffix}");
                requests.push((what, http.request(method.clone(), &path)));
            }
        }
    }
    for path in
        ["/v1", "/v1/nothing", "/v2/captures", "/v1/captures/a/b/c", "/%ff%fe", "/v1/fits/%ff"]
    {
        requests.push((path.to_owned(), http.request(Method::GET, path)));
    }
    requests
}

fn methods(http: &Http, twin: &str) -> Vec<Named> {
    let wrong = [
        (Method::PUT, "/v1/captures"),
        (Method::PATCH, "/v1/captures"),
        (Method::DELETE, "/v1/captures"),
        (Method::DELETE, "/v1/fits"),
        (Method::PUT, "/v1/fits"),
        (Method::POST, "/v1/workers"),
        (Method::POST, "/healthz"),
        (Method::DELETE, "/metrics"),
        (Method::POST, twin),
    ];
    let mut requests: Vec<_> = wrong
        .into_iter()
        .map(|(method, path)| (format!("{method} {path}"), http.request(method, path)))
        .collect();
    let rollouts = format!("{twin}/rollouts");
    requests.push(("GET rollouts".to_owned(), http.request(Method::GET, &rollouts)));
    requests
}

fn queries(http: &Http) -> Vec<Named> {
    let mut requests = Vec::new();
    for path in ["/v1/captures", "/v1/fits", "/v1/twins"] {
        for query in ["page_size=-1", "page_size=x", "page_size=99999999999", "unknown=1"] {
            let request = http.request(Method::GET, &format!("{path}?{query}"));
            requests.push((format!("{path}?{query}"), request));
        }
        for token in fields::bad_page_tokens() {
            let request = http.request(Method::GET, path).query(&[("page_token", &token)]);
            requests.push((format!("{path}, page token {token:.40}"), request));
        }
    }
    for name in ["x", "twins/0190a000-0000-7000-8000-00000000dead", "../captures"] {
        let request = http.request(Method::GET, "/v1/fits").query(&[("capture", name)]);
        requests.push((format!("fits of {name}"), request));
    }
    requests
}

fn sessions(http: &Http, twin: &str) -> Vec<Named> {
    let post = |path: String, body: String| {
        let request = http.request(Method::POST, &path).header("content-type", "application/json");
        (format!("{path} with {body:.80}"), request.body(body))
    };
    let open = [
        String::new(),
        "[]".to_owned(),
        "{}".to_owned(),
        r#"{"twin": "twins/0190a000-0000-7000-8000-00000000dead"}"#.to_owned(),
        format!(r#"{{"twin": "{twin}", "slots": -1}}"#),
        format!(r#"{{"twin": "{twin}", "slots": 4097}}"#),
        format!(r#"{{"twin": "{twin}", "slots": 1e99}}"#),
        format!(r#"{{"twin": "{twin}", "idle_timeout_s": 0.1}}"#),
        format!(r#"{{"twin": "{twin}", "fidelity": "ROUGH"}}"#),
        format!(r#"{{"twin": "{twin}", "initial": {{"session": {{"session": "x"}}}}}}"#),
        format!(r#"{{"twin": "{twin}", "initial": {{"given": {{"positions": [[1, 2]]}}}}}}"#),
        format!(r#"{{"twin": "{twin}", "grasps": [{}{{}}]}}"#, "{},".repeat(100_000)),
        format!(r#"{{"twin": "{twin}", "world": {{"ground_friction": 1e9}}}}"#),
        format!(r#"{{"twin": "{twin}", "unknown": 1}}"#),
        "[".repeat(100_000),
    ];
    let mut requests: Vec<Named> =
        open.into_iter().map(|body| post("/v1/sessions".to_owned(), body)).collect();
    for name in bad_names("sessions") {
        // Characters that no path has are the library's to refuse.
        let name: String = name.chars().filter(char::is_ascii_graphic).collect();
        let id = name.rsplit('/').next().filter(|id| !id.is_empty()).unwrap_or("x").to_owned();
        for call in ["advance", "correct", "fork", "render", "reset"] {
            requests.push(post(format!("/v1/sessions/{id}/{call}"), "{}".to_owned()));
        }
        for call in ["", "/states", "/states?slots=1,x", "/states?slots=4294967296"] {
            let path = format!("/v1/sessions/{id}{call}");
            requests.push((path.clone(), http.request(Method::GET, &path)));
        }
    }
    requests
}

fn fits(http: &Http) -> Vec<Named> {
    let capture = "captures/0190a000-0000-7000-8000-00000000dead";
    let post = |body: String| {
        http.request(Method::POST, "/v1/fits").header("content-type", "application/json").body(body)
    };
    let mut requests = Vec::new();
    let bodies = [
        String::new(),
        "{".to_owned(),
        "null".to_owned(),
        "[]".to_owned(),
        "{}".to_owned(),
        r#"{"capture": 7}"#.to_owned(),
        r#"{"capture": ""}"#.to_owned(),
        format!(r#"{{"capture": "{capture}"}}"#),
        format!(r#"{{"capture": "{capture}", "unknown": 1}}"#),
        format!(r#"{{"capture": "{capture}", "priority": 1e9}}"#),
        format!(r#"{{"capture": "{capture}", "priority": 101}}"#),
        format!(r#"{{"capture": "{capture}", "priority": "high"}}"#),
        "[".repeat(100_000),
        format!("{{\"capture\": \"{}\"}}", "x".repeat(2 << 20)),
    ];
    for body in bodies {
        requests.push((format!("fit of {body:.80}"), post(body)));
    }
    for settings in fields::bad_settings() {
        let what = format!("settings {settings:.80}");
        requests
            .push((what, post(format!(r#"{{"capture": "{capture}", "settings": {settings}}}"#))));
    }
    let valid = json!({"capture": capture}).to_string();
    let typed = http.request(Method::POST, "/v1/fits").header("content-type", "text/html");
    requests.push(("HTML".to_owned(), typed.body(valid.clone())));
    requests.push((
        "a long key".to_owned(),
        post(valid.clone()).header("idempotency-key", fields::too_long().split_at(5000).0),
    ));
    requests.push(("an empty key".to_owned(), post(valid).header("idempotency-key", "")));
    let bytes = post(String::new()).body(b"{\"capture\": \"\xff\xfe\"}".to_vec());
    requests.push(("bad UTF-8".to_owned(), bytes));
    requests
}

fn uploads(http: &Http) -> Vec<Named> {
    let post = |path: &str| http.request(Method::POST, path).body("PK");
    let zip = |path: &str| post(path).header("content-type", "application/zip");
    let mut requests = vec![
        ("an empty capture".to_owned(), http.request(Method::POST, "/v1/captures")),
        (
            "a capture as JSON".to_owned(),
            post("/v1/captures").header("content-type", "application/json"),
        ),
        ("an unknown parameter".to_owned(), zip("/v1/captures?name=x")),
        (
            "a digest of something else".to_owned(),
            zip("/v1/captures").header("x-content-blake3", "0".repeat(64)),
        ),
        (
            "a digest of no base64".to_owned(),
            zip("/v1/captures").header("content-digest", "blake3=:!:"),
        ),
        ("a twin of two bytes".to_owned(), post("/v1/twins")),
        ("an empty twin".to_owned(), http.request(Method::POST, "/v1/twins")),
    ];
    let name = format!("/v1/captures?display_name={}", "n".repeat(5000));
    requests.push(("a long name".to_owned(), zip(&name)));
    for digest in fields::bad_digests() {
        let request = zip("/v1/captures").header("x-content-blake3", &digest);
        requests.push((format!("digest {digest}"), request));
    }
    requests
}

fn rollouts(http: &Http, twin: &str) -> Vec<Named> {
    let path = format!("{twin}/rollouts");
    let post = |body: String| {
        http.request(Method::POST, &path).header("content-type", "application/json").body(body)
    };
    let positions =
        |positions: &str| format!(r#"{{"trajectories": {{"positions": {positions}}}}}"#);
    let packed = |dtype: &str, shape: &str, data: &str| {
        positions(&format!(r#"{{"dtype": "{dtype}", "shape": {shape}, "data": "{data}"}}"#))
    };
    let bodies = [
        String::new(),
        "{".to_owned(),
        "[]".to_owned(),
        "{}".to_owned(),
        r#"{"unknown": 1}"#.to_owned(),
        positions("null"),
        positions("7"),
        positions("[]"),
        positions("[[]]"),
        positions("[[[[0, 0, 0]]], [[[0, 0]]]]"),
        positions("[[[[0, 0, \"x\"]]]]"),
        positions("[[[[0, 0, 1e400]]]]"),
        positions("[[[[0, 0, null]], [[0, 0, 0]]]]"),
        positions("[[[[[[[[[[0]]]]]]]]]]"),
        positions(&"[".repeat(5000)),
        packed("FLOAT32", "[1, 2, 1, 3]", "AAAA"),
        packed("FLOAT32", "[1000000000000, 2, 1, 3]", ""),
        packed("FLOAT32", "[18446744073709551615, 18446744073709551615]", ""),
        packed("FLOAT32", "[-1]", ""),
        packed("FLOAT99", "[0]", ""),
        packed("FLOAT32", "[1]", "no base64!"),
    ];
    let mut requests: Vec<_> =
        bodies.into_iter().map(|body| (format!("rollout {body:.80}"), post(body))).collect();
    for query in ["tensors=xml", "timeout_s=-1", "timeout_s=NaN", "timeout_s=1e300", "unknown=1"] {
        let request = http.request(Method::POST, &format!("{path}?{query}")).body("{}");
        requests.push((format!("rollout?{query}"), request));
    }
    let protobuf = http
        .request(Method::POST, &path)
        .header("content-type", "application/x-protobuf")
        .body(vec![0xff; 100]);
    requests.push(("rollout of noise".to_owned(), protobuf));
    requests
}
