use std::sync::Arc;

use bendtwin_contract::{registration::check_registration, rollout::Limits};
use bendtwin_contract_kit::registration as cases;
use bendtwin_core::Problem as _;
use bendtwin_proto::{
    fault::fault,
    v1::{
        Collider, CorrectOptions, CorrectSessionRequest, CorrectedSession, Observation,
        RegisterStateRequest, RegisteredState, Tensor, World, observation::Tracks,
        registration_service_client::RegistrationServiceClient,
        session_service_client::SessionServiceClient,
    },
    worker::v1::HeartbeatRequest,
};
use prost::Message as _;
use serde_json::json;
use tokio::sync::Notify;
use tonic::{Code, transport::Channel};

use super::rollouts::{TWIN, twin};
use crate::{
    harness::{Server, read},
    worker::{Device, Worker},
};

fn registrations(server: &Server) -> RegistrationServiceClient<Channel> {
    RegistrationServiceClient::new(server.channel.clone())
}

fn request(twin: &str) -> RegisterStateRequest {
    RegisterStateRequest { twin: twin.to_owned(), ..cases::sound() }
}

fn positions(registered: &RegisteredState) -> Vec<[f32; 3]> {
    let positions = registered.state.as_ref().unwrap().positions.as_ref().unwrap();
    positions.unpack_points("positions").unwrap().1
}

#[tokio::test]
async fn a_malformed_observation_gets_the_fault_of_the_check() {
    let server = Server::start().await;
    let mut worker = Worker::register(&server).await;
    let twin = twin(&server, &mut worker).await;
    let mut client = registrations(&server);
    let found = client.register_state(request(&twin)).await.unwrap().into_inner();
    assert_eq!(positions(&found), [[0.1; 3]; 2]);
    for case in cases::malformed(&TWIN) {
        let request = RegisterStateRequest { twin: twin.clone(), ..case.request };
        let expected = check_registration(&request, &TWIN, &Limits::default()).unwrap_err();
        let status = client.register_state(request).await.unwrap_err();
        assert_eq!(fault(&status), expected.fault(), "{}", case.what);
    }
    // Checked before it is decoded: two bytes of a shape would become eight each.
    let endless = Tensor { shape: vec![1; 5000], ..Tensor::default() };
    let observation = Some(Observation { points: Some(endless), ..Observation::default() });
    let endless = RegisterStateRequest { observation, ..request(&twin) };
    let status = client.register_state(endless).await.unwrap_err();
    assert!(status.message().contains("dimensions"), "{status:?}");
    let nameless = client.register_state(request("twins/x")).await.unwrap_err();
    assert_eq!(nameless.code(), Code::InvalidArgument);
}

#[tokio::test]
async fn http_takes_and_gives_json_and_protobuf() {
    let server = Server::start().await;
    let mut worker = Worker::register(&server).await;
    let twin = twin(&server, &mut worker).await;
    let path = format!("/v1/{twin}/register");
    let body = json!({"observation": {"points": [[0, 0, 1], [0.5, 0, 2]], "nodes": [0, 4]},
        "options": {"noise_m": 0.002, "settle_frames": 0}});
    let (status, reply) = server.post(&path, body.clone()).await;
    assert_eq!(status, 200, "{reply}");
    assert_eq!(reply["state"]["positions"], json!([[0.0, 0.0, 1.0], [0.5, 0.0, 2.0]]));
    assert_eq!(reply["worker"], json!(worker.id.to_string()));

    let (status, problem) = server.post(&path, json!({"observation": {"points": [[0, 1]]}})).await;
    assert_eq!((status, &problem["reason"]), (400, &json!("INVALID_OBSERVATION")));
    let other = json!({"twin": "twins/x", "observation": {}});
    let (status, problem) = server.post(&path, other).await;
    assert_eq!((status, &problem["reason"]), (400, &json!("INVALID_FIELD")));

    let call = server.http.post(server.url(&path)).header("content-type", "application/x-protobuf");
    let response = call.body(cases::sound().encode_to_vec()).send().await.unwrap();
    assert_eq!(response.headers()["content-type"], "application/x-protobuf");
    let reply = RegisteredState::decode(response.bytes().await.unwrap()).unwrap();
    assert_eq!(positions(&reply), [[0.1; 3]; 2]);
}

#[tokio::test]
async fn a_worker_that_cannot_be_reached_is_replaced_once() {
    let server = Server::start().await;
    let mut away = Worker::register_at(&server, "http://127.0.0.1:1").await;
    let twin = twin(&server, &mut away).await;
    let mut client = registrations(&server);
    let status = client.register_state(request(&twin)).await.unwrap_err();
    assert_eq!(fault(&status).reason, "WORKER_LOST");
    let there = Worker::register(&server).await;
    let mut away = Worker::register_at(&server, "http://127.0.0.1:1").await;
    // The one that has the twin loaded is asked first.
    let (worker, warm_twins) = (away.id.to_string(), vec![twin.clone()]);
    let heartbeat = HeartbeatRequest { worker, warm_twins, ..HeartbeatRequest::default() };
    away.link.heartbeat(heartbeat).await.unwrap();
    let found = client.register_state(request(&twin)).await.unwrap().into_inner();
    assert_eq!(found.worker, there.id.to_string());
}

#[tokio::test]
async fn deadlines_and_clients_that_leave_end_the_work() {
    let server = Server::start().await;
    let hold = Arc::new(Notify::new());
    let device = Device { hold: Some(hold), ..Device::default() };
    let mut worker = Worker::register_with(&server, device.clone()).await;
    let twin = twin(&server, &mut worker).await;
    let mut client = registrations(&server);
    let call = request(&twin);
    let running = tokio::spawn(async move { client.register_state(call).await });
    device.begun.notified().await;
    running.abort();
    device.given_up.notified().await;

    let body = json!({"observation": {"points": [[0, 0, 1]], "nodes": [0]}});
    let timed = server.url(&format!("/v1/{twin}/register?timeout_s=0.2"));
    let (status, problem) = read(server.http.post(timed).json(&body).send().await.unwrap()).await;
    assert_eq!((status, &problem["reason"]), (504, &json!("DEADLINE_EXCEEDED")));
    device.given_up.notified().await;
}

#[tokio::test]
async fn a_session_that_is_nowhere_is_lost_to_a_correction() {
    let server = Server::start().await;
    let mut client = SessionServiceClient::new(server.channel.clone());
    let nodes = Tracks::Nodes(Tensor::pack(&[1], &[0u32]));
    let observation = Observation { tracks: Some(nodes), ..Observation::default() };
    let correction = |name: &str| CorrectSessionRequest {
        name: name.to_owned(),
        observation: Some(observation.clone()),
        ..CorrectSessionRequest::default()
    };
    let gone = correction("sessions/00000000-0000-7000-8000-000000000000");
    let status = client.correct_session(gone).await.unwrap_err();
    assert_eq!((status.code(), fault(&status).reason.as_str()), (Code::Aborted, "SESSION_LOST"));
    let status = client.correct_session(correction("x")).await.unwrap_err();
    assert_eq!(status.code(), Code::InvalidArgument);
}

#[tokio::test]
async fn a_correction_brings_the_state_and_says_that_a_slot_is_lost() {
    let server = Server::start().await;
    let mut worker = Worker::register(&server).await;
    let twin = twin(&server, &mut worker).await;
    let (status, session) = server.post("/v1/sessions", json!({"twin": twin})).await;
    assert_eq!(status, 201, "{session}");
    let path = format!("/v1/{}/correct", session["name"].as_str().unwrap());
    let ball = json!({"sphere": {"radius_m": 0.1}, "gripper": 0});
    let options = json!({"world": {"colliders": [ball]}, "grippers": [[0, 0, 0, 0, 0, 0, 1]],
        "register_if_lost": true});
    let observation = json!({"points": [[0, 0, 1], [0.5, 0, 2]], "nodes": [0, 1]});
    let body = json!({"observation": observation, "options": options});
    let (status, reply) = server.post(&path, body.clone()).await;
    assert_eq!(status, 200, "{reply}");
    let correction = &reply["corrections"][0];
    assert_eq!(correction["state"]["positions"], json!([[0.0, 0.0, 1.0], [0.5, 0.0, 2.0]]));
    assert_eq!(correction["tracking"], json!({"lost": true, "misfit": 1.25, "unexplained": 3}));
    assert_eq!((&correction["registered"], &reply["session"]["lost"]), (&json!(true), &json!([0])));

    let (status, problem) = server
        .post(&path, json!({"observation": observation, "options": {"grippers": [[0, 1]]}}))
        .await;
    assert_eq!(status, 400, "{problem}");
    assert!(problem["detail"].as_str().unwrap().contains("options.grippers"), "{problem}");

    let correct = CorrectSessionRequest {
        observation: cases::sound().observation,
        ..CorrectSessionRequest::default()
    };
    let call = server.http.post(server.url(&path)).header("content-type", "application/x-protobuf");
    let response = call.body(correct.encode_to_vec()).send().await.unwrap();
    let reply = CorrectedSession::decode(response.bytes().await.unwrap()).unwrap();
    assert!(reply.corrections[0].state.is_some());
    // Thirty-two colliders are the most, counted before anything is decoded.
    let colliders = vec![Collider::default(); 33];
    let world = Some(World { colliders, ..World::default() });
    let options = Some(CorrectOptions { world, ..CorrectOptions::default() });
    let mut client = SessionServiceClient::new(server.channel.clone());
    let crowded = CorrectSessionRequest { options, ..correct };
    let status = client.correct_session(crowded).await.unwrap_err();
    assert!(status.message().contains("world.colliders"), "{status:?}");
}
