//! Replies in parts over HTTP, and time limits.

use serde_json::{Value, json};

use super::rollouts;
use crate::{
    harness::{Server, read},
    worker::{Device, Worker},
};

async fn twin(server: &Server, device: Device) -> (Worker, String) {
    let mut worker = Worker::register_with(server, device).await;
    let twin = rollouts::twin(server, &mut worker).await;
    (worker, twin)
}

fn batch(instances: usize) -> Value {
    let positions = vec![json!([[[0, 0, 0]], [[0, 0, 0.1]]]); instances];
    json!({"trajectories": {"positions": positions}, "frames": 10})
}

/// Names and data of the events of a stream.
async fn events(server: &Server, twin: &str, body: Value) -> Vec<(String, Value)> {
    let url = server.url(&format!("/v1/{twin}/rollouts/stream"));
    let response = server.http.post(url).json(&body).send().await.unwrap();
    assert_eq!(response.status(), 200);
    assert_eq!(response.headers()["content-type"], "text/event-stream");
    let text = response.text().await.unwrap();
    let event = |text: &str| {
        let (name, data) = text.split_once('\n').unwrap();
        let name = name.strip_prefix("event: ").unwrap().to_owned();
        (name, serde_json::from_str(data.strip_prefix("data: ").unwrap()).unwrap())
    };
    text.split_terminator("\n\n").map(event).collect()
}

#[tokio::test]
async fn parts_come_as_events() {
    let server = Server::start().await;
    let (_worker, twin) = twin(&server, Device::default()).await;
    let events = events(&server, &twin, batch(40)).await;
    assert!(events.iter().all(|(name, _)| name == "part"));
    let firsts: Vec<_> = events.iter().map(|(_, part)| part["first_instance"].as_u64()).collect();
    assert_eq!(firsts, [Some(0), Some(16), Some(32)]);
    let counts: Vec<_> =
        events.iter().map(|(_, part)| part["costs"].as_array().unwrap().len()).collect();
    assert_eq!(counts, [16, 16, 8]);
}

#[tokio::test]
async fn what_fails_under_way_is_the_last_event() {
    let server = Server::start().await;
    let device = Device { ends_after: Some(2), ..Device::default() };
    let (_worker, twin) = twin(&server, device).await;
    let events = events(&server, &twin, batch(40)).await;
    let names: Vec<&str> = events.iter().map(|(name, _)| name.as_str()).collect();
    assert_eq!(names, ["part", "part", "error"]);
    let problem = &events[2].1;
    assert_eq!((&problem["reason"], &problem["status"]), (&json!("WORKER_LOST"), &json!(503)));
}

#[tokio::test]
async fn what_fails_before_the_first_part_is_an_ordinary_error() {
    let server = Server::start().await;
    let (_worker, twin) = twin(&server, Device::default()).await;
    let url = server.url(&format!("/v1/{twin}/rollouts/stream"));
    let response = server.http.post(url).json(&json!({})).send().await.unwrap();
    let (status, problem) = read(response).await;
    assert_eq!((status, &problem["reason"]), (400, &json!("INVALID_ROLLOUT")), "{problem}");
}

#[tokio::test]
async fn parts_in_time_belong_to_streams() {
    let server = Server::start().await;
    let (_worker, twin) = twin(&server, Device::default()).await;
    let mut body = batch(2);
    body["returns"] = json!({"part_frames": 5});
    let (status, problem) = server.post(&format!("/v1/{twin}/rollouts"), body.clone()).await;
    assert_eq!(status, 400);
    assert!(problem["detail"].as_str().unwrap().contains("StreamRollOut"), "{problem}");
    assert_eq!(events(&server, &twin, body).await.len(), 1);
}

#[tokio::test]
async fn a_worker_learns_what_is_left_of_a_time_limit() {
    let server = Server::start().await;
    let device = Device::default();
    let (_worker, twin) = twin(&server, device.clone()).await;
    let mut body = batch(2);
    server.post(&format!("/v1/{twin}/rollouts"), body.clone()).await;
    body["time_limit_s"] = json!(1000.0);
    server.post(&format!("/v1/{twin}/rollouts"), body).await;
    let limits = device.time_left_s.lock().unwrap().clone();
    assert_eq!(limits[0], 0.0);
    assert!(limits[1] > 900.0 && limits[1] < 1000.0, "{limits:?}");
}
