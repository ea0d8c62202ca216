use std::time::Duration;

use bendtwin_proto::v1::{
    CreateFitRequest, FitPreview, GetFitPreviewRequest, GetFitRequest, ListFitsRequest, Tensor,
    WatchFitRequest, job::State,
};
use bendtwin_proto::worker::v1::lease_job_request::Kind;
use futures::StreamExt;
use serde_json::{Value, json};
use tonic::Code;

use crate::{
    harness::{Server, read},
    results::observation,
    worker::Worker,
};

#[tokio::test]
async fn a_fit_is_accepted_with_its_settings_in_force() {
    let server = Server::start().await;
    let capture = server.capture().await;
    let body = json!({"capture": capture, "settings": {"seed": 7}, "priority": 3});
    let request = server.http.post(server.url("/v1/fits")).json(&body);
    let trace = "00-0af7651916cd43dd8448eb211c80319c-b7ad6b7169203331-01";
    let request = request.header("idempotency-key", "key").header("traceparent", trace);
    let response = request.try_clone().unwrap().send().await.unwrap();
    let location = response.headers()["location"].to_str().unwrap().to_owned();
    let (status, fit) = read(response).await;
    assert_eq!(status, 202);
    assert_eq!((&fit["job"]["state"], &fit["priority"]), (&json!("QUEUED"), &json!(3)));
    assert_eq!(
        (&fit["job"]["settings"]["seed"], &fit["job"]["settings"]["bending"]),
        (&json!(7), &json!(true))
    );
    assert_eq!(read(request.send().await.unwrap()).await.1, fit);
    assert_eq!(server.get(&location).await, (200, fit.clone()));
    let (_, list) = server.get(&format!("/v1/fits?capture={capture}")).await;
    assert_eq!(list["fits"], json!([fit]));

    let mut worker = Worker::register(&server).await;
    let lease = worker.lease(Duration::ZERO).await.unwrap();
    assert_eq!((lease.trace_parent.as_str(), lease.request_id.as_str()), (trace, "key"));
    assert_eq!(lease.capture_display_name, "rope");
    let refused = server.delete(&location).await;
    assert_eq!((refused.0, &refused.1["reason"]), (409, &json!("FIT_RUNNING")));
    let (status, fit) = server.post(&format!("{location}/cancel"), Value::Null).await;
    assert_eq!((status, &fit["job"]["cancel_requested"]), (200, &json!(true)));
}

#[tokio::test]
async fn a_fit_waits_for_a_worker_with_its_labels_and_memory() {
    let server = Server::start().await;
    let capture = server.capture().await;
    let post = async |requirements: Value| {
        let body = json!({"capture": capture, "requirements": requirements});
        server.post("/v1/fits", body).await
    };
    for (wrong, field) in [
        (json!({"backend": "tpu"}), "requirements.backend"),
        (json!({"labels": ["two words"]}), "requirements.labels"),
        (json!({"labels": vec!["x"; 33]}), "requirements.labels"),
    ] {
        let (status, problem) = post(wrong).await;
        assert_eq!(status, 400);
        assert!(problem["detail"].as_str().unwrap().contains(field), "{problem}");
    }
    // The memory that workers of these tests have for fits is 4 GiB.
    let wanted = json!({"backend": "cpu", "memory_bytes": 1_u64 << 32, "labels": ["big"]});
    let (status, fit) = post(wanted.clone()).await;
    assert_eq!((status, &fit["requirements"]), (202, &wanted));
    let more = json!({"backend": "", "memory_bytes": (1_u64 << 32) + 1, "labels": ["big"]});
    assert_eq!(post(more).await.0, 202);

    let mut plain = Worker::register(&server).await;
    plain.heartbeat().await.unwrap();
    assert!(plain.lease(Duration::ZERO).await.is_none());
    let mut labelled = Worker::register_labelled(&server, &["big", "lab=2"]).await;
    labelled.heartbeat().await.unwrap();
    let lease = labelled.lease(Duration::ZERO).await.unwrap();
    assert_eq!(json!(lease.job), fit["name"]);
    assert!(labelled.lease(Duration::ZERO).await.is_none());
    let (_, listed) = server.get("/v1/workers").await;
    assert_eq!(listed["workers"][0]["labels"], json!(["big", "lab=2"]));
}

#[tokio::test]
async fn unsound_settings_are_refused_with_all_faults() {
    let server = Server::start().await;
    let capture = server.capture().await;
    let mut fits = server.fits();
    let settings_json = r#"{"search": {"sigma": 0}, "refine": {"learning_rate": 2}}"#.to_owned();
    let request = CreateFitRequest { capture, settings_json, ..CreateFitRequest::default() };
    let status = fits.create_fit(request.clone()).await.unwrap_err();
    assert_eq!(bendtwin_proto::fault::fault(&status).reason, "INVALID_SETTINGS");
    let message = status.message();
    assert!(message.contains("sigma") && message.contains("learning_rate"), "{message}");
    let request = CreateFitRequest { settings_json: String::new(), ..request };
    let fit = fits.create_fit(request).await.unwrap().into_inner();
    assert_eq!(fit.state(), State::Queued);
    let got = fits.get_fit(GetFitRequest { name: fit.name.clone() }).await.unwrap().into_inner();
    assert_eq!(got, fit);
    let list = fits.list_fits(ListFitsRequest::default()).await.unwrap().into_inner();
    assert_eq!(list.fits, [fit]);
}

/// Clients of gRPC refuse more than 8 KiB of metadata, with another error.
#[tokio::test]
async fn many_faults_reach_clients_of_both_transports() {
    let server = Server::start().await;
    let capture = server.capture().await;
    let names: Vec<String> = (10..40).map(|n| format!("setting_that_is_not_there_{n}")).collect();
    let settings: Value = names.iter().map(|name| (name.clone(), json!(1))).collect();
    let (status, problem) =
        server.post("/v1/fits", json!({"capture": capture, "settings": settings})).await;
    let detail = problem["detail"].as_str().unwrap();
    // Twenty are reported.
    assert_eq!((status, &problem["reason"]), (400, &json!("INVALID_SETTINGS")));
    assert!(names[..20].iter().all(|name| detail.contains(name)), "{detail}");
    let settings_json = settings.to_string();
    let request = CreateFitRequest { capture, settings_json, ..CreateFitRequest::default() };
    let status = server.fits().create_fit(request).await.unwrap_err();
    assert_eq!(status.code(), tonic::Code::InvalidArgument, "{status:?}");
    assert_eq!(bendtwin_proto::fault::fault(&status).reason, "INVALID_SETTINGS");
    let message = status.message();
    assert!(message.contains(&names[0]) && message.ends_with(" more"), "{message}");
    assert!(message.len() <= 1400 && detail.len() > 5000, "{} {}", message.len(), detail.len());
}

/// Reads the events of a fit until the server ends them.
async fn events(server: &Server, fit: &str, last: Option<&str>) -> Vec<(u64, Value)> {
    let mut request = server.http.get(server.url(&format!("/v1/{fit}/events")));
    if let Some(last) = last {
        request = request.header("last-event-id", last);
    }
    let response = request.send().await.unwrap();
    assert_eq!(response.headers()["content-type"], "text/event-stream");
    let text = response.text().await.unwrap();
    let events = text.split("\n\n").filter(|e| !e.is_empty() && !e.starts_with(':'));
    let field = |event: &str, name: &str| {
        let line = event.lines().find_map(|l| l.strip_prefix(&format!("{name}: ")));
        line.unwrap().to_owned()
    };
    events
        .map(|e| {
            assert_eq!(field(e, "event"), "fit");
            (field(e, "id").parse().unwrap(), serde_json::from_str(&field(e, "data")).unwrap())
        })
        .collect()
}

#[tokio::test]
async fn events_report_every_change_and_resume() {
    let server = Server::start().await;
    let fit = server.fit().await;
    let mut worker = Worker::register(&server).await;
    let watch = WatchFitRequest { name: fit.clone(), after_revision: 0 };
    let mut watched = server.fits().watch_fit(watch).await.unwrap().into_inner();
    assert_eq!(watched.next().await.unwrap().unwrap().state(), State::Queued);
    let work = async {
        let lease = worker.lease(Duration::from_secs(5)).await.unwrap();
        for i in 1..4 {
            worker.report(&lease, f64::from(i) / 4.0).await.unwrap();
        }
        worker.complete(&lease, b"a twin").await.unwrap()
    };
    let (seen, twin) = tokio::join!(events(&server, &fit, None), work);
    assert!(seen.windows(2).all(|w| w[0].0 < w[1].0));
    let (last, state) = seen.last().unwrap();
    assert_eq!((&state["job"]["state"], &state["twin"]), (&json!("SUCCEEDED"), &json!(twin)));
    assert_eq!(state["job"]["revision"], json!(last));
    // From the end: nothing new, and the stream ends; from before it: the last state.
    assert_eq!(events(&server, &fit, Some(&last.to_string())).await, []);
    assert_eq!(events(&server, &fit, Some(&(last - 1).to_string())).await.len(), 1);
    // An id of another stream counts as none.
    for other in ["x", "-1", "99999999999999999999999", ""] {
        assert_eq!(events(&server, &fit, Some(other)).await.len(), 1, "{other}");
    }
    let mut messages = Vec::new();
    while let Some(message) = watched.next().await {
        messages.push(message.unwrap());
    }
    assert_eq!(messages.last().unwrap().twin, twin);
    let unknown = server.get("/v1/fits/00000000-0000-7000-8000-000000000000/events").await;
    assert_eq!(unknown.0, 404);
}

#[tokio::test]
async fn a_fit_that_no_worker_has_the_memory_for_is_refused_with_what_would_fit() {
    let server = Server::start().await;
    let mut worker = Worker::register(&server).await;
    // It may give a fit 4 GiB.
    worker.heartbeat().await.unwrap();
    let capture = server.capture().await;
    let settings = json!({
        "graph": {"max_nodes": 3000, "max_neighbours": 256, "max_triplets": 256},
        "search": {"population": 10_000, "starts": 64},
    });
    let fit = json!({"capture": capture, "settings": settings});
    // Nothing is known of the capture yet: a worker will see.
    let (status, early) = server.post("/v1/fits", fit.clone()).await;
    assert_eq!(status, 202, "{early}");

    let report = r#"{"format": "bendtwin-capture-report", "version": 1, "verdict": "good",
        "frame_count": 100, "observed": {"point_count": 3000, "control_count": 30,
        "completed_count": 0, "interior_count": 0, "visible": [3000]}}"#;
    let lease = worker.lease_a(Kind::Ingest, Duration::ZERO).await.unwrap();
    let seen = Some(observation(b"seen"));
    worker.send_ingest(&lease, seen, report.to_owned(), "good", None).await.unwrap();
    let (status, refused) = server.post("/v1/fits", fit).await;
    assert_eq!((status, &refused["reason"]), (400, &json!("FIT_OUT_OF_MEMORY")), "{refused}");
    let detail = refused["detail"].as_str().unwrap();
    assert!(detail.contains("may take 4.0"), "{detail}");
    let starts = detail.split("search.starts ").nth(1).expect(detail);
    let starts: u32 = starts.split(|c: char| !c.is_ascii_digit()).next().unwrap().parse().unwrap();
    assert!((1..64).contains(&starts), "{detail}");

    // What it says would fit does, and so does a large population alone.
    for starts in [starts, 1] {
        let mut settings = settings.clone();
        settings["search"]["starts"] = starts.into();
        let fit = json!({"capture": capture, "settings": settings});
        let (status, fit) = server.post("/v1/fits", fit).await;
        assert_eq!(status, 202, "{fit}");
    }
}

/// Content may be away while rows are there: a worker checks the memory of the fit again.
#[tokio::test]
async fn a_fit_is_queued_soon_while_the_report_of_its_capture_cannot_be_read() {
    let server = Server::start().await;
    let mut worker = Worker::register(&server).await;
    let capture = server.capture().await;
    assert!(worker.lease(Duration::ZERO).await.is_none(), "it is read, and nothing else waits");
    worker.heartbeat().await.unwrap();
    let report = server.http.get(server.url(&format!("/v1/{capture}/report"))).send().await;
    let report = report.unwrap().bytes().await.unwrap();
    // Opening a pipe takes until somebody writes to it.
    let blob = server.blob(&blake3::hash(&report).to_hex()).unwrap();
    std::fs::remove_file(&blob).unwrap();
    assert!(std::process::Command::new("mkfifo").arg(&blob).status().unwrap().success());
    let queued = server.post("/v1/fits", json!({"capture": capture}));
    let queued = tokio::time::timeout(Duration::from_secs(6), queued).await;
    // Lets the thread end that waits for it.
    drop(std::fs::OpenOptions::new().read(true).write(true).open(&blob).unwrap());
    let (status, fit) = queued.expect("the fit is queued");
    assert_eq!(status, 202, "{fit}");
}

fn preview() -> FitPreview {
    FitPreview {
        stage: "refine".into(),
        variant: "bending".into(),
        iteration: 3,
        sequence: 1,
        frames: Some(Tensor::pack(&[2], &[0_u32, 9])),
        positions: Some(Tensor::pack_points_i16(&[2, 1], &[[-1.0; 3], [1.0; 3]])),
        measure: "track".into(),
        error_m: 0.008,
        baseline_m: 0.041,
        ..FitPreview::default()
    }
}

#[tokio::test]
async fn what_a_running_fit_has_so_far_is_served_over_both_transports() {
    let server = Server::start().await;
    let fit = server.fit().await;
    let path = format!("/v1/{fit}/preview");
    let (status, missing) = server.get(&path).await;
    assert_eq!((status, &missing["reason"]), (404, &json!("PREVIEW_MISSING")));
    let mut worker = Worker::register(&server).await;
    let lease = worker.lease(Duration::from_secs(5)).await.unwrap();
    worker.report_preview(&lease, preview()).await.unwrap();
    let wrong = FitPreview { measure: "loss".into(), ..preview() };
    let refused = worker.report_preview(&lease, wrong).await.unwrap_err();
    assert_eq!(refused.code(), Code::InvalidArgument);

    let (status, lists) = server.get(&path).await;
    assert_eq!(status, 200, "{lists}");
    assert_eq!((&lists["error_m"], &lists["baseline_m"]), (&json!(0.008), &json!(0.041)));
    assert_eq!((&lists["frames"], &lists["sequence"]), (&json!([0, 9]), &json!(1)));
    assert!((lists["positions"][1][0][2].as_f64().unwrap() - 1.0).abs() < 1e-4, "{lists}");
    assert!(lists["create_time"].is_string() && lists.get("held_back_m").is_none(), "{lists}");
    let (_, packed) = server.get(&format!("{path}?tensors=base64")).await;
    assert_eq!(packed["positions"]["dtype"], "INT16_SCALED");
    let request = GetFitPreviewRequest { name: fit.clone() };
    let read = server.fits().get_fit_preview(request.clone()).await.unwrap().into_inner();
    assert_eq!(FitPreview { create_time: None, ..read }, preview());

    worker.complete(&lease, b"a twin").await.unwrap();
    let gone = server.fits().get_fit_preview(request).await.unwrap_err();
    assert_eq!(gone.code(), Code::NotFound);
    assert_eq!(server.get(&path).await.0, 404);
}
