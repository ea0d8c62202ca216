//! Pictures of sessions: over both transports, with the faults of the check, and of no one else's session.

use bendtwin_contract::{picture::check_pictures, rollout::Limits};
use bendtwin_contract_kit::picture as cases;
use bendtwin_core::Problem as _;
use bendtwin_proto::{
    fault::fault,
    v1::{RenderSessionRequest, RenderedSession, session_service_client::SessionServiceClient},
};
use prost::Message as _;
use serde_json::json;

use super::rollouts::twin;
use crate::{harness::Server, worker::Worker};

/// A server with a session of three slots; its name.
async fn with_session() -> (Server, Worker, String) {
    let server = Server::start().await;
    let mut worker = Worker::register(&server).await;
    let twin = twin(&server, &mut worker).await;
    let (status, session) = server.post("/v1/sessions", json!({"twin": twin, "slots": 3})).await;
    assert_eq!(status, 201, "{session}");
    (server, worker, session["name"].as_str().unwrap().to_owned())
}

#[tokio::test]
async fn malformed_pictures_get_the_fault_of_the_check() {
    let (server, _worker, name) = with_session().await;
    let mut client = SessionServiceClient::new(server.channel.clone());
    let sound = RenderSessionRequest { name: name.clone(), slots: vec![2, 0], ..cases::sound() };
    let reply = client.render_session(sound).await.unwrap().into_inner();
    assert_eq!(reply.cameras[0].colors.as_ref().unwrap().shape, [2, 12, 16, 3]);
    for case in cases::malformed() {
        let request = RenderSessionRequest { name: name.clone(), ..case.request };
        let expected = check_pictures(&request, 3, &Limits::default()).unwrap_err();
        let status = client.render_session(request).await.unwrap_err();
        if status.message().contains("which are possible: leave some out") {
            // Counted before they are decoded.
            assert!(status.message().contains(case.names), "{}: {status:?}", case.what);
            continue;
        }
        assert_eq!(fault(&status), expected.fault(), "{}", case.what);
    }
    let gone = "sessions/0190a000-0000-7000-8000-00000000dead".to_owned();
    let status = client.render_session(RenderSessionRequest { name: gone, ..cases::sound() }).await;
    assert_eq!(fault(&status.unwrap_err()).reason, "SESSION_LOST");
}

#[tokio::test]
async fn http_takes_and_gives_json_and_protobuf() {
    let (server, _worker, name) = with_session().await;
    let path = format!("/v1/{name}/render");
    let camera = json!({"width": 9, "height": 8, "intrinsics": [8, 8, 4, 3.5], "pose": [0, 0, 0, 0, 0, 0, 1],
        "background": [200, 210, 220]});
    let prop = json!({"cuboid": {"low": [0, 0, 0], "high": [1, 1, 1]}, "color": [[1, 2, 3]]});
    let body = json!({"slots": [1], "cameras": [camera], "props": [prop], "look": "SURFACE"});
    let (status, reply) = server.post(&path, body.clone()).await;
    assert_eq!(status, 200, "{reply}");
    assert_eq!(reply["cameras"][0]["colors"][0][7][8], json!([0, 0, 0]));

    let mut wrong = body.clone();
    wrong["cameras"][0]["background"] = json!([200, 210, 256]);
    let (status, problem) = server.post(&path, wrong).await;
    assert_eq!(status, 400);
    assert!(problem["detail"].as_str().unwrap().contains("no byte"), "{problem}");
    let mut wrong = body;
    wrong["cameras"][0]["width"] = json!(3);
    let (status, problem) = server.post(&path, wrong).await;
    assert_eq!((status, &problem["reason"]), (400, &json!("INVALID_PICTURE")));

    let call = server.http.post(server.url(&path)).header("content-type", "application/x-protobuf");
    let sound = RenderSessionRequest { slots: vec![0, 1], ..cases::sound() };
    let response = call.body(sound.encode_to_vec()).send().await.unwrap();
    let reply = RenderedSession::decode(response.bytes().await.unwrap()).unwrap();
    assert_eq!(reply.cameras[0].colors.as_ref().unwrap().shape, [2, 12, 16, 3]);
}
