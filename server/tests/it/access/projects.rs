//! Projects: made and changed over both transports, seen by their members, and what members share.

use std::time::Duration;

use bendtwin_harness::{postgres::Postgres, waiting};
use bendtwin_proto::v1::{
    GetProjectRequest, ListProjectsRequest, project_service_client::ProjectServiceClient,
};
use bendtwin_server::ClientTokenPolicy;
use bendtwin_store::DatabaseUrl;
use serde_json::{Value, json};

use super::{
    keys::{bearer, locked, make},
    own::{Estate, bound},
};
use crate::harness::{Server, read};

async fn send(server: &Server, call: &str, key: &str, body: Value) -> (u16, Value) {
    let (method, path) = call.split_once(' ').unwrap();
    let method = reqwest::Method::from_bytes(method.as_bytes()).unwrap();
    let request = server.http.request(method, server.url(path)).bearer_auth(key);
    let request = if body.is_null() { request } else { request.json(&body) };
    read(request.send().await.unwrap()).await
}

#[tokio::test]
async fn projects_are_made_changed_and_seen_by_their_members() {
    let server = locked().await;
    let token = server.handle.client_token().unwrap().to_owned();
    let (_, bob) = make(&server, json!({"display_name": "bob", "scopes": ["twins:read"]})).await;
    let order = json!({"display_name": "ropes", "members": ["eve", "ada", "eve"]});
    let (status, made) = send(&server, "POST /v1/projects", &token, order.clone()).await;
    assert_eq!((status, &made["members"]), (201, &json!(["ada", "eve"])), "{made}");
    let name = made["name"].as_str().unwrap().to_owned();
    let path = format!("/v1/{name}");
    // Only the scope admin changes projects; others see their own.
    for (call, body) in [
        ("POST /v1/projects", order),
        (&*format!("PATCH {path}"), json!({"add_members": ["bob"]})),
        (&*format!("DELETE {path}"), Value::Null),
    ] {
        let (status, problem) = send(&server, call, &bob, body).await;
        assert_eq!((status, &problem["reason"]), (403, &json!("SCOPE_MISSING")), "{call}");
    }
    let (status, problem) = send(&server, &format!("GET {path}"), &bob, Value::Null).await;
    assert_eq!((status, &problem["reason"]), (403, &json!("NOT_MEMBER")), "{problem}");
    let (_, list) = send(&server, "GET /v1/projects", &bob, Value::Null).await;
    assert_eq!(list["projects"], json!([]));

    let change =
        json!({"display_name": "all ropes", "add_members": ["bob"], "remove_members": ["eve"]});
    let (status, changed) = send(&server, &format!("PATCH {path}"), &token, change).await;
    assert_eq!((status, &changed["members"]), (200, &json!(["ada", "bob"])), "{changed}");
    assert_eq!(changed["display_name"], "all ropes");
    let mut projects = ProjectServiceClient::with_interceptor(server.channel.clone(), bearer(&bob));
    let listed = projects.list_projects(ListProjectsRequest::default()).await.unwrap();
    assert_eq!(listed.into_inner().projects[0].members, ["ada", "bob"]);
    let got = projects.get_project(GetProjectRequest { name }).await.unwrap().into_inner();
    assert_eq!(got.display_name, "all ropes");

    for (field, body) in [
        ("display_name", json!({"display_name": " "})),
        ("members", json!({"display_name": "a", "members": [""]})),
        ("members", json!({"display_name": "a", "members": ["a\nb"]})),
        ("members", json!({"display_name": "a", "members": vec!["a"; 201]})),
    ] {
        let (status, problem) = send(&server, "POST /v1/projects", &token, body).await;
        let detail = problem["detail"].as_str().unwrap();
        assert!(status == 400 && detail.starts_with(&format!("`{field}`")), "{problem}");
    }
    let body = json!({"members": ["x"], "add_members": ["y"]});
    assert_eq!(send(&server, &format!("PATCH {path}"), &token, body).await.0, 400);
    let body = json!({"members": ["x"]});
    let (_, changed) = send(&server, &format!("PATCH {path}"), &token, body).await;
    assert_eq!(changed["members"], json!(["x"]));
    assert_eq!(send(&server, &format!("DELETE {path}"), &token, Value::Null).await.0, 204);
    assert_eq!(send(&server, &format!("GET {path}"), &token, Value::Null).await.0, 404);
}

#[tokio::test]
async fn members_share_and_who_has_left_does_not() {
    let estate = Estate::new().await;
    let server = &estate.server;
    let token = server.handle.client_token().unwrap().to_owned();
    let (_, bob) = make(server, json!({"display_name": "bob", "scopes": bound()})).await;
    let (capture, twin) = (estate.capture.as_str(), estate.twin.as_str());
    let seen = async || {
        let (status, _) = send(server, &format!("GET /v1/{capture}"), &bob, Value::Null).await;
        let (_, list) = send(server, "GET /v1/captures", &bob, Value::Null).await;
        (status, list["captures"].as_array().unwrap().len())
    };
    let open = async || {
        let (status, session) =
            send(server, "POST /v1/sessions", &bob, json!({"twin": twin})).await;
        (status, session["name"].as_str().unwrap_or_default().to_owned())
    };
    assert_eq!((seen().await, open().await.0), ((403, 0), 403));
    let order = json!({"display_name": "ropes", "members": ["ada", "bob"]});
    let (_, project) = send(server, "POST /v1/projects", &token, order).await;
    let project = format!("/v1/{}", project["name"].as_str().unwrap());
    assert_eq!(seen().await, (200, 1));
    let (status, session) = open().await;
    assert_eq!(status, 201);
    let session = format!("GET /v1/{session}");
    assert_eq!(send(server, &session, &bob, Value::Null).await.0, 200);
    // A change, by one who shares.
    let note = json!({"note": "of both"});
    let (status, changed) = send(server, &format!("PATCH /v1/{capture}"), &bob, note).await;
    assert_eq!((status, &changed["owner"]), (200, &json!("ada")), "{changed}");
    // Others do not share it.
    let (_, eve) = make(server, json!({"display_name": "eve", "scopes": bound()})).await;
    let get = format!("GET /v1/{capture}");
    assert_eq!(send(server, &get, &eve, Value::Null).await.0, 403);

    let remove = json!({"remove_members": ["bob"]});
    assert_eq!(send(server, &format!("PATCH {project}"), &token, remove).await.0, 200);
    assert_eq!(seen().await, (403, 0));
    // The session is bob's, the twin in it no more.
    let (status, problem) = send(server, &session, &bob, Value::Null).await;
    assert_eq!((status, &problem["reason"]), (403, &json!("NOT_OWNER")), "{problem}");
    let add = json!({"add_members": ["bob"]});
    assert_eq!(send(server, &format!("PATCH {project}"), &token, add).await.0, 200);
    assert_eq!(seen().await, (200, 1));
    assert_eq!(send(server, &format!("DELETE {project}"), &token, Value::Null).await.0, 204);
    assert_eq!(seen().await, (403, 0));
}

/// A server follows a change that another one made, within the bound on its knowledge of keys.
#[tokio::test]
async fn another_server_follows_a_change() {
    const BOUND: Duration = Duration::from_secs(30);
    let Some(postgres) = Postgres::start_or_skip().await else { return };
    let url = DatabaseUrl::parse(&postgres.url_with_password("any")).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let start = || {
        Server::start_with(|o| {
            o.client_token = ClientTokenPolicy::Required;
            o.database_url = Some(url.clone());
            o.data_dir = folder.path().join("data");
        })
    };
    let (first, second) = (start().await, start().await);
    let token = first.handle.client_token().unwrap().to_owned();
    let (_, ada) = make(&first, json!({"display_name": "ada", "scopes": bound()})).await;
    let (_, eve) = make(&first, json!({"display_name": "eve", "scopes": bound()})).await;
    let upload = first.http.post(first.url("/v1/captures")).bearer_auth(&ada).body("hers");
    let (_, capture) = read(upload.send().await.unwrap()).await;
    let get = format!("GET /v1/{}", capture["name"].as_str().unwrap());
    let status = async |server: &Server| send(server, &get, &eve, Value::Null).await.0;
    assert_eq!((status(&first).await, status(&second).await), (403, 403));
    let order = json!({"display_name": "ropes", "members": ["ada", "eve"]});
    let (_, project) = send(&first, "POST /v1/projects", &token, order).await;
    assert_eq!(status(&first).await, 200);
    let follows = async |expected: u16| {
        let probe = async || (status(&second).await == expected).then_some(());
        waiting::until("the other server to follow", BOUND, probe).await;
    };
    follows(200).await;
    let delete = format!("DELETE /v1/{}", project["name"].as_str().unwrap());
    assert_eq!(send(&first, &delete, &token, Value::Null).await.0, 204);
    assert_eq!(status(&first).await, 403);
    follows(403).await;
}
