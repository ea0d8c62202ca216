//! Keys in the log: which one changed what, and never the key itself.

use std::{
    cell::Cell,
    io::Write,
    sync::{Arc, Mutex},
};

use bendtwin_proto::v1::{ListTwinsRequest, twin_service_client::TwinServiceClient};
use serde_json::{Value, json};
use tracing::Level;
use tracing_subscriber::{filter, fmt, prelude::*};

use super::{
    keys::{bearer, locked, make, revoke},
    sign_in::{self, NONCE, VERIFIER, provider::Provider},
};
use crate::harness::read;

thread_local! {
    /// True on the thread of a test that reads the log.
    static IS_LOGGED: Cell<bool> = const { Cell::new(false) };
}

/// A log in memory.
#[derive(Clone, Default)]
struct Log(Arc<Mutex<Vec<u8>>>);

impl Write for Log {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        self.0.lock().unwrap().write(bytes)
    }

    fn flush(&mut self) -> std::io::Result<()> {
        Ok(())
    }
}

impl Log {
    fn text(&self) -> String {
        String::from_utf8(self.0.lock().unwrap().clone()).unwrap()
    }

    /// The lines of the audit.
    fn changes(&self) -> Vec<Value> {
        let lines: Vec<Value> =
            self.text().lines().map(|line| serde_json::from_str(line).unwrap()).collect();
        lines
            .into_iter()
            .filter(|line| line["target"] == "audit")
            .map(|l| l["fields"].clone())
            .collect()
    }
}

#[tokio::test]
async fn changes_are_recorded_and_keys_are_not() {
    let log = Log::default();
    let writer = log.clone();
    // Of all threads, or callsites that another test reaches first would be off; the server runs on
    // the thread of this test.
    let filter = filter::dynamic_filter_fn(|event, _| {
        let is_transport = ["h2", "hyper", "reqwest"].iter().any(|t| event.target().starts_with(t));
        IS_LOGGED.get() && (!is_transport || *event.level() <= Level::DEBUG)
    });
    let layer = fmt::layer().json().with_writer(move || writer.clone()).with_filter(filter);
    tracing_subscriber::registry().with(layer).init();
    IS_LOGGED.set(true);

    let provider = Provider::start().await;
    let server = sign_in::server(&provider, |_| ()).await;
    let scopes = json!(["captures:write", "fits:read"]);
    let order = json!({"display_name": "robot key", "owner": "ada", "scopes": scopes});
    let (name, key) = make(&server, order).await;
    let upload = server.http.post(server.url("/v1/captures")).bearer_auth(&key).body("archive");
    let (status, capture) = read(upload.send().await.unwrap()).await;
    assert_eq!((status, &capture["owner"]), (201, &json!("ada")), "{capture}");
    let capture = capture["name"].as_str().unwrap().to_owned();
    let supplement = format!("{capture}/supplements/masks");
    for method in [reqwest::Method::PUT, reqwest::Method::DELETE] {
        let change = server.http.request(method, server.url(&format!("/v1/{supplement}")));
        // It is being read.
        assert_eq!(change.bearer_auth(&key).body("masks").send().await.unwrap().status(), 409);
    }
    for status in [204, 404] {
        let delete = server.http.delete(server.url(&format!("/v1/{capture}"))).bearer_auth(&key);
        assert_eq!(delete.send().await.unwrap().status(), status);
    }
    // Refused in every possible way, over both transports; repeatedly at one of them, which the
    // audit records once.
    for _ in 0..20 {
        let fit = server.http.post(server.url("/v1/fits")).bearer_auth(&key).json(&json!({}));
        assert_eq!(fit.send().await.unwrap().status(), 403);
    }
    // Another last letter than it has.
    let last = if key.ends_with('0') { '1' } else { '0' };
    let mistyped = format!("{}{last}", &key[..key.len() - 1]);
    for shown in [&key, &mistyped] {
        let fit = server.http.post(server.url("/v1/fits")).bearer_auth(shown);
        assert!(fit.json(&json!({"capture": capture})).send().await.unwrap().status() != 202);
        let in_url = server.url(&format!("/v1/twins?token={shown}"));
        assert_ne!(
            server.http.get(in_url).basic_auth("x", Some(shown)).send().await.unwrap().status(),
            200
        );
        let mut twins = TwinServiceClient::with_interceptor(server.channel.clone(), bearer(shown));
        twins.list_twins(ListTwinsRequest::default()).await.unwrap_err();
    }

    // A revoked key, shown repeatedly.
    assert_eq!(revoke(&server, &name).await, 204);
    for _ in 0..3 {
        let twins = server.http.get(server.url("/v1/twins")).bearer_auth(&key);
        assert_eq!(twins.send().await.unwrap().status(), 401);
    }

    // A sign-in that is refused, one that is not, and its end; what is malformed is not recorded.
    let code = "a-code-of-the-provider";
    let proof = json!({"code": code, "code_verifier": VERIFIER, "nonce": NONCE});
    assert_eq!(server.post("/v1/sign-in", proof.clone()).await.0, 403);
    assert_eq!(server.post("/v1/sign-in", json!({"code": code})).await.0, 400);
    // Repetitions are counted, and the log has the cause.
    assert_eq!(server.post("/v1/sign-in", proof.clone()).await.0, 403);
    for _ in 0..3 {
        provider.with(|answers| answers.token = (401, json!({"error": "invalid_client"})));
        assert_eq!(server.post("/v1/sign-in", proof.clone()).await.0, 409);
    }
    let id_token = provider.key.sign(&provider.claims(NONCE));
    provider.issue(&id_token);
    let (status, made) = server.post("/v1/sign-in", proof).await;
    assert_eq!(status, 201, "{made}");
    let sign_in = made["key"]["name"].as_str().unwrap();
    let sign_in_key = made["secret_key"].as_str().unwrap();
    let end = server.http.delete(server.url("/v1/sign-in")).bearer_auth(sign_in_key);
    assert_eq!(end.send().await.unwrap().status(), 204);
    let page = server.http.get(server.url(&format!("/sign-in?code={code}&state={NONCE}")));
    assert_eq!(page.send().await.unwrap().status(), 200);

    let token = server.handle.client_token().unwrap().to_owned();
    let text = log.text();
    let of_sign_in = [code, VERIFIER, NONCE, &id_token, &sign_in_key[36..68], &sign_in_key[68..]];
    for hidden in of_sign_in {
        assert!(!text.contains(hidden), "a log has a secret of a sign-in: {hidden}");
    }
    let secret = &key[36..];
    assert!(text.contains(&name) && text.contains("bendtwin_server"), "{text}");
    for hidden in [secret, &secret[..32], &secret[32..], &token] {
        assert!(!text.contains(hidden), "a log has a key");
    }
    let failed: Vec<Value> = text
        .lines()
        .map(|line| serde_json::from_str::<Value>(line).unwrap())
        .filter(|line| line["fields"]["message"] == "a sign-in failed")
        .collect();
    assert_eq!(failed.len(), 2, "{failed:?}");
    for (line, cause) in failed.iter().zip(["invalid_grant", "sign_in.client_secret_file"]) {
        assert_eq!(
            (&line["level"], &line["fields"]["client"]),
            (&json!("WARN"), &json!("127.0.0.1"))
        );
        assert!(line["fields"]["error"].as_str().unwrap().contains(cause), "{line}");
    }
    let signed_in = log.changes().into_iter().filter(|line| line["method"] == "CreateSignIn");
    assert!(signed_in.into_iter().all(|line| line["client"] == "127.0.0.1"));
    let strangers = log.changes().into_iter().filter(|line| line["client"].is_string());
    assert!(strangers.into_iter().all(|line| line["client"] == "127.0.0.1"));
    let changes: Vec<_> = log
        .changes()
        .iter()
        .map(|c| {
            let text = |field: &str| c[field].as_str().unwrap().to_owned();
            assert!(!text("request_id").is_empty());
            ["key", "owner", "method", "resource", "result"].map(text)
        })
        .collect();
    let expected = [
        ["", "local", "CreateKey", &name, "OK"],
        [&name, "ada", "CreateCapture", &capture, "OK"],
        [&name, "ada", "AddSupplement", &supplement, "INGEST_UNDER_WAY"],
        [&name, "ada", "DeleteSupplement", &supplement, "INGEST_UNDER_WAY"],
        [&name, "ada", "DeleteCapture", &capture, "OK"],
        [&name, "ada", "DeleteCapture", &capture, "IN_TRASH"],
        [&name, "ada", "POST /v1/fits", "", "SCOPE_MISSING"],
        [&name, "ada", "GET /v1/twins", "", "SCOPE_MISSING"],
        [&name, "ada", "/bendtwin.v1.TwinService/ListTwins", "", "SCOPE_MISSING"],
        ["", "", "", "", "BAD_CLIENT_TOKEN"],
        ["", "local", "DeleteKey", &name, "OK"],
        [&name, "ada", "", "", "KEY_REVOKED"],
        ["", "", "CreateSignIn", "", "SIGN_IN_REFUSED"],
        ["", "", "CreateSignIn", "", "SIGN_IN_CLIENT_REFUSED"],
        ["", "", "CreateSignIn", &format!("{sign_in} of ada@example.org"), "OK"],
        [sign_in, "ada@example.org", "DeleteSignIn", sign_in, "OK"],
    ];
    // Names as the calls gave them: over HTTP the bare id.
    let bare = |name: &str| name.rsplit('/').next().unwrap().to_owned();
    assert_eq!(changes.len(), expected.len(), "{changes:?}");
    for (change, expected) in changes.iter().zip(expected) {
        assert_eq!(change.each_ref().map(|text| bare(text)), expected.map(bare));
    }
    drop(server);
}

/// Owners are recorded over either transport and by resumable uploads, and lists are filtered.
#[tokio::test]
async fn what_is_made_has_the_owner_of_the_key() {
    let server = locked().await;
    let all = json!(["captures:read", "captures:write", "fits:read", "fits:write"]);
    let quotas = json!({"queued_jobs": 3, "stored_bytes": 100});
    let order = json!({"display_name": "ada", "scopes": all, "quotas": quotas});
    let (_, key) = make(&server, order).await;
    let with = |request: reqwest::RequestBuilder| request.bearer_auth(&key).send();
    let post = |path: &str, body: &'static str| server.http.post(server.url(path)).body(body);
    let (status, first) = read(with(post("/v1/captures", "archive")).await.unwrap()).await;
    assert_eq!((status, &first["owner"]), (201, &json!("ada")), "{first}");
    let tus = post("/v1/uploads", "archive two").header("tus-resumable", "1.0.0");
    let tus = tus.header("content-type", "application/offset+octet-stream");
    let tus = with(tus.header("upload-length", "11")).await.unwrap();
    assert_eq!(tus.status(), 201);
    assert!(tus.headers().contains_key("bendtwin-capture"));
    let fit = server.http.post(server.url("/v1/fits")).json(&json!({"capture": first["name"]}));
    let (status, fit) = read(with(fit).await.unwrap()).await;
    assert_eq!((status, &fit["owner"]), (202, &json!("ada")), "{fit}");

    // Two ingests and a fit wait: the owner has what its key allows.
    let fit = server.http.post(server.url("/v1/fits")).json(&json!({"capture": first["name"]}));
    let (status, problem) = read(with(fit).await.unwrap()).await;
    assert_eq!((status, &problem["reason"]), (429, &json!("QUOTA_QUEUED_JOBS")), "{problem}");
    let cancel = format!("/v1/{}/ingest/cancel", first["name"].as_str().unwrap());
    assert_eq!(with(post(&cancel, "")).await.unwrap().status(), 200);
    let large: &'static str = "0123456789".repeat(9).leak();
    let (status, problem) = read(with(post("/v1/captures", large)).await.unwrap()).await;
    assert_eq!((status, &problem["reason"]), (429, &json!("QUOTA_STORED_BYTES")), "{problem}");
    let tus = server.http.post(server.url("/v1/uploads")).header("tus-resumable", "1.0.0");
    let (status, problem) = read(with(tus.header("upload-length", "90")).await.unwrap()).await;
    assert_eq!((status, &problem["reason"]), (429, &json!("QUOTA_STORED_BYTES")), "{problem}");

    let count = async |path: &str| {
        let (status, list) = read(with(server.http.get(server.url(path))).await.unwrap()).await;
        assert_eq!(status, 200, "{list}");
        let lists = list.as_object().unwrap().values();
        lists.filter_map(|items| items.as_array().map(Vec::len)).sum::<usize>()
    };
    assert_eq!(count("/v1/captures?owner=ada").await, 2);
    assert_eq!(count("/v1/captures?owner=bob").await, 0);
    assert_eq!(count("/v1/fits?owner=ada").await, 1);
    assert_eq!(count("/v1/fits?owner=local").await, 0);
}

/// Rollouts of an owner are counted as long as they are under way.
#[tokio::test]
async fn an_owner_has_no_more_rollouts_under_way_than_its_key_allows() {
    let server = locked().await;
    let quotas = json!({"rollouts": 0});
    let order = json!({"display_name": "a", "scopes": ["rollouts:run"], "quotas": quotas});
    let (_, key) = make(&server, order).await;
    let one = json!({"display_name": "b", "scopes": ["rollouts:run"], "quotas": {"rollouts": 1}});
    let (_, one) = make(&server, one).await;
    let id = "0197f2a0-0000-7000-8000-000000000000";
    let session = async |key: &str| {
        let request = server.http.get(server.url(&format!("/v1/sessions/{id}"))).bearer_auth(key);
        let (status, problem) = read(request.send().await.unwrap()).await;
        (status, problem["reason"].as_str().unwrap().to_owned())
    };
    assert_eq!(session(&key).await, (429, "QUOTA_ROLLOUTS".to_owned()));
    // One after another is one at a time.
    for _ in 0..3 {
        assert_ne!(session(&one).await.1, "QUOTA_ROLLOUTS");
    }
}
