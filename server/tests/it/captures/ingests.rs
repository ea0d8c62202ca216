use std::time::Duration;

use base64::{Engine as _, prelude::BASE64_STANDARD};
use bendtwin_proto::{
    v1::{
        ExportObservationRequest, Fault, GetCaptureReportRequest, IngestCaptureRequest,
        WatchIngestRequest, get_capture_report_request::Format, job::State,
    },
    worker::v1::{FailJobRequest, fail_job_request::End, lease_job_request::Kind},
};
use serde_json::json;

use crate::{
    harness::{Server, read},
    results::{observation, playback},
    worker::Worker,
};

const SOON: Duration = Duration::from_secs(5);

fn fault() -> Fault {
    Fault {
        category: "INVALID_ARGUMENT".into(),
        reason: "NO_CONTROLS".into(),
        message: "the capture has no control points: say who moves it".into(),
    }
}

/// The whole protocol: leased, reported, checkpointed, handed back, ended; seen from both sides.
#[tokio::test]
async fn a_capture_is_read_before_it_is_fitted() {
    let server = Server::start().await;
    let fit = server.fit().await;
    let capture = server.get(&format!("/v1/{fit}")).await.1["capture"].as_str().unwrap().to_owned();
    let (_, fresh) = server.get(&format!("/v1/{capture}")).await;
    assert_eq!((&fresh["ingest"]["state"], &fresh["verdict"]), (&json!("QUEUED"), &json!(null)));
    for what in ["report", "report.html", "observation", "playback"] {
        assert_eq!(server.get(&format!("/v1/{capture}/{what}")).await.0, 404, "{what}");
    }
    let (_, problem) = server.get(&format!("/v1/{capture}/playback")).await;
    assert_eq!(problem["reason"], "PLAYBACK_MISSING", "{problem}");
    let mut worker = Worker::register(&server).await;
    assert!(worker.lease_a(Kind::Fit, Duration::ZERO).await.is_none());
    let lease = worker.lease_a(Kind::Ingest, SOON).await.unwrap();
    assert!(lease.job.starts_with("ingests/") && !lease.has_checkpoint);
    assert_eq!(lease.observation_digest, "");
    assert_eq!(worker.download(&lease.capture).await.unwrap(), b"an archive");
    worker.report(&lease, 0.5).await.unwrap();
    worker.checkpoint(&lease, b"half way").await.unwrap();
    let (_, running) = server.get(&format!("/v1/{capture}")).await;
    assert_eq!(running["ingest"]["state"], "RUNNING");
    assert_eq!(running["ingest"]["progress"]["fraction"], 0.5);
    let (_, list) = server.get("/v1/workers").await;
    assert_eq!(list["workers"][0]["ingest"], json!(capture));
    let release = FailJobRequest { end: End::Released.into(), ..worker.failure(&lease) };
    worker.link.fail_job(release).await.unwrap();

    let lease = worker.lease_a(Kind::Ingest, SOON).await.unwrap();
    assert_eq!((lease.epoch, lease.has_checkpoint), (2, true));
    assert_eq!(worker.download(&lease.job).await.unwrap(), b"half way");
    worker.observe(&lease).await.unwrap();
    // The reply was lost, say.
    worker.observe(&lease).await.unwrap();
    let (_, read) = server.get(&format!("/v1/{capture}")).await;
    assert_eq!((&read["ingest"]["state"], &read["verdict"]), (&json!("SUCCEEDED"), &json!("good")));
    let (_, list) = server.get("/v1/captures").await;
    assert_eq!(list["captures"], json!([read]));

    let (status, report) = server.get(&format!("/v1/{capture}/report")).await;
    assert_eq!((status, &report["verdict"]), (200, &json!("good")));
    let url = server.url(&format!("/v1/{capture}/report.html"));
    let page = server.http.get(url).send().await.unwrap();
    let policy = page.headers()["content-security-policy"].to_str().unwrap().to_owned();
    assert!(policy.contains("default-src 'none'") && policy.contains("sandbox"), "{policy}");
    assert!(!policy.contains("script-src") && !policy.contains("allow-scripts"), "{policy}");
    assert_eq!(page.headers()["x-content-type-options"], "nosniff");
    assert_eq!(page.text().await.unwrap(), "<p>");
    let url = server.url(&format!("/v1/{capture}/observation"));
    let content = server.http.get(url).send().await.unwrap().bytes().await.unwrap();
    assert!(content == observation(b"seen"));
    let url = server.url(&format!("/v1/{capture}/playback"));
    let part = server.http.get(url).header("range", "bytes=5-11").send().await.unwrap();
    assert_eq!(part.status(), 206);
    let tag = part.headers()["etag"].to_str().unwrap().to_owned();
    assert_eq!(tag, format!("\"{}\"", blake3::hash(&playback()).to_hex()));
    assert_eq!(part.bytes().await.unwrap(), playback()[5..12]);

    // The fit that waited for it.
    let lease = worker.lease_a(Kind::Fit, SOON).await.unwrap();
    assert_eq!(lease.job, fit);
    assert_eq!(lease.observation_digest, blake3::hash(&observation(b"seen")).to_hex().as_str());
    let name = format!("{}/observation", lease.capture);
    assert_eq!(worker.download(&name).await.unwrap(), observation(b"seen"));
}

#[tokio::test]
async fn what_cannot_be_read_fails_its_fits_and_says_why() {
    let server = Server::start().await;
    let fit = server.fit().await;
    let capture = server.get(&format!("/v1/{fit}")).await.1["capture"].as_str().unwrap().to_owned();
    let mut worker = Worker::register(&server).await;
    let lease = worker.lease_a(Kind::Ingest, SOON).await.unwrap();
    for (observation, verdict, fault) in [
        (None, "unusable", None),
        (Some(b"seen".as_slice()), "unusable", Some(fault())),
        (None, "Not a word", Some(fault())),
    ] {
        let refused = worker.end_ingest(&lease, observation, verdict, fault).await.unwrap_err();
        assert_eq!(refused.code(), tonic::Code::InvalidArgument);
    }
    worker.end_ingest(&lease, None, "unusable", Some(fault())).await.unwrap();
    let (_, read) = server.get(&format!("/v1/{capture}")).await;
    assert_eq!(
        (&read["ingest"]["state"], &read["verdict"]),
        (&json!("FAILED"), &json!("unusable"))
    );
    assert_eq!(read["ingest"]["fault"]["reason"], "NO_CONTROLS");
    assert_eq!(server.get(&format!("/v1/{capture}/report")).await.0, 200);
    assert_eq!(server.get(&format!("/v1/{capture}/observation")).await.0, 404);
    let (_, later) = server.post("/v1/fits", json!({"capture": capture})).await;
    for fit in [fit.as_str(), later["name"].as_str().unwrap()] {
        let (_, fit) = server.get(&format!("/v1/{fit}")).await;
        assert_eq!(
            (&fit["job"]["state"], &fit["job"]["fault"]),
            (&json!("FAILED"), &read["ingest"]["fault"])
        );
    }
    assert!(worker.lease_a(Kind::Fit, Duration::ZERO).await.is_none());
    assert_eq!(server.purge(&format!("/v1/{capture}")).await.0, 204);
    assert_eq!(server.blob_files(), 0);
}

#[tokio::test]
async fn an_ingest_is_run_again_with_other_settings() {
    let server = Server::start().await;
    let url = server.url("/v1/captures?ingest=%7B%22completion%22");
    let refused = server.http.post(url).body("an archive").send().await.unwrap();
    let (status, problem) = crate::harness::read(refused).await;
    assert_eq!((status, &problem["reason"]), (400, &json!("INVALID_SETTINGS")));

    let capture = server.capture().await;
    let path = format!("/v1/{capture}/ingest");
    let (status, problem) = server.post(&path, json!({})).await;
    assert_eq!((status, &problem["reason"]), (409, &json!("INGEST_UNDER_WAY")));
    let (_, cancelled) = server.post(&format!("{path}/cancel"), json!(null)).await;
    assert_eq!(cancelled["ingest"]["state"], "CANCELLED");
    let (status, queued) = server.post(&path, json!({"settings": {}})).await;
    assert_eq!((status, &queued["ingest"]["state"]), (202, &json!("QUEUED")));
    assert!(queued["ingest"]["revision"].as_u64() > cancelled["ingest"]["revision"].as_u64());

    let mut worker = Worker::register(&server).await;
    let lease = worker.lease_a(Kind::Ingest, SOON).await.unwrap();
    server.post(&format!("{path}/cancel"), json!(null)).await;
    assert!(worker.report(&lease, 0.1).await.unwrap());
    let end = FailJobRequest { end: End::Cancelled.into(), ..worker.failure(&lease) };
    worker.link.fail_job(end).await.unwrap();
    let (status, _) = server.post("/v1/fits", json!({"capture": capture})).await;
    assert_eq!(status, 202);
    let request = IngestCaptureRequest { name: capture.clone(), ..Default::default() };
    let again = server.captures().ingest_capture(request.clone()).await.unwrap().into_inner();
    assert_eq!(again.ingest.unwrap().state(), State::Queued);
    let fit = server.post("/v1/fits", json!({"capture": capture})).await.1;
    assert_eq!(fit["job"]["state"], "QUEUED");
    worker.lease(SOON).await.unwrap();
    let refused = server.captures().ingest_capture(request).await.unwrap_err();
    assert_eq!(bendtwin_proto::fault::fault(&refused).reason, "CAPTURE_IN_USE");
}

/// Requirements are given with every kind of upload, and when a capture is read again.
#[tokio::test]
async fn an_ingest_waits_for_a_worker_that_it_asks_for() {
    let server = Server::start().await;
    let wanted = json!({"backend": "cpu", "memory_bytes": 0, "labels": ["disk=big"]});
    let text = wanted.to_string();
    let upload = async |requirements: &str| {
        let request = server.http.post(server.url("/v1/captures")).body("an archive");
        read(request.query(&[("ingest_requirements", requirements)]).send().await.unwrap()).await
    };
    for wrong in ["{", r#"{"colour": "red"}"#, r#"{"backend": "tpu"}"#] {
        let (status, problem) = upload(wrong).await;
        assert_eq!(status, 400, "{problem}");
        assert!(problem["detail"].as_str().unwrap().contains("requirements"), "{problem}");
    }
    let (status, first) = upload(&text).await;
    assert_eq!((status, &first["ingest_requirements"]), (201, &wanted), "{first}");
    let pair = |key: &str, value: &str| format!("{key} {}", BASE64_STANDARD.encode(value));
    let tus = server.http.post(server.url("/v1/uploads")).header("tus-resumable", "1.0.0");
    let tus = tus.header("upload-metadata", pair("ingest_requirements", &text));
    let tus = tus.header("content-type", "application/offset+octet-stream");
    let tus = tus.header("upload-length", "10").body("an archive").send().await.unwrap();
    let second = tus.headers()["bendtwin-capture"].to_str().unwrap().to_owned();
    let (_, second) = server.get(&format!("/v1/{second}")).await;
    assert_eq!(second["ingest_requirements"], wanted);

    let mut plain = Worker::register(&server).await;
    plain.heartbeat().await.unwrap();
    assert!(plain.lease_a(Kind::Ingest, Duration::ZERO).await.is_none());
    let mut labelled = Worker::register_labelled(&server, &["disk=big"]).await;
    labelled.heartbeat().await.unwrap();
    for capture in [&first, &second] {
        let lease = labelled.lease_a(Kind::Ingest, SOON).await.unwrap();
        assert_eq!(json!(lease.capture), capture["name"]);
        labelled.observe(&lease).await.unwrap();
    }
    // Read again: without requirements any worker will do.
    let name = first["name"].as_str().unwrap().to_owned();
    let (_, again) =
        server.post(&format!("/v1/{name}/ingest"), json!({"requirements": wanted})).await;
    assert_eq!(again["ingest_requirements"], wanted, "{again}");
    assert!(plain.lease_a(Kind::Ingest, Duration::ZERO).await.is_none());
    server.post(&format!("/v1/{name}/ingest/cancel"), json!(null)).await;
    let request = IngestCaptureRequest { name, ..Default::default() };
    let again = server.captures().ingest_capture(request).await.unwrap().into_inner();
    assert_eq!(again.ingest_requirements, None);
    plain.lease_a(Kind::Ingest, SOON).await.unwrap();
}

#[tokio::test]
async fn reading_can_be_watched() {
    let server = Server::start().await;
    let capture = server.capture().await;
    let mut worker = Worker::register(&server).await;
    let watch = WatchIngestRequest { name: capture.clone(), after_revision: 0 };
    let mut watched = server.captures().watch_ingest(watch).await.unwrap().into_inner();
    let work = async {
        let lease = worker.lease_a(Kind::Ingest, SOON).await.unwrap();
        worker.report(&lease, 0.5).await.unwrap();
        worker.observe(&lease).await.unwrap();
    };
    let url = server.url(&format!("/v1/{capture}/events"));
    let events = async { server.http.get(url).send().await.unwrap().text().await.unwrap() };
    let (events, ()) = tokio::join!(events, work);
    let last = events.trim().rsplit("\n\n").next().unwrap();
    assert!(last.contains("event: capture") && last.contains("\"SUCCEEDED\""), "{last}");
    assert!(last.contains("\"verdict\":\"good\""), "{last}");
    let mut states = Vec::new();
    while let Some(capture) = watched.message().await.unwrap() {
        states.push(capture.ingest.unwrap().state());
    }
    assert_eq!((states.first(), states.last()), (Some(&State::Queued), Some(&State::Succeeded)));

    for (format, expected) in [(Format::Unspecified, "{"), (Format::Html, "<p>")] {
        let request = GetCaptureReportRequest { name: capture.clone(), format: format.into() };
        let mut chunks = server.captures().get_capture_report(request).await.unwrap().into_inner();
        let chunk = chunks.message().await.unwrap().unwrap().chunk;
        assert!(chunk.starts_with(expected.as_bytes()));
    }
    let request = ExportObservationRequest { name: capture };
    let mut chunks = server.captures().export_observation(request).await.unwrap().into_inner();
    assert_eq!(chunks.message().await.unwrap().unwrap().chunk, observation(b"seen"));
}
