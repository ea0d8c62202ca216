//! Deletions that can be undone, and rules that delete.

use std::time::Duration;

use bendtwin_proto::v1::{
    DeleteTwinRequest, ListTrashedFitsRequest, UndeleteFitRequest, UndeleteTwinRequest,
    trash_service_client::TrashServiceClient,
};
use bendtwin_server::{Options, RetentionRule};
use serde_json::{Value, json};
use tonic::Code;

use crate::{
    access::keys::{locked, make},
    harness::{Server, read},
    twins::twin_file,
};

/// Longest wait for what the server does by itself.
const SOON: Duration = Duration::from_secs(20);

async fn twin(server: &Server) -> String {
    let request = server.http.post(server.url("/v1/twins?display_name=toy")).body(twin_file());
    let (status, twin) = read(request.send().await.unwrap()).await;
    assert_eq!(status, 201, "{twin}");
    twin["name"].as_str().unwrap().to_owned()
}

/// Names in the trash of a collection.
async fn trashed(server: &Server, collection: &str) -> Vec<String> {
    let (status, list) = server.get(&format!("/v1/trash/{collection}")).await;
    assert_eq!(status, 200, "{list}");
    let names = list["resources"].as_array().unwrap().iter();
    names.map(|resource| resource["name"].as_str().unwrap().to_owned()).collect()
}

/// Waits until a resource answers with this reason, or is there if that is empty.
async fn until(server: &Server, name: &str, reason: &str) -> Value {
    let reached = async {
        loop {
            let (_, found) = server.get(&format!("/v1/{name}")).await;
            if found["reason"].as_str().unwrap_or_default() == reason {
                return found;
            }
            tokio::time::sleep(Duration::from_millis(20)).await;
        }
    };
    tokio::time::timeout(SOON, reached).await.expect(reason)
}

/// Waits until no content is stored: it goes after its row.
async fn until_empty(server: &Server) {
    let emptied = async {
        while server.blob_files() > 0 {
            tokio::time::sleep(Duration::from_millis(20)).await;
        }
    };
    tokio::time::timeout(SOON, emptied).await.expect("content stays");
}

#[tokio::test]
async fn what_was_deleted_is_listed_and_restored_over_http() {
    let server = Server::start().await;
    let names = [server.capture().await, server.fit().await, twin(&server).await];
    for (name, collection) in names.iter().zip(["captures", "fits", "twins"]) {
        let path = format!("/v1/{name}");
        let (_, before) = server.get(&path).await;
        assert_eq!(server.delete(&path).await.0, 204);
        for (status, problem) in [server.get(&path).await, server.delete(&path).await] {
            assert_eq!((status, &problem["reason"]), (404, &json!("IN_TRASH")), "{problem}");
            let detail = problem["detail"].as_str().unwrap();
            assert!(detail.contains(&format!("bendtwin trash restore {name}")), "{detail}");
        }
        let (status, after) = server.post(&format!("{path}/undelete"), json!(null)).await;
        assert_eq!((status, &after["name"]), (200, &json!(name)), "{after}");
        assert_eq!(after["display_name"], before["display_name"]);
        assert_eq!(trashed(&server, collection).await, Vec::<String>::new());

        server.delete(&path).await;
        assert_eq!(trashed(&server, collection).await, [name.as_str()]);
        let (_, list) = server.get(&format!("/v1/trash/{collection}?owner=nobody")).await;
        assert_eq!(list["resources"], json!([]));
        let (_, list) = server.get(&format!("/v1/trash/{collection}")).await;
        let resource = &list["resources"][0];
        let time =
            |field: &str| -> jiff::Timestamp { resource[field].as_str().unwrap().parse().unwrap() };
        let kept = time("purge_time").duration_since(time("delete_time"));
        assert_eq!(kept.as_hours(), 7 * 24);
        assert_eq!(resource["display_name"], before["display_name"]);

        // For good.
        assert_eq!(server.purge(&path).await.0, 204);
        assert_eq!(trashed(&server, collection).await, Vec::<String>::new());
        let (status, problem) = server.post(&format!("{path}/undelete"), json!(null)).await;
        assert_eq!((status, &problem["reason"]), (404, &json!("NOT_FOUND")));
    }
}

#[tokio::test]
async fn what_was_deleted_is_listed_and_restored_over_grpc() {
    let server = Server::start().await;
    let mut trash = TrashServiceClient::new(server.channel.clone());
    let (fit, twin) = (server.fit().await, twin(&server).await);
    server.delete(&format!("/v1/{fit}")).await;
    let list = trash.list_trashed_fits(ListTrashedFitsRequest::default()).await.unwrap();
    assert_eq!(list.into_inner().resources[0].name, fit);
    let restored = trash.undelete_fit(UndeleteFitRequest { name: fit.clone() }).await.unwrap();
    let job = restored.into_inner().job.unwrap();
    assert_eq!(job.state(), bendtwin_proto::v1::job::State::Queued);

    let delete = DeleteTwinRequest { name: twin.clone(), purge: false };
    server.twins().delete_twin(delete).await.unwrap();
    // A fit cannot start from it.
    let capture = server.capture().await;
    let order = json!({"capture": capture, "settings": {"start_from": twin}});
    let (status, problem) = server.post("/v1/fits", order).await;
    assert_eq!((status, &problem["reason"]), (404, &json!("IN_TRASH")), "{problem}");
    trash.undelete_twin(UndeleteTwinRequest { name: twin.clone() }).await.unwrap();
    let delete = DeleteTwinRequest { name: twin.clone(), purge: true };
    server.twins().delete_twin(delete).await.unwrap();
    let gone = trash.undelete_twin(UndeleteTwinRequest { name: twin }).await.unwrap_err();
    assert_eq!(gone.code(), Code::NotFound);
}

#[tokio::test]
async fn without_a_trash_deletions_are_for_good() {
    let server = Server::start_with(|o| o.trash_s = 0.0).await;
    let capture = server.capture().await;
    assert_eq!(server.delete(&format!("/v1/{capture}")).await.0, 204);
    assert_eq!(server.get(&format!("/v1/{capture}")).await.1["reason"], "NOT_FOUND");
    assert_eq!(server.blob_files(), 0);
}

#[tokio::test]
async fn what_is_due_is_purged() {
    let server = Server::start_with(|o| o.trash_s = 0.2).await;
    let capture = server.capture().await;
    assert_eq!(server.delete(&format!("/v1/{capture}")).await.0, 204);
    until(&server, &capture, "NOT_FOUND").await;
    until_empty(&server).await;
}

/// Where there is less space than the floor a deletion frees its space: what was deleted first goes.
#[tokio::test]
async fn a_deletion_frees_space_where_that_is_short() {
    let server = Server::start().await;
    let (first, second) = (server.capture().await, server.capture().await);
    server.delete(&format!("/v1/{first}")).await;
    let Server { dir, handle, .. } = server;
    handle.shutdown().await;
    let server = Server::start_in(dir, |o| o.disk_floor_mib = 1 << 30).await;
    until(&server, &first, "NOT_FOUND").await;
    assert_eq!(server.delete(&format!("/v1/{second}")).await.0, 204);
    until(&server, &second, "NOT_FOUND").await;
    until_empty(&server).await;
}

#[tokio::test]
async fn the_scopes_of_a_collection_are_those_of_its_trash() {
    let server = locked().await;
    let (_, reader) = make(&server, json!({"display_name": "r", "scopes": ["fits:read"]})).await;
    let (_, writer) = make(&server, json!({"display_name": "w", "scopes": ["fits:write"]})).await;
    let call = async |method: reqwest::Method, path: &str, key: &str| {
        let request = server.http.request(method, server.url(path)).bearer_auth(key);
        request.send().await.unwrap().status().as_u16()
    };
    let undelete = "/v1/fits/0197f2a0-0000-7000-8000-000000000000/undelete";
    let (get, post) = (reqwest::Method::GET, reqwest::Method::POST);
    assert_eq!(call(get.clone(), "/v1/trash/fits", &reader).await, 200);
    assert_eq!(call(post.clone(), undelete, &reader).await, 403);
    assert_eq!(call(get.clone(), "/v1/trash/fits", &writer).await, 403);
    assert_eq!(call(post, undelete, &writer).await, 404);
    assert_eq!(call(get.clone(), "/v1/trash/captures", &reader).await, 403);
    assert_eq!(call(get, "/v1/retention", &writer).await, 403);
}

fn rule(tag: &str) -> RetentionRule {
    RetentionRule {
        display_name: format!("tagged {tag}"),
        collection: "captures".to_owned(),
        tag: tag.to_owned(),
        ..RetentionRule::default()
    }
}

/// A capture that was read, with tags.
async fn tagged(server: &Server, tags: &[&str]) -> String {
    let capture = server.capture().await;
    server.post(&format!("/v1/{capture}/ingest/cancel"), json!(null)).await;
    let request = server.http.patch(server.url(&format!("/v1/{capture}")));
    assert_eq!(read(request.json(&json!({"tags": tags})).send().await.unwrap()).await.0, 200);
    capture
}

#[tokio::test]
async fn rules_of_the_configuration_and_of_the_api_delete() {
    let configure = |options: &mut Options, interval_s: f64| {
        options.retention = vec![rule("scratch")];
        options.retention_interval_s = interval_s;
    };
    // Longer than the test: this server only previews.
    let server = Server::start_with(|o| configure(o, 86_400.0)).await;
    let scratch = tagged(&server, &["scratch"]).await;
    let kept = tagged(&server, &["scratch", "keep"]).await;
    let trial = tagged(&server, &["trial"]).await;
    let other = tagged(&server, &[]).await;
    let order = json!({
        "display_name": "tagged trial", "collection": "captures", "min_age_days": 0, "tag": "trial",
    });
    let (status, made) = server.post("/v1/retention", order).await;
    assert_eq!(status, 201, "{made}");
    let made_path = format!("/v1/{}", made["name"].as_str().unwrap());
    assert_eq!(server.get(&made_path).await, (200, made.clone()));
    let (_, list) = server.get("/v1/retention").await;
    assert_eq!(list["rules"][0]["display_name"], "tagged scratch");
    assert_eq!((&list["rules"][0]["name"], &list["rules"][1]), (&json!(null), &made));

    let (status, preview) = server.get("/v1/retention-preview").await;
    assert_eq!((status, &preview["truncated"]), (200, &json!(false)), "{preview}");
    let outcome = |outcome: &Value| {
        let field = |name: &str| outcome[name].as_str().unwrap().to_owned();
        (field("name"), field("rule"), field("kept_because"))
    };
    let outcomes: Vec<_> = preview["outcomes"].as_array().unwrap().iter().map(outcome).collect();
    let expected = [
        (scratch.clone(), "tagged scratch", ""),
        (kept.clone(), "tagged scratch", "it has the tag `keep`"),
        (trial.clone(), "tagged trial", ""),
    ];
    assert_eq!(outcomes, expected.map(|(n, r, k)| (n, r.to_owned(), k.to_owned())));
    assert_eq!(server.get(&format!("/v1/{scratch}")).await.0, 200, "a preview changes nothing");

    let Server { dir, handle, .. } = server;
    handle.shutdown().await;
    let server = Server::start_in(dir, |o| configure(o, 1.0)).await;
    until(&server, &scratch, "IN_TRASH").await;
    until(&server, &trial, "IN_TRASH").await;
    for there in [&kept, &other] {
        assert_eq!(server.get(&format!("/v1/{there}")).await.0, 200);
    }
    let (_, list) = server.get("/v1/trash/captures").await;
    let mut by: Vec<_> =
        list["resources"].as_array().unwrap().iter().map(|r| r["deleted_by"].clone()).collect();
    by.sort_by_key(ToString::to_string);
    assert_eq!(by, ["retention: tagged scratch", "retention: tagged trial"]);
    assert_eq!(server.delete(&made_path).await.0, 204);
    assert_eq!(server.get(&made_path).await.0, 404);
}

#[tokio::test]
async fn what_is_no_rule_is_refused() {
    let server = Server::start().await;
    let good = json!({"display_name": "old", "collection": "captures", "min_age_days": 30});
    for (field, value) in [
        ("display_name", json!(" ")),
        ("display_name", json!("x".repeat(201))),
        ("collection", json!("workers")),
        ("min_age_days", json!(-1)),
        ("min_age_days", json!(1e9)),
        ("tag", json!("x".repeat(51))),
        ("owner", json!("a\nb")),
    ] {
        let mut order = good.clone();
        order[field] = value;
        let (status, problem) = server.post("/v1/retention", order).await;
        assert_eq!((status, &problem["reason"]), (400, &json!("INVALID_FIELD")), "{problem}");
        assert!(problem["detail"].as_str().unwrap().contains(field), "{problem}");
    }
    let order = json!({
        "display_name": "old", "collection": "fits", "min_age_days": 30, "verdict": "good",
    });
    assert_eq!(server.post("/v1/retention", order).await.0, 400);
    let options = Options {
        retention: vec![RetentionRule { collection: "workers".to_owned(), ..rule("x") }],
        ..Options::default()
    };
    let faults = options.validate().unwrap_err();
    assert!(faults[0].starts_with("retention[0].collection is `workers`"), "{faults:?}");
}
