//! Scopes that are bound to their owner: every call of the API that names a resource, by a key of
//! another owner, and by another key of the same one; and lists.

use std::sync::Arc;

use bendtwin_harness::play::Play;
use bendtwin_proto::v1::{
    self, AddSupplementRequest, AdvanceSessionRequest, PlanRequest, RollOutRequest,
    SupplementMetadata, add_supplement_request::Part, session_service_client::SessionServiceClient,
};
use bendtwin_server::access::{Access, Scope, TABLE};
use prost::Message;
use serde_json::{Value, json};
use tokio::sync::Notify;

use super::keys::{bearer, locked, make};
use crate::{
    harness::{Server, read},
    worker::{Device, Worker},
};

/// Calls that name nothing that there is: they make something of the caller's, or list what the
/// caller reaches, which the tests below look at.
const NAME_NOTHING: [&str; 19] = [
    "POST /v1/captures",
    "GET /v1/captures",
    "/bendtwin.v1.CaptureService/CreateCapture",
    "/bendtwin.v1.CaptureService/ListCaptures",
    "GET /v1/fits",
    "/bendtwin.v1.FitService/ListFits",
    "POST /v1/twins",
    "GET /v1/twins",
    "/bendtwin.v1.TwinService/CreateTwin",
    "/bendtwin.v1.TwinService/ListTwins",
    "POST /v1/uploads",
    "GET /v1/uploads",
    "GET /v1/trash/captures",
    "GET /v1/trash/fits",
    "GET /v1/trash/twins",
    "/bendtwin.v1.TrashService/ListTrashedCaptures",
    "/bendtwin.v1.TrashService/ListTrashedFits",
    "/bendtwin.v1.TrashService/ListTrashedTwins",
    // Its messages come one by one: see `messages_of_a_stream_are_refused`.
    "/bendtwin.v1.SessionService/ControlSession",
];

/// All scopes that can be bound, bound.
pub(super) fn bound() -> Vec<String> {
    let scopes = Scope::ALL.into_iter().filter(|scope| scope.has_bound());
    scopes.map(|scope| format!("{}:own", scope.as_str())).collect()
}

/// The same without a bound.
fn unbound() -> Vec<&'static str> {
    let scopes = Scope::ALL.into_iter().filter(|scope| scope.has_bound());
    scopes.map(Scope::as_str).collect()
}

/// A server with something of each kind, all of it of the owner `ada`.
pub(super) struct Estate {
    pub(super) server: Server,
    pub(super) capture: String,
    fit: String,
    pub(super) twin: String,
    upload: String,
    share: String,
    session: String,
    play: String,
    /// Key of `ada` without bounds.
    pub(super) key: String,
    _worker: Worker,
    _play: Play,
}

impl Estate {
    pub(super) async fn new() -> Self {
        let server = locked().await;
        let order = json!({"display_name": "ada", "scopes": unbound()});
        let (_, key) = make(&server, order).await;
        // The play waits for its first frame.
        let device = Device { hold: Some(Arc::new(Notify::new())), ..Device::default() };
        let mut worker = Worker::register_with(&server, device).await;
        let post = |path: &str| server.http.post(server.url(path)).bearer_auth(&key);
        let made = async |request: reqwest::RequestBuilder| {
            let (status, made) = read(request.send().await.unwrap()).await;
            assert!(matches!(status, 201 | 202), "{made}");
            made["name"].as_str().unwrap().to_owned()
        };
        let capture = made(post("/v1/captures?display_name=rope").body("an archive")).await;
        let fit = made(post("/v1/fits").json(&json!({"capture": capture}))).await;
        let lease = worker.lease(std::time::Duration::from_secs(5)).await.unwrap();
        assert_eq!(lease.job, fit);
        let twin = worker.complete(&lease, b"a twin").await.unwrap();
        let upload = post("/v1/uploads").header("tus-resumable", "1.0.0");
        let upload = upload.header("upload-length", "9").send().await.unwrap();
        let upload = upload.headers()["location"].to_str().unwrap().replace("/v1/", "");
        let order = json!({"display_name": "the board"});
        let share = post(&format!("/v1/{twin}/shares")).json(&order).send().await.unwrap();
        let (_, share) = read(share).await;
        let share = share["share"]["name"].as_str().unwrap().to_owned();
        let session = made(post("/v1/sessions").json(&json!({"twin": twin}))).await;
        let authorization = format!("Bearer {key}");
        let headers = [("authorization", authorization.as_str())];
        let (url, path) = (server.url(""), format!("/v1/{twin}/play"));
        let mut play = Play::connect(&url, &path, &headers).await;
        play.send(json!({"type": "begin"})).await;
        play.expect_ready().await;
        let name = play.ready["play"].as_str().unwrap().to_owned();
        Self {
            capture,
            fit,
            twin,
            upload,
            share,
            session,
            play: name,
            key,
            _worker: worker,
            _play: play,
            server,
        }
    }

    /// The resource of a collection.
    fn of(&self, collection: &str) -> &str {
        match collection {
            "captures" | "CaptureService" => &self.capture,
            "fits" | "FitService" => &self.fit,
            "uploads" => &self.upload,
            "shares" => &self.share,
            "sessions" | "SessionService" => &self.session,
            "plays" => &self.play,
            _ => &self.twin,
        }
    }

    /// The request of a route about what is here.
    fn route(&self, method: &str, path: &str) -> reqwest::RequestBuilder {
        let collection = path.split('/').nth(2).unwrap_or_default();
        let id = self.of(collection).rsplit('/').next().unwrap();
        let path = path.replace("{id}", id).replace("{kind}", "masks");
        let method = reqwest::Method::from_bytes(method.as_bytes()).unwrap();
        let url = self.server.url(&path);
        let request = self.server.http.request(method.clone(), url);
        let body = match path.as_str() {
            "/v1/fits" => json!({"capture": self.capture}),
            "/v1/plans" => json!({"rollout": {"twin": self.twin}}),
            "/v1/sessions" => json!({"twin": self.twin}),
            _ => json!({"capture": self.capture}),
        };
        let last = path.rsplit('/').next().unwrap();
        match (collection, method.as_str(), last) {
            ("uploads", ..) => request
                .header("tus-resumable", "1.0.0")
                .header("upload-offset", "0")
                .header("content-type", "application/offset+octet-stream"),
            (.., "play" | "watch") => request
                .header("connection", "upgrade")
                .header("upgrade", "websocket")
                .header("sec-websocket-version", "13")
                .header("sec-websocket-key", "dGhlIHNhbXBsZSBub25jZQ=="),
            ("captures", "PUT", _) => request.body("masks"),
            (_, "GET" | "DELETE", _) => request,
            (.., "evaluations") => request.query(&[("timeout_s", "0.5")]).json(&body),
            (_, "POST", _) if path == format!("/v1/{collection}") => request.json(&body),
            _ => request.json(&json!({})),
        }
    }

    /// The request of an RPC about what is here.
    fn rpc(&self, path: &str) -> reqwest::RequestBuilder {
        let service = path.rsplit(['.', '/']).nth(1).unwrap();
        let (capture, twin) = (self.capture.clone(), self.twin.clone());
        let rollout = || RollOutRequest { twin: self.twin.clone(), ..Default::default() };
        let message = match path.rsplit('/').next().unwrap() {
            "UpdateCapture" => v1::UpdateCaptureRequest {
                capture: Some(v1::Capture { name: capture, ..Default::default() }),
                ..Default::default()
            }
            .encode_to_vec(),
            "UpdateFit" => v1::UpdateFitRequest {
                fit: Some(v1::Fit { name: self.fit.clone(), ..Default::default() }),
                ..Default::default()
            }
            .encode_to_vec(),
            "UpdateTwin" => v1::UpdateTwinRequest {
                twin: Some(v1::Twin { name: twin, ..Default::default() }),
                ..Default::default()
            }
            .encode_to_vec(),
            "AddSupplement" => AddSupplementRequest {
                part: Some(Part::Metadata(SupplementMetadata {
                    name: capture,
                    kind: "masks".to_owned(),
                    ..Default::default()
                })),
            }
            .encode_to_vec(),
            "CreateFit" => v1::CreateFitRequest { capture, ..Default::default() }.encode_to_vec(),
            "Plan" => {
                PlanRequest { rollout: Some(rollout()), ..Default::default() }.encode_to_vec()
            }
            "EvaluateTwin" => {
                v1::EvaluateTwinRequest { twin, capture, ..Default::default() }.encode_to_vec()
            }
            "DeleteShare" => v1::DeleteShareRequest { name: self.share.clone() }.encode_to_vec(),
            "UndeleteCapture" => v1::UndeleteCaptureRequest { name: capture }.encode_to_vec(),
            "UndeleteFit" => v1::UndeleteFitRequest { name: self.fit.clone() }.encode_to_vec(),
            "OpenSession" => v1::OpenSessionRequest { twin, ..Default::default() }.encode_to_vec(),
            // Others name what they are about in their first field. A new RPC that does not is
            // refused as naming nothing, and has to be added above.
            _ => v1::GetTwinRequest { name: self.of(service).to_owned() }.encode_to_vec(),
        };
        let mut body = vec![0];
        body.extend(u32::try_from(message.len()).unwrap().to_be_bytes());
        body.extend(message);
        let request = self.server.http.post(self.server.url(path)).body(body);
        request
            .header("content-type", "application/grpc")
            .header("te", "trailers")
            .header("grpc-timeout", "500m")
    }

    /// Makes a call of the table. Returns the reason and the message of a refusal, if any.
    pub(super) async fn call(&self, name: &str, key: &str) -> (String, String) {
        let request = match name.split_once(' ') {
            Some((method, path)) => self.route(method, path),
            None => self.rpc(name),
        };
        let response = request.bearer_auth(key).send().await.unwrap();
        if !name.contains(' ') {
            let status = tonic::Status::from_header_map(response.headers());
            let status = status.unwrap_or_else(|| tonic::Status::ok(""));
            let fault = bendtwin_proto::fault::fault(&status);
            return (fault.reason, status.message().to_owned());
        }
        if response.status().is_success() || response.status().as_u16() == 101 {
            return Default::default();
        }
        if name.starts_with("HEAD") {
            // Without a body, only the status is known.
            let refused = response.status() == 403;
            return (
                if refused { "NOT_OWNER" } else { "" }.to_owned(),
                "captures:write".to_owned(),
            );
        }
        let (_, problem) = read(response).await;
        let text = |field: &str| problem[field].as_str().unwrap_or_default().to_owned();
        (text("reason"), text("detail"))
    }
}

/// The calls of the table that take a scope which can be bound, those that end something last.
fn calls() -> Vec<(&'static str, Scope)> {
    let bounded = TABLE.iter().filter_map(|(name, access)| match access {
        Access::Scope(scope) if scope.has_bound() => Some((name.as_str(), *scope)),
        _ => None,
    });
    let mut calls: Vec<_> = bounded.filter(|(name, _)| !NAME_NOTHING.contains(name)).collect();
    let ends = |name: &str| ["DELETE", "Delete", "Close"].iter().any(|end| name.contains(end));
    calls.sort_by_key(|(name, _)| ends(name));
    calls
}

#[tokio::test]
async fn every_call_that_names_something_is_refused_to_other_owners() {
    let estate = Estate::new().await;
    let order = json!({"display_name": "eve", "scopes": bound()});
    let (_, eve) = make(&estate.server, order).await;
    let order = json!({"display_name": "her robot", "owner": "ada", "scopes": bound()});
    let (_, robot) = make(&estate.server, order).await;
    let calls = calls();
    assert!(calls.len() > 80, "{}", calls.len());
    for (name, scope) in &calls {
        let (reason, message) = estate.call(name, &eve).await;
        assert_eq!(reason, "NOT_OWNER", "{name}: {message}");
        assert!(message.contains(scope.as_str()), "{name}: {message}");
    }
    // They changed nothing, and another key of the owner with the same scopes may make them.
    for name in ["GET /v1/captures/{id}", "GET /v1/fits/{id}", "GET /v1/twins/{id}"] {
        assert_eq!(estate.call(name, &robot).await.0, "", "{name}");
    }
    for (name, _) in &calls {
        let (reason, message) = estate.call(name, &robot).await;
        assert_ne!(reason, "NOT_OWNER", "{name}: {message}");
    }
    // A twin that does not exist is not found by any key.
    let path = "/v1/twins/0190a000-0000-7000-8000-00000000beef";
    let request = estate.server.http.get(estate.server.url(path)).bearer_auth(&eve);
    let (_, problem) = read(request.send().await.unwrap()).await;
    assert_eq!(problem["reason"], "NOT_FOUND");
}

#[tokio::test]
async fn lists_and_what_is_made_are_the_owners() {
    let estate = Estate::new().await;
    let server = &estate.server;
    let order = json!({"display_name": "eve", "scopes": bound()});
    let (_, eve) = make(server, order).await;
    let order = json!({"display_name": "her robot", "owner": "ada", "scopes": bound()});
    let (_, robot) = make(server, order).await;
    let count = async |path: &str, key: &str| {
        let request = server.http.get(server.url(path)).bearer_auth(key);
        let request = request.header("tus-resumable", "1.0.0");
        let (status, list) = read(request.send().await.unwrap()).await;
        assert_eq!(status, 200, "{path}: {list}");
        let lists = list.as_object().unwrap().values();
        lists.filter_map(|items| items.as_array().map(Vec::len)).sum::<usize>()
    };
    for path in ["/v1/captures", "/v1/fits", "/v1/twins", "/v1/uploads"] {
        assert_eq!(count(path, &eve).await, 0, "{path}");
        assert_eq!(count(path, &robot).await, 1, "{path}");
        assert_eq!(count(path, &estate.key).await, 1, "{path}");
    }
    assert_eq!(count("/v1/captures?owner=ada", &eve).await, 0);
    // What eve makes is hers alone.
    let upload = server.http.post(server.url("/v1/captures")).bearer_auth(&eve).body("other");
    let (status, made) = read(upload.send().await.unwrap()).await;
    assert_eq!((status, &made["owner"]), (201, &json!("eve")), "{made}");
    assert_eq!(count("/v1/captures", &eve).await, 1);
    assert_eq!(count("/v1/captures", &robot).await, 1);
    let path = format!("/v1/{}", made["name"].as_str().unwrap());
    let get = |key: &str| server.http.get(server.url(&path)).bearer_auth(key).send();
    assert_eq!(get(&eve).await.unwrap().status(), 200);
    assert_eq!(get(&robot).await.unwrap().status(), 403);
    assert_eq!(get(&estate.key).await.unwrap().status(), 200);
    // In the trash, too, where another owner restores nothing.
    let delete = server.http.delete(server.url(&path)).bearer_auth(&eve).send().await.unwrap();
    assert_eq!(delete.status(), 204);
    assert_eq!(count("/v1/trash/captures", &eve).await, 1);
    assert_eq!(count("/v1/trash/captures", &robot).await, 0);
    let undelete = |key: &str| {
        server.http.post(server.url(&format!("{path}/undelete"))).bearer_auth(key).send()
    };
    assert_eq!(undelete(&robot).await.unwrap().status(), 403);
    assert_eq!(undelete(&eve).await.unwrap().status(), 200);
}

#[tokio::test]
async fn what_is_named_beside_a_twin_is_refused() {
    let estate = Estate::new().await;
    let server = &estate.server;
    let order = json!({"display_name": "eve", "scopes": bound()});
    let (_, eve) = make(server, order).await;
    let post = async |path: &str, body: Value| {
        let request = server.http.post(server.url(path)).bearer_auth(&eve);
        read(request.json(&body).send().await.unwrap()).await
    };
    let twin = server.http.post(server.url("/v1/twins")).bearer_auth(&eve);
    let (_, twin) = read(twin.body(crate::twins::twin_file()).send().await.unwrap()).await;
    let twin = twin["name"].as_str().unwrap();
    let (_, capture) = read(
        server
            .http
            .post(server.url("/v1/captures"))
            .bearer_auth(&eve)
            .body("hers")
            .send()
            .await
            .unwrap(),
    )
    .await;
    let of_ada = json!({"capture_frame": {"capture": estate.capture}});
    let in_session = json!({"session": {"session": estate.session}});
    let rollouts = format!("/v1/{twin}/rollouts");
    let start = json!({"capture": capture["name"], "settings": {"start_from": estate.twin}});
    for (path, body) in [
        (rollouts.as_str(), json!({"initial": of_ada})),
        (rollouts.as_str(), json!({"initial": in_session})),
        ("/v1/plans", json!({"rollout": {"twin": twin, "initial": of_ada}})),
        ("/v1/plans", json!({"rollout": {"initial": in_session}})),
        ("/v1/sessions", json!({"twin": twin, "initial": of_ada})),
        (&format!("/v1/{twin}/register"), json!({"initial": of_ada})),
        (&format!("/v1/{twin}/evaluations"), json!({"capture": estate.capture})),
        ("/v1/fits", start),
    ] {
        let (status, problem) = post(path, body).await;
        assert_eq!((status, &problem["reason"]), (403, &json!("NOT_OWNER")), "{path}: {problem}");
    }
    // Her session cannot be set to a frame of his capture either.
    let (status, session) = post("/v1/sessions", json!({"twin": twin})).await;
    assert_eq!(status, 201, "{session}");
    let reset = format!("/v1/{}/reset", session["name"].as_str().unwrap());
    let (status, problem) = post(&reset, json!({"initial": of_ada})).await;
    assert_eq!((status, &problem["reason"]), (403, &json!("NOT_OWNER")), "{problem}");
}

#[tokio::test]
async fn messages_of_a_stream_are_refused() {
    let estate = Estate::new().await;
    let order = json!({"display_name": "eve", "scopes": bound()});
    let (_, eve) = make(&estate.server, order).await;
    let channel = estate.server.channel.clone();
    let mut sessions = SessionServiceClient::with_interceptor(channel, bearer(&eve));
    let advance = AdvanceSessionRequest { name: estate.session.clone(), ..Default::default() };
    let replies = sessions.control_session(futures::stream::iter([advance])).await.unwrap();
    let refused = replies.into_inner().message().await.unwrap_err();
    assert_eq!(bendtwin_proto::fault::fault(&refused).reason, "NOT_OWNER");
}
