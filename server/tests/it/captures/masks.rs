//! Masks that ingests make of strokes.

use std::time::Duration;

use bendtwin_proto::{
    v1::{ExportMasksRequest, Fault},
    worker::v1::lease_job_request::Kind,
};
use serde_json::json;
use tonic::Code;

use crate::{
    harness::Server,
    results::{masks, observation, playback, report},
    worker::{Made, Worker},
};

const SOON: Duration = Duration::from_secs(5);

/// Results of an ingest that was to end with masks.
fn masked(label: &[u8]) -> Made {
    let (playback, masks) = (Some(playback()), Some(masks(label)));
    Made { playback, masks, masks_only: true, ..Made::default() }
}

/// Marked, followed, looked at, and then lifted with the same masks.
#[tokio::test]
async fn an_ingest_that_ends_with_masks_is_a_success_without_points() {
    let server = Server::start().await;
    let capture = server.capture().await;
    let mut worker = Worker::register(&server).await;
    let lease = worker.lease_a(Kind::Ingest, SOON).await.unwrap();
    worker.observe(&lease).await.unwrap();
    let path = format!("/v1/{capture}/masks");
    let (status, problem) = server.get(&path).await;
    assert_eq!((status, &problem["reason"]), (404, &json!("CAPTURE_HAS_NO_MASKS")), "{problem}");

    let stroke = json!({"part": "object", "camera": 0, "points": [[120, 88]]});
    let settings = |until: &str| json!({"settings": {"until": until, "strokes": [stroke]}});
    let ingest = format!("/v1/{capture}/ingest");
    let (_, queued) = server.post(&ingest, settings("masks")).await;
    // What was marked is read back from here.
    assert_eq!(queued["ingest"]["settings"]["strokes"][0]["points"], json!([[120.0, 88.0]]));
    let (_, waiting) = server.post("/v1/fits", json!({"capture": capture})).await;
    let lease = worker.lease_a(Kind::Ingest, SOON).await.unwrap();
    assert_eq!(lease.masks_digest, "");
    for wrong in [
        Made { observation: Some(observation(b"seen")), ..masked(b"one") },
        Made { fault: Some(Fault::default()), ..masked(b"one") },
        Made { masks_only: false, ..masked(b"one") },
    ] {
        let refused = worker.send_made(&lease, wrong, report("usable"), "usable").await;
        assert_eq!(refused.unwrap_err().code(), Code::InvalidArgument);
    }
    for _ in 0..2 {
        // The reply was lost, say.
        worker.send_made(&lease, masked(b"one"), report("usable"), "usable").await.unwrap();
    }
    let (_, read) = server.get(&format!("/v1/{capture}")).await;
    assert_eq!(
        (&read["ingest"]["state"], &read["verdict"], &read["masks"]),
        (&json!("SUCCEEDED"), &json!("usable"), &json!(true))
    );
    assert_eq!(server.get("/v1/captures").await.1["captures"], json!([read]));
    let got = server.http.get(server.url(&path)).send().await.unwrap();
    assert_eq!(got.headers()["content-type"], "application/zip");
    assert!(got.headers()["content-disposition"].to_str().unwrap().contains("-masks.zip"));
    assert_eq!(got.bytes().await.unwrap(), masks(b"one"));
    let request = ExportMasksRequest { name: capture.clone() };
    let mut chunks = server.captures().export_masks(request).await.unwrap().into_inner();
    assert_eq!(chunks.message().await.unwrap().unwrap().chunk, masks(b"one"));
    assert_eq!(server.get(&format!("/v1/{capture}/playback")).await.0, 200);
    assert_eq!(server.get(&format!("/v1/{capture}/observation")).await.0, 404);

    let (_, waiting) = server.get(&format!("/v1/{}", waiting["name"].as_str().unwrap())).await;
    assert_eq!(waiting["job"]["state"], "FAILED");
    assert_eq!(waiting["job"]["fault"]["reason"], "CAPTURE_NOT_LIFTED");
    let (status, problem) = server.post("/v1/fits", json!({"capture": capture})).await;
    assert_eq!((status, &problem["reason"]), (409, &json!("CAPTURE_NOT_LIFTED")), "{problem}");

    server.post(&ingest, settings("points")).await;
    let lease = worker.lease_a(Kind::Ingest, SOON).await.unwrap();
    assert_eq!(lease.masks_digest, blake3::hash(&masks(b"one")).to_hex().as_str());
    assert_eq!(worker.download(&format!("{capture}/masks")).await.unwrap(), masks(b"one"));
    let made =
        Made { observation: Some(observation(b"seen")), masks_only: false, ..masked(b"one") };
    worker.send_made(&lease, made, report("good"), "good").await.unwrap();
    let (_, read) = server.get(&format!("/v1/{capture}")).await;
    assert_eq!((&read["verdict"], &read["masks"]), (&json!("good"), &json!(true)));
    let (status, _) = server.post("/v1/fits", json!({"capture": capture})).await;
    assert_eq!(status, 202);
}

/// The images of a recording that cannot be fitted yet are shown, so that it can be marked.
#[tokio::test]
async fn a_refused_ingest_may_have_a_playback_and_masks() {
    let server = Server::start().await;
    let capture = server.capture().await;
    let mut worker = Worker::register(&server).await;
    let lease = worker.lease_a(Kind::Ingest, SOON).await.unwrap();
    let fault = Fault {
        category: "INVALID_ARGUMENT".into(),
        reason: "NOT_CALIBRATED".into(),
        message: "the cameras have no poses: film a board".into(),
    };
    let made = Made { masks_only: false, fault: Some(fault), ..masked(b"one") };
    worker.send_made(&lease, made, report("unusable"), "unusable").await.unwrap();
    let (_, read) = server.get(&format!("/v1/{capture}")).await;
    assert_eq!((&read["ingest"]["state"], &read["masks"]), (&json!("FAILED"), &json!(true)));
    for (what, status) in [("playback", 200), ("masks", 200), ("observation", 404)] {
        assert_eq!(server.get(&format!("/v1/{capture}/{what}")).await.0, status, "{what}");
    }
    let (status, fit) = server.post("/v1/fits", json!({"capture": capture})).await;
    assert_eq!((status, &fit["job"]["fault"]["reason"]), (202, &json!("NOT_CALIBRATED")));
    assert_eq!(server.purge(&format!("/v1/{capture}")).await.0, 204);
    assert_eq!(server.blob_files(), 0);
}
