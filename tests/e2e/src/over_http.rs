//! The HTTP form of the API as a script uses it, and the endpoints for operators.

use std::time::Duration;

use bytes::Bytes;
use futures::StreamExt as _;
use reqwest::{Method, StatusCode};
use serde_json::{Value, json};
use tonic::Code;

use crate::harness::{
    Setup, TestCluster,
    http::Http,
    raw,
    reference::{FIT, SETTINGS, capture, reference},
    until, within,
};

/// A server-sent event: its id and its data.
type Event = (u64, Value);

#[tokio::test]
async fn a_capture_becomes_a_twin_over_http_and_events_resume_where_they_stopped() {
    let server = TestCluster::ordinary().await;
    let http = server.http();
    let upload = || {
        http.request(Method::POST, "/v1/captures?display_name=e2e")
            .header("content-type", "application/zip")
            .header("idempotency-key", "rope-1")
    };
    let archive = capture().await;
    let stored = upload().body(archive.clone()).send().await.unwrap();
    assert_eq!(stored.status(), StatusCode::CREATED);
    let location = stored.headers()["location"].to_str().unwrap().to_owned();
    let stored: Value = stored.json().await.unwrap();
    let again: Value = upload().body(archive.clone()).send().await.unwrap().json().await.unwrap();
    // A worker may be reading it by now.
    assert_eq!((&stored["name"], &stored["digest"]), (&again["name"], &again["digest"]));
    assert_eq!(http.get_json(&location).await["name"], stored["name"]);
    let content = http.get(&format!("{location}/content")).await.bytes().await.unwrap();
    assert_eq!(content, archive);

    let settings: Value = serde_json::from_str(SETTINGS).unwrap();
    let order = json!({"capture": stored["name"], "settings": settings, "priority": 1});
    let accepted = http.request(Method::POST, "/v1/fits").json(&order).send().await.unwrap();
    assert_eq!(accepted.status(), StatusCode::ACCEPTED);
    let fit = accepted.headers()["location"].to_str().unwrap().to_owned();

    // Leaves after a few events, reconnects and misses nothing.
    let events = format!("{fit}/events");
    let first = watch(&http, &events, None, 3).await;
    let seen = first.last().unwrap().0;
    let rest = watch(&http, &events, Some(seen), usize::MAX).await;
    assert!(rest.iter().all(|(id, _)| *id > seen), "events were repeated");
    assert!(rest.is_sorted_by(|a, b| a.0 < b.0));
    let ended = &rest.last().unwrap().1;
    assert_eq!(ended["job"]["state"], "SUCCEEDED", "{ended}");
    assert_eq!(ended["job"]["revision"], rest.last().unwrap().0);

    let twin = http.get_json(&format!("/v1/{}", ended["twin"].as_str().unwrap())).await;
    assert_eq!(twin["digest"], reference().await.digest, "HTTP and gRPC make the same twin");
    assert!(twin["quality"]["scores"].as_array().is_some_and(|s| s.len() >= 2), "{twin}");
}

#[tokio::test]
async fn a_rollout_over_http_is_the_one_over_grpc() {
    let server = TestCluster::ordinary().await;
    let (http, api) = (server.http(), server.api());
    let file = reference().await.file;
    let twin = api.import(&file).await.unwrap();
    let request = crate::rollouts::request(&twin, &crate::rollouts::rest_controls(&file));
    let expected = api.roll_out(request.clone()).await.unwrap();
    let expected = expected.costs.unwrap().unpack::<f64>("costs").unwrap().1;

    let bendtwin_proto::v1::roll_out_request::Actions::Trajectories(actions) =
        request.actions.unwrap()
    else {
        unreachable!()
    };
    let (shape, positions) = actions.positions.unwrap().unpack_points("positions").unwrap();
    let rows: Vec<_> = positions.chunks(shape[2]).collect();
    let batch: Vec<_> = rows.chunks(shape[1]).collect();
    let body = json!({
        "trajectories": {"positions": batch},
        "costs": [{"weight": 1.0, "keypoints": {"nodes": [0], "targets": [[0.0, 0.0, 0.0]]}}],
    });
    let path = format!("/v1/{}/rollouts", twin.name);
    let reply = http.request(Method::POST, &path).json(&body).send().await.unwrap();
    let status = reply.status();
    let reply: Value = reply.json().await.unwrap();
    assert_eq!(status, StatusCode::OK, "{reply}");
    let costs: Vec<f64> = serde_json::from_value(reply["costs"].clone()).unwrap();
    assert_eq!(costs, expected);
}

#[tokio::test]
async fn operators_find_health_metrics_and_a_description() {
    let server = TestCluster::start(Setup { own_workers: 1, ..Setup::default() }).await;
    let http = server.http();
    assert_eq!(http.get("/healthz").await.status(), StatusCode::OK);
    assert_eq!(http.get_json("/readyz").await["ready"], true);
    let metrics = http.get("/metrics").await.text().await.unwrap();
    assert!(metrics.lines().any(|line| line.starts_with("# TYPE")), "{metrics}");
    let description = http.get_json("/openapi.json").await;
    for path in ["/v1/captures", "/v1/fits/{id}/events", "/v1/twins/{id}/rollouts"] {
        assert!(description["paths"][path].is_object(), "{path} is not described");
    }
    assert_eq!(http.get("/docs").await.status(), StatusCode::OK);

    // Any gRPC tool finds out by itself what there is.
    let channel = server.api().channel;
    let health = raw::call(&channel, "/grpc.health.v1.Health/Check", vec![Bytes::new()]).await;
    assert_eq!(health, Code::Ok);
    let list_services = Bytes::from_static(&[7 << 3 | 2, 0]);
    let path = "/grpc.reflection.v1.ServerReflection/ServerReflectionInfo";
    assert_eq!(raw::call(&channel, path, vec![list_services]).await, Code::Ok);

    let refused = http.get("/v1/twins/0190a000-0000-7000-8000-00000000dead").await;
    assert_eq!(refused.status(), StatusCode::NOT_FOUND);
    let id = refused.headers()["x-request-id"].to_str().unwrap().to_owned();
    let problem: Value = refused.json().await.unwrap();
    assert_eq!(problem["status"], 404);
    assert_eq!(problem["request_id"], id.as_str());
    assert!(problem["reason"].as_str().is_some_and(|r| r.contains("NOT_FOUND")), "{problem}");
    until("a worker in the list", Duration::from_secs(30), async || {
        http.get_json("/v1/workers").await["workers"].as_array().filter(|w| !w.is_empty()).map(drop)
    })
    .await;
}

/// Server-sent events until there are `most`, or until the server ends them.
async fn watch(http: &Http, path: &str, after: Option<u64>, most: usize) -> Vec<Event> {
    let mut request = http.request(Method::GET, path).timeout(FIT);
    if let Some(id) = after {
        request = request.header("last-event-id", id);
    }
    let reply = request.send().await.unwrap();
    assert_eq!(reply.headers()["content-type"], "text/event-stream");
    let mut chunks = reply.bytes_stream();
    let (mut text, mut events) = (String::new(), Vec::new());
    within("server-sent events", FIT, async {
        while events.len() < most
            && let Some(chunk) = chunks.next().await
        {
            text.push_str(std::str::from_utf8(&chunk.unwrap()).unwrap());
            while let Some((event, rest)) = text.split_once("\n\n") {
                events.extend(parse(event));
                text = rest.to_owned();
            }
        }
    })
    .await;
    events.truncate(most);
    events
}

/// Comments, which keep the connection alive, are no events.
fn parse(event: &str) -> Option<Event> {
    let field = |name: &str| event.lines().find_map(|line| line.strip_prefix(name)).map(str::trim);
    let data = serde_json::from_str(field("data:")?).unwrap();
    Some((field("id:")?.parse().unwrap(), data))
}
