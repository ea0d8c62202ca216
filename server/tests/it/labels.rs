//! Names, notes and tags of captures, fits and twins, the lists by them, and the losses of fits.

use std::time::Duration;

use base64::{Engine as _, prelude::BASE64_STANDARD};
use bendtwin_proto::v1::{
    Capture, CaptureMetadata, CreateCaptureRequest, Fit, GetFitLossesRequest, ListFitsRequest,
    ListTwinsRequest, ModelLoss, UpdateCaptureRequest, UpdateFitRequest,
    create_capture_request::Part, job::State,
};
use prost_types::FieldMask;
use serde_json::{Value, json};
use tonic::Code;

use crate::{
    harness::{Server, read},
    twins::twin_file,
    worker::Worker,
};

async fn patch(server: &Server, name: &str, change: Value) -> (u16, Value) {
    let request = server.http.patch(server.url(&format!("/v1/{name}"))).json(&change);
    read(request.send().await.unwrap()).await
}

async fn twin(server: &Server, name: &str) -> String {
    let url = server.url(&format!("/v1/twins?display_name={name}"));
    let (_, twin) = read(server.http.post(url).body(twin_file()).send().await.unwrap()).await;
    twin["name"].as_str().unwrap().to_owned()
}

/// Display names of a list.
async fn listed(server: &Server, path: &str) -> Vec<String> {
    let (status, page) = server.get(&format!("/v1/{path}")).await;
    assert_eq!(status, 200, "{page}");
    let collection = path.split('?').next().unwrap();
    let items = page[collection].as_array().unwrap();
    items.iter().map(|item| item["display_name"].as_str().unwrap().to_owned()).collect()
}

#[tokio::test]
async fn name_note_and_tags_are_changed_over_both_transports() {
    let server = Server::start().await;
    let (fit, twin) = (server.fit().await, twin(&server, "toy").await);
    let (_, shown) = server.get(&format!("/v1/{fit}")).await;
    assert_eq!(shown["display_name"], "rope", "a fit has the name of its capture");
    let capture = shown["capture"].as_str().unwrap().to_owned();
    for name in [&capture, &fit, &twin] {
        let change = json!({"note": "left hand\nslow", "add_tags": ["wet", "a/b:c.d-e_ü"]});
        let (status, changed) = patch(&server, name, change).await;
        assert_eq!((status, &changed["note"]), (200, &json!("left hand\nslow")), "{changed}");
        assert_eq!(changed["tags"], json!(["a/b:c.d-e_ü", "wet"]));
        let change = json!({"display_name": "other", "note": null, "remove_tags": ["wet"]});
        let (_, changed) = patch(&server, name, change).await;
        assert_eq!(changed["display_name"], "other");
        assert_eq!(
            (&changed["note"], &changed["tags"]),
            (&json!("left hand\nslow"), &json!(["a/b:c.d-e_ü"]))
        );
        assert_eq!(server.get(&format!("/v1/{name}")).await.1, changed);
    }
    let (name, mut fits) = (fit.clone(), server.fits());
    let given = Fit { name: name.clone(), note: "new".into(), ..Fit::default() };
    let request = UpdateFitRequest { fit: Some(given.clone()), ..UpdateFitRequest::default() };
    let changed = fits.update_fit(request.clone()).await.unwrap().into_inner();
    assert_eq!((changed.note.as_str(), changed.display_name.as_str()), ("new", "other"));
    // The mask says what is emptied.
    let mask = |paths: &[&str]| FieldMask { paths: paths.iter().map(|&p| p.into()).collect() };
    let update_mask = Some(mask(&["tags", "note"]));
    let empty = Fit { name, ..Fit::default() };
    let emptied = UpdateFitRequest { fit: Some(empty), update_mask, ..request.clone() };
    let changed = fits.update_fit(emptied).await.unwrap().into_inner();
    assert_eq!(
        (changed.note, changed.tags, changed.display_name.as_str()),
        (String::new(), vec![], "other")
    );
    for wrong in ["priority", "job.state", "*.note"] {
        let request = UpdateFitRequest { update_mask: Some(mask(&[wrong])), ..request.clone() };
        assert_eq!(fits.update_fit(request).await.unwrap_err().code(), Code::InvalidArgument);
    }
    let nothing = UpdateCaptureRequest::default();
    let refused = server.captures().update_capture(nothing).await.unwrap_err();
    assert_eq!(refused.code(), Code::InvalidArgument);
}

/// Stated with every kind of upload, changed over both transports, and listed by.
#[tokio::test]
async fn who_recorded_a_capture_is_stated_and_changed() {
    let server = Server::start().await;
    let upload = async |recorder: &str| {
        let request = server.http.post(server.url("/v1/captures")).body("an archive");
        let request = request.query(&[("recorded_by", recorder), ("display_name", "whole")]);
        read(request.send().await.unwrap()).await
    };
    let (status, whole) = upload("Ada Lovelace").await;
    assert_eq!((status, &whole["recorded_by"]), (201, &json!("Ada Lovelace")), "{whole}");
    for wrong in ["x".repeat(201), "a\nb".to_owned()] {
        let (status, problem) = upload(&wrong).await;
        assert_eq!((status, &problem["reason"]), (400, &json!("INVALID_FIELD")), "{problem}");
        assert!(problem["detail"].as_str().unwrap().contains("recorded_by"), "{problem}");
    }
    let pair = |key: &str, value: &str| format!("{key} {}", BASE64_STANDARD.encode(value));
    let metadata = [pair("display_name", "resumed"), pair("recorded_by", "Ada Lovelace")].join(",");
    let tus = server.http.post(server.url("/v1/uploads")).header("tus-resumable", "1.0.0");
    let tus = tus.header("content-type", "application/offset+octet-stream");
    let tus = tus.header("upload-metadata", metadata).header("upload-length", "10");
    let resumed = tus.body("an archive").send().await.unwrap();
    let resumed = resumed.headers()["bendtwin-capture"].to_str().unwrap().to_owned();
    assert_eq!(server.get(&format!("/v1/{resumed}")).await.1["recorded_by"], "Ada Lovelace");
    let metadata = CaptureMetadata {
        display_name: "streamed".to_owned(),
        recorded_by: "Grace".to_owned(),
        ..CaptureMetadata::default()
    };
    let parts = [Part::Metadata(metadata), Part::Chunk("an archive".into())];
    let parts = parts.map(|part| CreateCaptureRequest { part: Some(part) });
    let streamed = server.captures().create_capture(futures::stream::iter(parts)).await.unwrap();
    let streamed = streamed.into_inner().capture.unwrap();
    assert_eq!(streamed.recorded_by, "Grace");
    assert_eq!(listed(&server, "captures?recorded_by=Grace").await, ["streamed"]);
    let ada = "captures?recorded_by=Ada%20Lovelace";
    assert_eq!(listed(&server, ada).await, ["resumed", "whole"]);

    let change = json!({"recorded_by": "Ada Lovelace", "note": "slow"});
    let (status, changed) = patch(&server, &streamed.name, change).await;
    assert_eq!((status, &changed["recorded_by"]), (200, &json!("Ada Lovelace")), "{changed}");
    let (_, changed) = patch(&server, &streamed.name, json!({"display_name": "renamed"})).await;
    assert_eq!(changed["recorded_by"], "Ada Lovelace", "what a change does not name stays");
    assert_eq!(listed(&server, ada).await, ["renamed", "resumed", "whole"]);
    let capture = Capture { name: streamed.name.clone(), ..Capture::default() };
    let emptied = UpdateCaptureRequest {
        capture: Some(capture),
        update_mask: Some(FieldMask { paths: vec!["recorded_by".to_owned()] }),
        ..UpdateCaptureRequest::default()
    };
    let emptied = server.captures().update_capture(emptied).await.unwrap().into_inner();
    assert_eq!((emptied.recorded_by.as_str(), emptied.note.as_str()), ("", "slow"));
    let change = json!({"recorded_by": "x".repeat(201)});
    assert_eq!(patch(&server, &streamed.name, change).await.0, 400);
    // Only captures have it.
    let twin = twin(&server, "toy").await;
    assert_eq!(patch(&server, &twin, json!({"recorded_by": "Ada"})).await.0, 400);
}

#[tokio::test]
async fn what_is_no_name_note_or_tag_is_refused() {
    let server = Server::start().await;
    let name = twin(&server, "toy").await;
    let many: Vec<String> = (0..33).map(|i| format!("t{i}")).collect();
    for (change, field) in [
        (json!({"display_name": "x".repeat(201)}), "display_name"),
        (json!({"display_name": "a\nb"}), "display_name"),
        (json!({"note": "x".repeat(10_001)}), "note"),
        (json!({"note": "\u{7}"}), "note"),
        (json!({"tags": [""]}), "tags"),
        (json!({"tags": ["x".repeat(51)]}), "tags"),
        (json!({"tags": many}), "tags"),
        (json!({"add_tags": ["two words"]}), "add_tags"),
        (json!({"add_tags": ["-x"]}), "add_tags"),
        (json!({"remove_tags": ["a,b"]}), "remove_tags"),
        (json!({"tags": ["a"], "add_tags": ["b"]}), "tags"),
        (json!({"name": "twins/1"}), "body"),
        (json!([]), "body"),
    ] {
        let (status, problem) = patch(&server, &name, change.clone()).await;
        assert_eq!((status, &problem["reason"]), (400, &json!("INVALID_FIELD")), "{change}");
        let detail = problem["detail"].as_str().unwrap();
        assert!(detail.contains(&format!("`{field}`")), "{change}: {detail}");
    }
    assert_eq!(patch(&server, &name, json!({"tags": many[..32]})).await.0, 200);
    let (status, problem) = patch(&server, &name, json!({"add_tags": ["more"]})).await;
    assert_eq!((status, &problem["reason"]), (400, &json!("TOO_MANY_TAGS")));
    let absent = "twins/00000000-0000-7000-8000-000000000000";
    assert_eq!(patch(&server, absent, json!({"note": "x"})).await.0, 404);
}

#[tokio::test]
async fn lists_are_searched_filtered_and_ordered() {
    let server = Server::start().await;
    for name in ["beta", "Alpha", "gamma"] {
        let name = twin(&server, name).await;
        let change = json!({"note": format!("note of {name}"), "add_tags": ["toy"]});
        patch(&server, &name, change).await;
    }
    let plain = twin(&server, "delta").await;
    for (query, expected) in [
        ("twins", &["delta", "gamma", "Alpha", "beta"][..]),
        ("twins?order_by=create_time", &["beta", "Alpha", "gamma", "delta"]),
        ("twins?order_by=name", &["Alpha", "beta", "delta", "gamma"]),
        ("twins?order_by=name%20desc", &["gamma", "delta", "beta", "Alpha"]),
        ("twins?order_by=error", &["beta", "Alpha", "gamma", "delta"]),
        ("twins?search=ALPH", &["Alpha"]),
        ("twins?search=note%20of&order_by=name", &["Alpha", "beta", "gamma"]),
        ("twins?tag=toy&order_by=name%20desc", &["gamma", "beta", "Alpha"]),
        ("twins?tag=other", &[]),
    ] {
        assert_eq!(listed(&server, query).await, expected, "{query}");
    }
    let mut query =
        ListTwinsRequest { page_size: 2, order_by: "name".into(), ..ListTwinsRequest::default() };
    let mut seen = Vec::new();
    loop {
        let page = server.twins().list_twins(query.clone()).await.unwrap().into_inner();
        seen.extend(page.twins.into_iter().map(|t| t.display_name));
        query.page_token = page.next_page_token;
        if query.page_token.is_empty() {
            break;
        }
    }
    assert_eq!(seen, ["Alpha", "beta", "delta", "gamma"]);
    server.delete(&format!("/v1/{plain}")).await;
    assert!(listed(&server, "twins?search=delta").await.is_empty());

    server.fit().await;
    let query = ListFitsRequest {
        state: State::Queued.into(),
        search: "ROPE".into(),
        ..ListFitsRequest::default()
    };
    assert_eq!(server.fits().list_fits(query).await.unwrap().into_inner().fits.len(), 1);
    assert_eq!(listed(&server, "fits?state=QUEUED").await, ["rope"]);
    assert!(listed(&server, "fits?state=RUNNING").await.is_empty());
    assert_eq!(listed(&server, "captures?search=rop&order_by=name").await, ["rope"]);
    // As large a page as there may be.
    assert_eq!(listed(&server, "captures?page_size=1000000").await, ["rope"]);
    for wrong in [
        "captures?order_by=error",
        "twins?order_by=size",
        "twins?order_by=name%20up",
        "fits?state=running",
        "fits?search=%00&sort=name",
        &format!("fits?search={}", "x".repeat(201)),
    ] {
        let (status, problem) = server.get(&format!("/v1/{wrong}")).await;
        assert_eq!((status, &problem["reason"]), (400, &json!("INVALID_FIELD")), "{wrong}");
    }
}

fn loss(stage: &str, variant: &str, iteration: u32, loss: Option<f64>) -> ModelLoss {
    let error_m = loss.filter(|_| iteration == 2);
    let (stage, variant) = (stage.into(), variant.into());
    ModelLoss { stage, variant, iteration, loss, best_loss: loss, error_m }
}

#[tokio::test]
async fn the_losses_of_a_fit_stay_with_it() {
    let server = Server::start().await;
    let fit = server.fit().await;
    let path = format!("/v1/{fit}/losses");
    assert_eq!(server.get(&path).await, (200, json!({"curves": []})));
    let mut worker = Worker::register(&server).await;
    let lease = worker.lease(Duration::from_secs(5)).await.unwrap();
    let sent = vec![
        loss("search", "bending", 1, Some(0.5)),
        loss("search", "axial", 1, Some(f64::NAN)),
        loss("search", "bending", 2, Some(0.25)),
    ];
    worker.report_losses(&lease, sent).await.unwrap();
    let curve = |variant: &str, iterations: Value, losses: Value, errors_m: Value| {
        json!({"stage": "search", "variant": variant, "iterations": iterations,
            "losses": losses, "best_losses": losses, "errors_m": errors_m})
    };
    let bending = curve("bending", json!([1, 2]), json!([0.5, 0.25]), json!([null, 0.25]));
    let axial = curve("axial", json!([1]), json!([null]), json!([null]));
    let expected = json!({"curves": [bending, axial]});
    assert_eq!(server.get(&path).await, (200, expected.clone()));
    for wrong in
        [vec![loss("evaluate", "bending", 1, None)], vec![loss("refine", "b", 1, None); 1025]]
    {
        let refused = worker.report_losses(&lease, wrong).await.unwrap_err();
        assert_eq!(refused.code(), Code::InvalidArgument);
    }
    worker.complete(&lease, b"a twin").await.unwrap();
    assert_eq!(server.get(&path).await, (200, expected));
    let request = GetFitLossesRequest { name: fit.clone() };
    let curves = server.fits().get_fit_losses(request).await.unwrap().into_inner().curves;
    assert_eq!((curves[0].variant.as_str(), &curves[0].losses[..]), ("bending", &[0.5, 0.25][..]));
    assert!(curves[1].losses[0].is_nan());
    assert_eq!(server.delete(&format!("/v1/{fit}")).await.0, 204);
    assert_eq!(server.get(&path).await.0, 404);
}
