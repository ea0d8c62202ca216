//! The routing to sessions, which live at workers and are listed in heartbeats.

use bendtwin_proto::worker::v1::{HeartbeatRequest, HeldSession};
use serde_json::{Value, json};

use super::rollouts::twin;
use crate::{harness::Server, worker::Worker};

#[tokio::test]
async fn a_session_is_found_despite_an_older_heartbeat() {
    let server = Server::start().await;
    let mut worker = Worker::register(&server).await;
    let twin = twin(&server, &mut worker).await;
    let (status, session) = server.post("/v1/sessions", json!({"twin": twin, "slots": 3})).await;
    assert_eq!((status, &session["slots"]), (201, &json!(3)), "{session}");
    // It was on its way when the session was opened, and does not know of it.
    worker.heartbeat().await.unwrap();
    let path = format!("/v1/{}", session["name"].as_str().unwrap());
    let (status, found) = server.get(&path).await;
    assert_eq!((status, &found["name"]), (200, &session["name"]), "{found}");
}

#[tokio::test]
async fn a_session_that_no_worker_has_is_lost() {
    let server = Server::start().await;
    let _worker = Worker::register(&server).await;
    let path = "/v1/sessions/0190a000-0000-7000-8000-00000000dead";
    let (status, problem) = server.get(path).await;
    assert_eq!((status, &problem["reason"]), (409, &json!("SESSION_LOST")));
    assert_eq!(server.delete(path).await.0, 204);
    let (status, problem) = server.get("/v1/sessions/none").await;
    assert_eq!(status, 400, "{problem}");
}

#[tokio::test]
async fn costs_in_a_session_see_its_world_and_grasps() {
    let server = Server::start().await;
    let mut worker = Worker::register(&server).await;
    let twin = twin(&server, &mut worker).await;
    let world = json!({"colliders": [{"sphere": {"radius_m": 0.1}}]});
    let grasps = json!([{"sphere": {"radius_m": 0.1}}]);
    let path = |twin: &str| format!("/v1/{twin}/rollouts");
    let open = json!({"twin": twin, "world": world, "grasps": grasps});
    let (status, session) = server.post("/v1/sessions", open).await;
    assert_eq!(status, 201, "{session}");
    let costs = json!([
        {"clearance": {"collider": 0, "margin_m": 0.01}},
        {"force": {"collider": 0, "limit_n": 1.0}},
        {"force": {"grasp": 0, "limit_n": 1.0}},
    ]);
    let initial = json!({"session": {"session": session["name"]}});
    let rollout = |initial: &Value, world: Value| {
        let still = json!({"positions": [[[[0.5, 0, 0]], [[0.5, 0, 0]]]]});
        let mut rollout = json!({"trajectories": still, "costs": costs, "initial": initial});
        if !world.is_null() {
            rollout["world"] = world;
        }
        rollout
    };
    let inside = rollout(&initial, Value::Null);
    let (status, reply) = server.post(&path(&twin), inside.clone()).await;
    assert_eq!(status, 200, "{reply}");
    let plan = json!({"rollout": inside, "samples": 4});
    let plan = server.http.post(server.url("/v1/plans")).json(&plan).send().await.unwrap();
    assert_eq!(plan.status(), 200);
    assert!(plan.text().await.unwrap().contains("event: update"));
    // Outside of it, or in another world, there is no such collider.
    for (initial, world) in [(json!({"rest": {}}), Value::Null), (initial, json!({}))] {
        let (status, problem) = server.post(&path(&twin), rollout(&initial, world)).await;
        let detail = problem["detail"].as_str().unwrap();
        assert_eq!(status, 400, "{problem}");
        assert!(detail.contains("`costs[0].clearance.collider` names collider 0"), "{detail}");
    }
    // A server that learns of the session by a heartbeat knows them, too.
    let held = HeldSession {
        session: "sessions/0190a000-0000-7000-8000-00000000beef".to_owned(),
        twin: twin.clone(),
        slots: 1,
        grasps: 1,
        colliders: 1,
        owner: "local".to_owned(),
    };
    let initial = json!({"session": {"session": held.session}});
    let heartbeat = HeartbeatRequest {
        worker: worker.id.to_string(),
        sessions: vec![held],
        ..HeartbeatRequest::default()
    };
    worker.link.heartbeat(heartbeat).await.unwrap();
    let (status, reply) = server.post(&path(&twin), rollout(&initial, Value::Null)).await;
    assert_eq!(status, 200, "{reply}");
}
