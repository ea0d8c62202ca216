//! Pictures of captures: images and points out of their playbacks.

use std::time::Duration;

use bendtwin_proto::worker::v1::lease_job_request::Kind;
use serde_json::{Value, json};

use crate::{
    harness::Server,
    results::{observation, report},
    worker::{Made, Worker},
};

/// A playback of two points, the second unknown, with these cameras; `data` follows the points.
fn playback(cameras: &Value, data: &[u8]) -> Vec<u8> {
    let motion = json!({
        "point_count": 2, "origin": [0, 0, 0], "scale_m": 0.001, "points": [0, 12], "colors": null
    });
    let mut head = json!({"sequences": [{"motion": motion, "cameras": cameras}]}).to_string();
    head.extend(std::iter::repeat_n(' ', head.len().next_multiple_of(8) - head.len()));
    let points = [100i16, 20, 3, i16::MIN, i16::MIN, i16::MIN];
    let mut bytes = b"BENDPLAY".to_vec();
    bytes.extend(1u32.to_le_bytes());
    bytes.extend((head.len() as u32).to_le_bytes());
    bytes.extend(head.as_bytes());
    bytes.extend(points.iter().flat_map(|n| n.to_le_bytes()));
    bytes.extend(data);
    bytes
}

/// Path of a capture whose ingest made this playback.
async fn ingested(server: &Server, playback: Vec<u8>) -> String {
    let capture = server.capture().await;
    let mut worker = Worker::register(server).await;
    let lease = worker.lease_a(Kind::Ingest, Duration::ZERO).await.unwrap();
    let observation = Some(observation(&playback));
    let made = Made { observation, playback: Some(playback), ..Made::default() };
    worker.send_made(&lease, made, report("good"), "good").await.unwrap();
    format!("/v1/{capture}/thumbnail")
}

#[tokio::test]
async fn a_capture_shows_its_first_image_or_its_points() {
    let server = Server::start().await;
    let image = b"\xff\xd8 an image";
    let cameras = json!([{"images": {"lengths": [0, image.len()], "bytes": [12, image.len()]}}]);
    let path = ingested(&server, playback(&cameras, image)).await;
    for _ in 0..2 {
        let shown = server.http.get(server.url(&path)).send().await.unwrap();
        assert_eq!(shown.headers()["content-type"], "image/jpeg");
        assert_eq!(&shown.bytes().await.unwrap()[..], image);
    }

    let server = Server::start().await;
    let path = ingested(&server, playback(&json!([]), b"")).await;
    let shown = server.http.get(server.url(&format!("{path}?width=32"))).send().await.unwrap();
    assert_eq!(shown.headers()["content-type"], "image/png");
    assert_eq!(&shown.bytes().await.unwrap()[..8], b"\x89PNG\r\n\x1a\n");
}

#[tokio::test]
async fn a_playback_that_points_beyond_its_end_is_no_picture() {
    for cameras in [
        json!([{"images": {"lengths": [1], "bytes": [1_000_000, 1]}}]),
        json!([{"images": {"lengths": [u64::MAX], "bytes": [u64::MAX, 1]}}]),
    ] {
        let server = Server::start().await;
        let path = ingested(&server, playback(&cameras, b"")).await;
        assert_eq!(server.get(&path).await.0, 500);
        assert_eq!(server.get("/v1/captures").await.0, 200);
    }
}

#[tokio::test]
async fn a_capture_without_a_playback_has_no_picture() {
    let server = Server::start().await;
    let capture = server.capture().await;
    let (status, problem) = server.get(&format!("/v1/{capture}/thumbnail")).await;
    assert_eq!((status, &problem["reason"]), (404, &json!("PLAYBACK_MISSING")));
}
