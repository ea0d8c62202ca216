//! Shares: every call of the API with the key of a link, which reaches one twin and nothing else; who makes
//! links, and how they end, with the plays through them.

use std::time::Duration;

use bendtwin_harness::{play::Play, waiting};
use bendtwin_proto::v1::{
    DeleteShareRequest, ListSharesRequest, ShareTwinRequest,
    share_service_client::ShareServiceClient,
};
use bendtwin_server::access::{Access, TABLE};
use serde_json::{Value, json};
use tonic::Code;

use super::{
    keys::{bearer, make, revoke},
    own::Estate,
};
use crate::harness::{Server, read};

/// Longest time in which a play notices that its link has ended.
const SOON: Duration = Duration::from_secs(30);

/// What the holder of a share may call.
const ALLOWED: [&str; 10] = [
    "GET /v1/caller",
    "/bendtwin.v1.SignInService/GetCaller",
    "GET /v1/twins/{id}",
    "/bendtwin.v1.TwinService/GetTwin",
    "GET /v1/twins/{id}/geometry",
    "/bendtwin.v1.TwinService/GetTwinGeometry",
    "GET /v1/twins/{id}/surface",
    "/bendtwin.v1.TwinService/GetTwinSurface",
    "GET /v1/twins/{id}/thumbnail",
    "GET /v1/twins/{id}/play",
];
/// What it may call as well if downloads are allowed.
const DOWNLOADS: [&str; 3] = [
    "GET /v1/twins/{id}/content",
    "/bendtwin.v1.TwinService/ExportTwin",
    "GET /v1/twins/{id}/export",
];

/// Makes a share; returns its name and its key.
async fn share(server: &Server, twin: &str, key: &str, order: Value) -> (String, String) {
    let (status, made) = try_share(server, twin, key, order).await;
    assert_eq!(status, 201, "{made}");
    let text = |value: &Value| value.as_str().unwrap().to_owned();
    (text(&made["share"]["name"]), text(&made["secret_key"]))
}

async fn try_share(server: &Server, twin: &str, key: &str, order: Value) -> (u16, Value) {
    let request = server.http.post(server.url(&format!("/v1/{twin}/shares"))).bearer_auth(key);
    read(request.json(&order).send().await.unwrap()).await
}

async fn get(server: &Server, path: &str, key: &str) -> (u16, Value) {
    let request = server.http.get(server.url(&format!("/v1/{path}"))).bearer_auth(key);
    read(request.send().await.unwrap()).await
}

async fn delete(server: &Server, path: &str, key: &str) -> u16 {
    let request = server.http.delete(server.url(&format!("/v1/{path}"))).bearer_auth(key);
    request.send().await.unwrap().status().as_u16()
}

/// Connects to a play of a twin, and begins it.
async fn begin(server: &Server, twin: &str, key: &str, begin: Value) -> Play {
    let authorization = format!("Bearer {key}");
    let headers = [("authorization", authorization.as_str())];
    let mut play = Play::connect(&server.url(""), &format!("/v1/{twin}/play"), &headers).await;
    play.send(begin).await;
    play
}

async fn play(server: &Server, twin: &str, key: &str) -> Play {
    let mut play = begin(server, twin, key, json!({"type": "begin"})).await;
    play.expect_ready().await;
    play
}

/// The reason with which a play ends.
async fn end_of(play: &mut Play) -> String {
    play.closed().await;
    let last = play.replies.last().unwrap();
    assert_eq!(last["type"], "ended", "{last}");
    last["problem"]["reason"].as_str().unwrap_or_default().to_owned()
}

#[tokio::test]
async fn every_call_is_refused_but_those_to_look_and_to_play() {
    let estate = Estate::new().await;
    let server = &estate.server;
    let (_, plain) = share(server, &estate.twin, &estate.key, json!({})).await;
    let order = json!({"allow_export": true, "ttl_s": 60});
    let (_, exporting) = share(server, &estate.twin, &estate.key, order).await;
    let mut allowed = 0;
    for (name, access) in TABLE.iter() {
        if matches!(access, Access::Open | Access::Worker) {
            continue;
        }
        for (key, may_export) in [(&plain, false), (&exporting, true)] {
            let is_allowed = ALLOWED.contains(&name.as_str())
                || may_export && DOWNLOADS.contains(&name.as_str());
            let (reason, message) = estate.call(name, key).await;
            if name.starts_with("HEAD") {
                assert_eq!(reason, "NOT_OWNER", "403, {name}");
            } else {
                assert_eq!(reason != "SHARE_LIMITED", is_allowed, "{name}: {reason} {message}");
            }
            allowed += usize::from(is_allowed);
        }
    }
    assert!(allowed >= 15, "{allowed}");
    // They changed nothing.
    assert_eq!(get(server, &estate.twin, &estate.key).await.0, 200);
    assert_eq!(get(server, &estate.capture, &estate.key).await.0, 200);
}

#[tokio::test]
async fn a_share_reaches_its_twin_alone_and_sees_little_of_it() {
    let estate = Estate::new().await;
    let (server, twin) = (&estate.server, estate.twin.as_str());
    let labels = json!({"display_name": "rope", "note": "of ada's", "tags": ["secret"]});
    let patch = server.http.patch(server.url(&format!("/v1/{twin}"))).bearer_auth(&estate.key);
    assert_eq!(patch.json(&labels).send().await.unwrap().status(), 200);
    let import = server.http.post(server.url("/v1/twins")).bearer_auth(&estate.key);
    let (_, other) = read(import.body(crate::twins::twin_file()).send().await.unwrap()).await;
    let other = other["name"].as_str().unwrap();
    let (name, key) = share(server, twin, &estate.key, json!({"allow_export": true})).await;

    for path in ["", "/geometry", "/content", "/play"] {
        let (status, problem) = get(server, &format!("{other}{path}"), &key).await;
        if path == "/play" {
            // It is no WebSocket: refused before it is looked at.
            assert!(matches!(status, 403 | 426), "{problem}");
        } else {
            assert_eq!((status, &problem["reason"]), (403, &json!("SHARE_LIMITED")), "{path}");
        }
    }
    let authorization = format!("Bearer {key}");
    let headers = [("authorization", authorization.as_str())];
    let path = format!("/v1/{other}/play");
    assert_eq!(bendtwin_harness::play::refused(&server.url(""), &path, &headers).await, 403);

    let (_, seen) = get(server, twin, &key).await;
    assert_eq!((&seen["display_name"], &seen["quality"]), (&json!("rope"), &json!({})), "{seen}");
    for hidden in ["note", "tags", "owner", "capture", "fit"] {
        let value = &seen[hidden];
        assert!(value.is_null() || *value == json!("") || *value == json!([]), "{hidden}: {seen}");
    }
    let (_, caller) = get(server, "caller", &key).await;
    assert_eq!(caller["scopes"], json!(["share", "share:export"]), "{caller}");
    assert!(!caller.to_string().contains("ada"), "{caller}");

    // Captures, another session, and searches are not for it.
    for initial in [
        json!({"capture_frame": {"frame": 0}}),
        json!({"capture_frame": {"capture": estate.capture}}),
    ] {
        let order = json!({"type": "begin", "initial": initial});
        let mut refused = begin(server, twin, &key, order).await;
        assert_eq!(end_of(&mut refused).await, "SHARE_LIMITED");
    }
    assert_eq!(delete(server, &name, &key).await, 403);
}

#[tokio::test]
async fn visitors_leave_plays_to_others() {
    let estate = Estate::new().await;
    let (server, twin) = (&estate.server, estate.twin.as_str());
    let (_, first) = share(server, twin, &estate.key, json!({})).await;
    let (_, second) = share(server, twin, &estate.key, json!({})).await;
    let mut plays = Vec::new();
    for _ in 0..4 {
        plays.push(play(server, twin, &first).await);
    }
    let order = || json!({"type": "begin"});
    let mut refused = begin(server, twin, &first, order()).await;
    assert_eq!(end_of(&mut refused).await, "SHARE_FULL");
    // Half of the server's eight plays are for people with a token.
    let mut refused = begin(server, twin, &second, order()).await;
    assert_eq!(end_of(&mut refused).await, "SHARE_FULL");
    let _own = play(server, twin, &estate.key).await;
    plays.pop();
    let again = async || {
        let mut again = begin(server, twin, &second, order()).await;
        match again.next().await {
            bendtwin_harness::play::Event::Message(message) => {
                (message["type"] == "ready").then_some(())
            }
            _ => None,
        }
    };
    waiting::until("a free seat", SOON, again).await;
}

#[tokio::test]
async fn plays_end_with_their_share() {
    let estate = Estate::new().await;
    let (server, twin) = (&estate.server, estate.twin.as_str());
    let refused = async |key: &str| {
        let (status, problem) = get(server, twin, key).await;
        assert_eq!((status, &problem["reason"]), (401, &json!("SHARE_ENDED")), "{problem}");
    };
    // Revoked.
    let (name, key) = share(server, twin, &estate.key, json!({})).await;
    let mut visited = play(server, twin, &key).await;
    assert_eq!(delete(server, &name, &estate.key).await, 204);
    assert_eq!(end_of(&mut visited).await, "SHARE_ENDED");
    refused(&key).await;
    // Expired.
    let (_, key) = share(server, twin, &estate.key, json!({"ttl_s": 3})).await;
    let mut visited = play(server, twin, &key).await;
    assert_eq!(end_of(&mut visited).await, "SHARE_ENDED");
    refused(&key).await;
    // With the key that made it; a play with that key ends as well.
    let scopes = json!(["twins:write", "rollouts:run"]);
    let (bob, bobs) = make(server, json!({"display_name": "bob", "scopes": scopes})).await;
    let (_, key) = share(server, twin, &bobs, json!({})).await;
    let (mut visited, mut own) = (play(server, twin, &key).await, play(server, twin, &bobs).await);
    assert_eq!(revoke(server, &bob).await, 204);
    assert_eq!(end_of(&mut visited).await, "SHARE_ENDED");
    assert_eq!(end_of(&mut own).await, "KEY_REVOKED");
    refused(&key).await;
    // With the twin.
    let (_, key) = share(server, twin, &estate.key, json!({})).await;
    let mut visited = play(server, twin, &key).await;
    assert_eq!(delete(server, twin, &estate.key).await, 204);
    assert_eq!(end_of(&mut visited).await, "IN_TRASH");
    assert_eq!(get(server, twin, &key).await.1["reason"], "IN_TRASH");
    let (status, problem) = try_share(server, twin, &estate.key, json!({})).await;
    assert_eq!((status, &problem["reason"]), (404, &json!("IN_TRASH")), "{problem}");
}

#[tokio::test]
async fn shares_are_made_listed_and_revoked_over_both_transports() {
    let estate = Estate::new().await;
    let (server, twin) = (&estate.server, estate.twin.as_str());
    let client =
        |key: &str| ShareServiceClient::with_interceptor(server.channel.clone(), bearer(key));
    let mut shares = client(&estate.key);
    let order = ShareTwinRequest {
        twin: twin.to_owned(),
        display_name: "the board".to_owned(),
        ttl_s: 3600,
        ..ShareTwinRequest::default()
    };
    let made = shares.share_twin(order.clone()).await.unwrap().into_inner();
    let first = made.share.unwrap();
    assert_eq!((first.twin.as_str(), first.owner.as_str()), (twin, "ada"));
    let (created, expires) = (first.create_time.unwrap(), first.expire_time.unwrap());
    assert_eq!(expires.seconds - created.seconds, 3600);
    assert!(!first.allow_export && made.secret_key.starts_with("bt_"));
    assert_eq!(get(server, twin, &made.secret_key).await.0, 200);
    let (name, _) = share(server, twin, &estate.key, json!({"allow_export": true})).await;
    let list = ListSharesRequest { twin: twin.to_owned(), page_size: 1, ..Default::default() };
    let page = shares.list_shares(list.clone()).await.unwrap().into_inner();
    assert_eq!((page.shares[0].name.as_str(), page.shares[0].allow_export), (name.as_str(), true));
    let list = ListSharesRequest { page_token: page.next_page_token, ..list };
    let page = shares.list_shares(list).await.unwrap().into_inner();
    assert_eq!(page.shares[0].name, first.name);

    let request = DeleteShareRequest { name: first.name.clone() };
    shares.delete_share(request.clone()).await.unwrap();
    shares.delete_share(request).await.unwrap();
    let (_, listed) = get(server, &format!("{twin}/shares"), &estate.key).await;
    assert!(listed["shares"][1]["revoke_time"].is_string(), "{listed}");
    assert!(!listed.to_string().contains(&made.secret_key[36..]), "{listed}");
    // Administrators see them among the keys, by which a person's are revoked together.
    let token = server.handle.client_token().unwrap();
    let (_, keys) = get(server, "keys", token).await;
    assert_eq!(keys["keys"][0]["twin"], json!(twin), "{keys}");
    assert_eq!(keys["keys"][0]["name"], name.replace("shares/", "keys/"));

    // A name of a share that is a key ends nobody's key.
    let (key, text) = make(server, json!({"display_name": "a", "scopes": ["twins:read"]})).await;
    assert_eq!(delete(server, &key.replace("keys/", "shares/"), &estate.key).await, 404);
    assert_eq!(get(server, twin, &text).await.0, 200);
    // No key is made with the words of shares.
    for words in [json!(["share"]), json!(["twins:read", "share:export"])] {
        let order = json!({"display_name": "a", "scopes": words});
        let request = server.http.post(server.url("/v1/keys")).bearer_auth(token).json(&order);
        let (status, problem) = read(request.send().await.unwrap()).await;
        assert_eq!(status, 400, "{problem}");
    }

    for (field, order) in [
        ("ttl_s", ShareTwinRequest { ttl_s: 91 * 86_400, ..order.clone() }),
        ("expire_time", ShareTwinRequest { expire_time: Some(created), ..order.clone() }),
        ("display_name", ShareTwinRequest { display_name: "x".repeat(201), ..order.clone() }),
    ] {
        let refused = shares.share_twin(order).await.unwrap_err();
        assert_eq!(refused.code(), Code::InvalidArgument, "{field}");
        assert!(refused.message().starts_with(&format!("`{field}`")), "{}", refused.message());
    }
    // Those who may not play, or not change the twin, share nothing.
    for scopes in [json!(["twins:write"]), json!(["twins:read", "rollouts:run"])] {
        let (_, key) = make(server, json!({"display_name": "a", "scopes": scopes})).await;
        let refused = client(&key).share_twin(order.clone()).await.unwrap_err();
        assert_eq!(bendtwin_proto::fault::fault(&refused).reason, "SCOPE_MISSING", "{scopes}");
    }
    let scopes = json!(["twins:write", "rollouts:run:own"]);
    let (_, key) = make(server, json!({"display_name": "eve", "scopes": scopes})).await;
    let refused = client(&key).share_twin(order).await.unwrap_err();
    assert_eq!(bendtwin_proto::fault::fault(&refused).reason, "NOT_OWNER");
}

#[tokio::test]
async fn a_server_without_a_token_needs_no_shares() {
    let server = Server::start().await;
    let (_, twin) = read(
        server
            .http
            .post(server.url("/v1/twins"))
            .body(crate::twins::twin_file())
            .send()
            .await
            .unwrap(),
    )
    .await;
    let twin = twin["name"].as_str().unwrap();
    let (status, problem) = server.post(&format!("/v1/{twin}/shares"), json!({})).await;
    assert_eq!((status, &problem["reason"]), (409, &json!("SHARE_NOT_NEEDED")), "{problem}");
    let address = twin.replace("twins/", "/#/shared/");
    assert!(problem["detail"].as_str().unwrap().contains(&address), "{problem}");
}
