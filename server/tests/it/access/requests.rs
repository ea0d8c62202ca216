//! Request ids of different owners, over every way to make something.

use bendtwin_proto::v1::{
    CaptureMetadata, CreateCaptureRequest, CreateFitRequest,
    capture_service_client::CaptureServiceClient, create_capture_request::Part,
    fit_service_client::FitServiceClient,
};
use serde_json::{Value, json};

use super::keys::{bearer, locked, make};
use crate::harness::{Server, read};

const ID: &str = "rope-1";

async fn key(server: &Server, owner: &str) -> String {
    let scopes = ["captures:write:own", "fits:write:own", "twins:write:own"];
    make(server, json!({"display_name": owner, "scopes": scopes})).await.1
}

async fn made(request: reqwest::RequestBuilder, key: &str) -> Value {
    let request = request.bearer_auth(key).header("idempotency-key", ID);
    let (status, made) = read(request.send().await.unwrap()).await;
    assert!(matches!(status, 201 | 202), "{made}");
    made
}

#[tokio::test]
async fn owners_do_not_meet_in_their_request_ids() {
    let server = locked().await;
    let keys = [key(&server, "ada").await, key(&server, "eve").await];
    let post = |path: &str| server.http.post(server.url(path));
    let mut seen = Vec::new();
    for (key, content) in keys.iter().zip(["of ada", "of eve"]) {
        let upload = || post("/v1/captures?display_name=rope").body(content);
        let capture = made(upload(), key).await;
        assert_eq!(made(upload(), key).await["name"], capture["name"], "a repetition");
        let fit = || post("/v1/fits").json(&json!({"capture": capture["name"]}));
        let first = made(fit(), key).await;
        assert_eq!(made(fit(), key).await["name"], first["name"], "a repetition");
        let twin = || post("/v1/twins").body(crate::twins::twin_file());
        let twin = made(twin(), key).await;
        seen.extend([capture, first, twin].map(|made| made["name"].to_string()));
    }
    seen.sort();
    seen.dedup();
    assert_eq!(seen.len(), 6, "{seen:?}");

    // The other transport knows the same ids.
    let mut captures = Vec::new();
    for (key, content) in keys.iter().zip(["of ada", "of eve"]) {
        let mut client =
            CaptureServiceClient::with_interceptor(server.channel.clone(), bearer(key));
        let metadata = CaptureMetadata {
            display_name: "rope".to_owned(),
            request_id: ID.to_owned(),
            ..CaptureMetadata::default()
        };
        let parts = [Part::Metadata(metadata), Part::Chunk(content.as_bytes().into())];
        let parts = parts.map(|part| CreateCaptureRequest { part: Some(part) });
        let capture = client.create_capture(futures::stream::iter(parts)).await.unwrap();
        captures.push(capture.into_inner().capture.unwrap().name);
    }
    assert!(captures.iter().all(|name| seen.contains(&format!("{name:?}"))), "{captures:?}");
    let mut fits = FitServiceClient::with_interceptor(server.channel.clone(), bearer(&keys[1]));
    let order = CreateFitRequest {
        capture: captures[1].clone(),
        request_id: ID.to_owned(),
        ..CreateFitRequest::default()
    };
    let fit = fits.create_fit(order).await.unwrap().into_inner();
    assert!(seen.contains(&format!("{:?}", fit.name)));
}

#[tokio::test]
async fn owners_do_not_meet_in_resumable_uploads() {
    let server = locked().await;
    let keys = [key(&server, "ada").await, key(&server, "eve").await];
    let begin = async |key: &str| {
        let request = server.http.post(server.url("/v1/uploads")).bearer_auth(key);
        let request = request.header("tus-resumable", "1.0.0").header("upload-length", "3");
        let begun = request.header("idempotency-key", ID).send().await.unwrap();
        assert_eq!(begun.status(), 201);
        begun.headers()["location"].to_str().unwrap().to_owned()
    };
    let (first, second) = (begin(&keys[0]).await, begin(&keys[1]).await);
    assert_ne!(first, second);
    assert_eq!((begin(&keys[0]).await, begin(&keys[1]).await), (first.clone(), second.clone()));
    let mut captures = Vec::new();
    for (key, path) in keys.iter().zip([&first, &second]) {
        let request = server.http.patch(server.url(path)).bearer_auth(key).body("abc");
        let request = request.header("tus-resumable", "1.0.0").header("upload-offset", "0");
        let request = request.header("content-type", "application/offset+octet-stream");
        let stored = request.send().await.unwrap();
        assert_eq!(stored.status(), 204);
        captures.push(stored.headers()["bendtwin-capture"].to_str().unwrap().to_owned());
    }
    assert_ne!(captures[0], captures[1]);
    // Begun again, each finds its own.
    assert_eq!((begin(&keys[0]).await, begin(&keys[1]).await), (first, second));
    // A deletion by one frees nothing of the other.
    let delete = server.http.delete(server.url(&format!("/v1/{}", captures[1])));
    assert_eq!(delete.bearer_auth(&keys[1]).send().await.unwrap().status(), 204);
    let late = server.http.post(server.url("/v1/captures")).bearer_auth(&keys[1]);
    let late = late.header("idempotency-key", ID).body("abc").send().await.unwrap();
    let (status, problem) = read(late).await;
    assert_eq!((status, &problem["reason"]), (409, &json!("DELETED_SINCE")), "{problem}");
    let again = server.http.post(server.url("/v1/captures")).bearer_auth(&keys[0]);
    let (status, again) =
        read(again.header("idempotency-key", ID).body("abc").send().await.unwrap()).await;
    assert_eq!((status, again["name"].as_str()), (201, Some(captures[0].as_str())), "{again}");
}
