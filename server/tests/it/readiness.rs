//! `/readyz` shows whether a request that comes now can be served, and why not.

use std::time::Duration;

use serde_json::{Value, json};

use crate::{harness::Server, worker::Worker};

/// Status, and each check by its name.
async fn ready(server: &Server) -> (u16, Value) {
    let (status, ready) = server.get("/readyz").await;
    assert_eq!(ready["ready"], json!(status == 200), "{ready}");
    let checks = ready["checks"].as_array().unwrap();
    let named = |check: &Value| (check["name"].as_str().unwrap().to_owned(), check.clone());
    (status, checks.iter().map(named).collect())
}

#[tokio::test]
async fn a_server_without_a_worker_that_answers_is_not_ready() {
    let server = Server::start_with(|o| {
        o.heartbeat_interval_s = 0.5;
        o.lease_s = 60.0;
    })
    .await;
    let (status, checks) = ready(&server).await;
    assert_eq!((status, &checks["workers"]["ok"]), (503, &json!(false)), "{checks}");
    assert!(checks["workers"]["message"].as_str().unwrap().contains("bendtwin worker"));
    for fine in ["running", "writes", "disk"] {
        assert_eq!(checks[fine]["ok"], true, "{checks}");
    }
    let (status, rest) = server.get("/readyz?without=workers").await;
    assert_eq!((status, rest["ready"].as_bool()), (200, Some(true)), "{rest}");
    assert!(rest["checks"].as_array().unwrap().iter().all(|check| check["name"] != "workers"));
    assert_eq!(server.get("/readyz?without=workers,disk").await.0, 200);
    for query in ["without=worker", "wihtout=workers"] {
        let (status, problem) = server.get(&format!("/readyz?{query}")).await;
        assert_eq!((status, &problem["reason"]), (400, &json!("INVALID_FIELD")), "{problem}");
    }
    let mut worker = Worker::register(&server).await;
    assert_eq!(ready(&server).await.0, 200);
    let silent = async {
        while ready(&server).await.0 == 200 {
            tokio::time::sleep(Duration::from_millis(20)).await;
        }
    };
    tokio::time::timeout(Duration::from_secs(60), silent).await.unwrap();
    worker.heartbeat().await.unwrap();
    assert_eq!(ready(&server).await.0, 200);
    let text = server.http.get(server.url("/metrics")).send().await.unwrap().text().await.unwrap();
    for line in [
        r#"bendtwin_ready{check="writes"} 1"#,
        r#"bendtwin_ready{check="workers"}"#,
        r#"bendtwin_disk_bytes{state="free"}"#,
        r#"bendtwin_disk_bytes{state="total"}"#,
    ] {
        assert!(text.contains(line), "{line} is not in\n{text}");
    }
}

/// Below the floor new content is refused, while stored content can be read and deleted.
#[tokio::test]
async fn new_content_is_refused_before_the_disk_is_full() {
    let server = Server::start().await;
    let (capture, fitted) = (server.capture().await, server.capture().await);
    let Server { dir, handle, .. } = server;
    handle.shutdown().await;

    let server = Server::start_in(dir, |o| o.disk_floor_mib = 1 << 30).await;
    let _worker = Worker::register(&server).await;
    let (status, checks) = ready(&server).await;
    assert_eq!((status, &checks["disk"]["ok"]), (503, &json!(false)), "{checks}");
    let upload = |path: &str| server.http.post(server.url(path)).body("some content");
    let tus = server.http.post(server.url("/v1/uploads")).header("tus-resumable", "1.0.0");
    let requests = [
        upload("/v1/captures").header("content-type", "application/zip"),
        upload("/v1/twins").header("content-type", "application/octet-stream"),
        tus.header("upload-length", 12),
        server.http.post(server.url("/v1/fits")).json(&json!({"capture": fitted})),
    ];
    for request in requests {
        let (status, problem) = crate::harness::read(request.send().await.unwrap()).await;
        assert_eq!((status, &problem["reason"]), (429, &json!("DISK_FULL")), "{problem}");
    }
    assert_eq!(server.get(&format!("/v1/{fitted}")).await.0, 200);
    server.post(&format!("/v1/{capture}/ingest/cancel"), json!(null)).await;
    assert_eq!(server.delete(&format!("/v1/{capture}")).await.0, 204);
}
