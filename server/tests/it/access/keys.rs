//! Keys: made, shown, revoked; and every route and every RPC with keys that may and may not.

use std::{collections::BTreeMap, time::Duration};

use bendtwin_proto::v1::{
    CreateKeyRequest, DeleteKeyRequest, GetKeyRequest, KeyQuotas, ListKeysRequest,
    key_service_client::KeyServiceClient,
};
use bendtwin_server::{
    ClientTokenPolicy,
    access::{Access, Scope, TABLE},
};
use serde_json::{Value, json};
use tonic::Code;

use crate::harness::{Server, read};

pub(crate) async fn locked() -> Server {
    Server::start_with(|o| o.client_token = ClientTokenPolicy::Required).await
}

/// Makes a key with the client token; returns its name and its text.
pub(crate) async fn make(server: &Server, order: Value) -> (String, String) {
    let token = server.handle.client_token().unwrap();
    let request = server.http.post(server.url("/v1/keys")).bearer_auth(token).json(&order);
    let (status, made) = read(request.send().await.unwrap()).await;
    assert_eq!(status, 201, "{made}");
    let text = |value: &Value| value.as_str().unwrap().to_owned();
    (text(&made["key"]["name"]), text(&made["secret_key"]))
}

pub(crate) async fn revoke(server: &Server, name: &str) -> u16 {
    let token = server.handle.client_token().unwrap();
    let request = server.http.delete(server.url(&format!("/v1/{name}"))).bearer_auth(token);
    request.send().await.unwrap().status().as_u16()
}

fn words(scopes: impl IntoIterator<Item = Scope>) -> Vec<&'static str> {
    scopes.into_iter().map(Scope::as_str).collect()
}

/// Calls a route or an RPC. Returns the reason and the message of an immediate refusal, if any.
async fn call(server: &Server, name: &str, key: Option<&str>) -> Option<(String, String)> {
    const ID: &str = "0197f2a0-0000-7000-8000-000000000000";
    let request = match name.split_once(' ') {
        Some((method, path)) => {
            let path = path.replace("{id}", ID).replace("{file}", "none.js");
            let path = path.replace("{kind}", "masks");
            let method = reqwest::Method::from_bytes(method.as_bytes()).unwrap();
            server.http.request(method, server.url(&path)).header("tus-resumable", "1.0.0")
        }
        None => {
            let request = server.http.post(server.url(name)).body("\0\0\0\0\0");
            request.header("content-type", "application/grpc").header("te", "trailers")
        }
    };
    let request = key.into_iter().fold(request, |request, key| request.bearer_auth(key));
    let response = request.send().await.unwrap();
    if !name.contains(' ') {
        // A refusal has its status in the headers.
        let status = tonic::Status::from_header_map(response.headers())?;
        return Some((bendtwin_proto::fault::fault(&status).reason, status.message().to_owned()));
    }
    let status = response.status().as_u16();
    if name.starts_with("HEAD") {
        // Without a body, only the status is known.
        let reason = match status {
            401 => "401",
            403 => "SCOPE_MISSING",
            _ => return None,
        };
        return Some((reason.to_owned(), String::new()));
    }
    if response.status().is_success() {
        return None;
    }
    let (_, problem) = read(response).await;
    let text = |field: &str| problem[field].as_str().unwrap_or_default().to_owned();
    Some((text("reason"), text("detail")))
}

/// Every entry of the table, with no key, one of all other scopes, a revoked and an expired one of
/// all scopes, one of the right scope alone, and one for the metrics.
#[tokio::test]
async fn every_route_and_rpc_takes_what_the_table_says() {
    const REFUSALS: [&str; 6] = [
        "BAD_CLIENT_TOKEN",
        "KEY_REVOKED",
        "KEY_EXPIRED",
        "SCOPE_MISSING",
        "BAD_WORKER_TOKEN",
        "401",
    ];
    let server = locked().await;
    let all = words(Scope::ALL);
    let (name, revoked) = make(&server, json!({"display_name": "revoked", "scopes": all})).await;
    assert_eq!(revoke(&server, &name).await, 204);
    let end = jiff::Timestamp::now() + Duration::from_secs(3);
    let order = json!({"display_name": "old", "scopes": all, "expire_time": end.to_string()});
    let (_, expired) = make(&server, order).await;
    while jiff::Timestamp::now() <= end {
        tokio::time::sleep(Duration::from_millis(20)).await;
    }
    let mut right = BTreeMap::new();
    let mut wrong = BTreeMap::new();
    for scope in Scope::ALL {
        let order = json!({"display_name": "right", "scopes": words([scope])});
        right.insert(scope, make(&server, order).await.1);
        let others = words(Scope::ALL.into_iter().filter(|other| *other != scope));
        let order = json!({"display_name": "wrong", "scopes": others});
        wrong.insert(scope, make(&server, order).await.1);
    }
    let mut compared = 0;
    for (name, access) in TABLE.iter() {
        let scope = match access {
            Access::Scope(scope) => *scope,
            _ => Scope::TwinsRead,
        };
        let cases = [
            ("no key", None, "BAD_CLIENT_TOKEN"),
            ("wrong scope", Some(&wrong[&scope]), "SCOPE_MISSING"),
            ("revoked", Some(&revoked), "KEY_REVOKED"),
            ("expired", Some(&expired), "KEY_EXPIRED"),
            ("right", Some(&right[&scope]), ""),
            ("metrics", Some(&right[&Scope::MetricsRead]), "SCOPE_MISSING"),
        ];
        for (case, key, refusal) in cases {
            let expected = match access {
                Access::Open => "",
                Access::Worker => "BAD_WORKER_TOKEN",
                Access::Anyone if case == "wrong scope" => "",
                // It is a part of every other scope.
                Access::Scope(Scope::MetricsRead) if refusal == "SCOPE_MISSING" => "",
                _ => refusal,
            };
            let refused = call(&server, name, key.map(String::as_str)).await;
            let (reason, message) =
                refused.filter(|(r, _)| REFUSALS.contains(&r.as_str())).unwrap_or_default();
            let is_head =
                name.starts_with("HEAD") && reason == "401" && expected != "SCOPE_MISSING";
            assert!(
                reason == expected || is_head && !expected.is_empty(),
                "{name}, {case}: {reason}"
            );
            if reason == "SCOPE_MISSING" && !message.is_empty() {
                let named = match access {
                    Access::Anyone => Scope::MetricsRead,
                    _ => scope,
                };
                assert!(message.contains(named.as_str()), "{name}: {message}");
            }
            for key in [Some(&revoked), Some(&expired), key].into_iter().flatten() {
                assert!(!message.contains(key.as_str()), "{name}: {message}");
            }
            compared += 1;
        }
    }
    assert_eq!(compared, 6 * TABLE.len());
}

#[tokio::test]
async fn keys_are_made_listed_and_revoked_over_both_transports() {
    let server = locked().await;
    let token = server.handle.client_token().unwrap().to_owned();
    let mut keys = KeyServiceClient::with_interceptor(server.channel.clone(), bearer(&token));
    let order = CreateKeyRequest {
        display_name: "lab robot".to_owned(),
        scopes: vec!["twins:read".to_owned(), "rollouts:run".to_owned()],
        quotas: Some(KeyQuotas { rollouts: Some(2), ..KeyQuotas::default() }),
        ..CreateKeyRequest::default()
    };
    let made = keys.create_key(order.clone()).await.unwrap().into_inner();
    let key = made.key.unwrap();
    assert_eq!(
        (key.owner.as_str(), key.scopes),
        ("lab robot", vec!["rollouts:run".to_owned(), "twins:read".to_owned()])
    );
    assert!(made.secret_key.starts_with("bt_"), "{}", made.secret_key.len());
    assert_eq!(key.quotas.unwrap().rollouts, Some(2));
    let with = |key: &str| server.http.get(server.url("/v1/twins")).bearer_auth(key).send();
    assert_eq!(with(&made.secret_key).await.unwrap().status(), 200);
    // As a password, too, and never without its last letter.
    let basic = server.http.get(server.url("/v1/twins")).basic_auth("x", Some(&made.secret_key));
    assert_eq!(basic.send().await.unwrap().status(), 200);
    let (_, problem) = read(with(&made.secret_key[..90]).await.unwrap()).await;
    assert_eq!(problem["reason"], "BAD_CLIENT_TOKEN");
    assert!(problem["detail"].as_str().unwrap().contains("mistyped"), "{problem}");

    let listed = keys.list_keys(ListKeysRequest::default()).await.unwrap().into_inner();
    assert_eq!(listed.keys.iter().map(|k| &k.name).collect::<Vec<_>>(), [&key.name]);
    let (_, document) =
        read(server.http.get(server.url("/v1/keys")).bearer_auth(&token).send().await.unwrap())
            .await;
    assert_eq!(document["keys"][0]["name"], key.name);
    assert!(!document.to_string().contains(&made.secret_key[36..]), "{document}");

    let name = key.name.clone();
    keys.delete_key(DeleteKeyRequest { name: name.clone() }).await.unwrap();
    let (_, problem) = read(with(&made.secret_key).await.unwrap()).await;
    assert_eq!(problem["reason"], "KEY_REVOKED");
    let got = keys.get_key(GetKeyRequest { name }).await.unwrap().into_inner();
    assert!(got.revoke_time.is_some());
    // A second time changes nothing.
    assert_eq!(revoke(&server, &got.name).await, 204);

    for (field, order) in [
        ("display_name", CreateKeyRequest { display_name: " ".to_owned(), ..order.clone() }),
        ("scopes", CreateKeyRequest { scopes: Vec::new(), ..order.clone() }),
        ("scopes", CreateKeyRequest { scopes: vec!["all".to_owned()], ..order.clone() }),
        ("owner", CreateKeyRequest { owner: "a\nb".to_owned(), ..order.clone() }),
        (
            "expire_time",
            CreateKeyRequest { expire_time: Some(prost_types::Timestamp::default()), ..order },
        ),
    ] {
        let refused = keys.create_key(order).await.unwrap_err();
        assert_eq!(refused.code(), Code::InvalidArgument, "{field}");
        assert!(refused.message().starts_with(&format!("`{field}`")), "{}", refused.message());
    }
}

#[tokio::test]
async fn a_key_is_as_good_after_a_restart_and_its_use_is_recorded() {
    let server = locked().await;
    let order = json!({"display_name": "a", "scopes": ["twins:read", "admin"]});
    let (name, key) = make(&server, order).await;
    assert_eq!(
        server.http.get(server.url("/v1/twins")).bearer_auth(&key).send().await.unwrap().status(),
        200
    );
    let Server { dir, handle, .. } = server;
    handle.shutdown().await;
    let again = Server::start_in(dir, |o| o.client_token = ClientTokenPolicy::Required).await;
    let request = again.http.get(again.url(&format!("/v1/{name}"))).bearer_auth(&key);
    let (status, document) = read(request.send().await.unwrap()).await;
    assert_eq!(status, 200, "{document}");
    assert!(document["last_use_time"].is_string(), "{document}");
}

/// An interceptor that shows a key.
pub(crate) fn bearer(
    key: &str,
) -> impl FnMut(tonic::Request<()>) -> Result<tonic::Request<()>, tonic::Status> + Clone + use<> {
    let value: tonic::metadata::AsciiMetadataValue = format!("Bearer {key}").parse().unwrap();
    move |mut request| {
        request.metadata_mut().insert("authorization", value.clone());
        Ok(request)
    }
}
