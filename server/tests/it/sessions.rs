//! The way to sessions, which live at workers and which heartbeats tell of.

use std::time::Duration;

use serde_json::json;

use crate::{harness::Server, worker::Worker};

#[tokio::test]
async fn a_session_is_found_whatever_an_older_heartbeat_says() {
    let server = Server::start().await;
    let mut worker = Worker::register(&server).await;
    let fit = server.fit().await;
    let lease = worker.lease(Duration::from_secs(5)).await.unwrap();
    assert_eq!(lease.job, fit);
    let twin = worker.complete(&lease, b"a twin").await.unwrap();
    let (status, session) = server.post("/v1/sessions", json!({"twin": twin, "slots": 3})).await;
    assert_eq!((status, &session["slots"]), (201, &json!(3)), "{session}");
    // It was on its way when the session was opened, and does not know of it.
    worker.heartbeat().await.unwrap();
    let path = format!("/v1/{}", session["name"].as_str().unwrap());
    let (status, found) = server.get(&path).await;
    assert_eq!((status, &found["name"]), (200, &session["name"]), "{found}");
}

#[tokio::test]
async fn a_session_that_no_worker_has_is_lost() {
    let server = Server::start().await;
    let _worker = Worker::register(&server).await;
    let path = "/v1/sessions/0190a000-0000-7000-8000-00000000dead";
    let (status, problem) = server.get(path).await;
    assert_eq!((status, &problem["reason"]), (409, &json!("SESSION_LOST")));
    assert_eq!(server.delete(path).await.0, 204);
    let (status, problem) = server.get("/v1/sessions/none").await;
    assert_eq!(status, 400, "{problem}");
}
