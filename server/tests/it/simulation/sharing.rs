//! Several workers: who answers, and batches that they share.

use std::{sync::Arc, time::Duration};

use bendtwin_proto::v1::{
    ControlTrajectories, InitialState, Returns, RollOutRequest, Tensor,
    initial_state::{SessionSlots, State},
    roll_out_request::Actions,
};
use bendtwin_proto::worker::v1::{HeartbeatRequest, HeldSession};
use serde_json::Value;
use tokio::sync::Notify;
use tonic::Code;

use super::rollouts::twin;
use crate::{
    harness::Server,
    worker::{Device, Worker},
};

/// Frames with which a batch takes an idle worker about a second, before its speed is measured.
const LONG: u32 = 10_000;

fn request(twin: &str, batch: usize, frames: u32) -> RollOutRequest {
    let values: Vec<f32> = (0..batch * 6).map(|i| i as f32).collect();
    let positions = Some(Tensor::pack(&[batch, 2, 1, 3], &values));
    RollOutRequest {
        twin: twin.to_owned(),
        actions: Some(Actions::Trajectories(ControlTrajectories { positions, interpolation: 0 })),
        frames,
        ..RollOutRequest::default()
    }
}

/// Two workers whose instances cost what their actions say.
async fn two(server: &Server, device: &Device) -> [Worker; 2] {
    let device = Device { echoes: true, ..device.clone() };
    let first = Worker::register_with(server, device.clone()).await;
    [first, Worker::register_with(server, device).await]
}

/// The rollouts at each worker, once they add up to `total`.
async fn in_flight(server: &Server, total: u64) -> Vec<u64> {
    let all_there = async {
        loop {
            let (_, got) = server.get("/v1/workers").await;
            let of = |w: &Value| w["rollouts_in_flight"].as_u64().unwrap();
            let each: Vec<u64> = got["workers"].as_array().unwrap().iter().map(of).collect();
            if each.iter().sum::<u64>() == total {
                return each;
            }
            tokio::time::sleep(Duration::from_millis(10)).await;
        }
    };
    tokio::time::timeout(Duration::from_secs(60), all_there).await.unwrap()
}

#[tokio::test]
async fn an_idle_worker_answers_before_one_that_fits_even_where_that_has_the_twin() {
    let server = Server::start().await;
    let [mut fitting, idle] = two(&server, &Device::default()).await;
    let twin = twin(&server, &mut fitting).await;
    let (worker, warm_twins) = (fitting.id.to_string(), vec![twin.clone()]);
    let heartbeat = HeartbeatRequest { worker, warm_twins, ..HeartbeatRequest::default() };
    fitting.link.heartbeat(heartbeat).await.unwrap();
    let mut rollouts = server.rollouts();
    let reply = rollouts.roll_out(request(&twin, 1, 1)).await.unwrap().into_inner();
    assert_eq!(reply.worker, fitting.id.to_string(), "it has the twin, and no fit");
    server.fit().await;
    fitting.lease(Duration::from_secs(5)).await.unwrap();
    let reply = rollouts.roll_out(request(&twin, 1, 1)).await.unwrap().into_inner();
    assert_eq!(reply.worker, idle.id.to_string());
}

#[tokio::test]
async fn calls_of_one_twin_go_to_both_workers() {
    let server = Server::start().await;
    let hold = Arc::new(Notify::new());
    let device = Device { hold: Some(hold.clone()), ..Device::default() };
    let [mut worker, _other] = two(&server, &device).await;
    let twin = twin(&server, &mut worker).await;
    let calls: Vec<_> = (0..4)
        .map(|_| {
            let (mut rollouts, request) = (server.rollouts(), request(&twin, 1, 1));
            tokio::spawn(async move { rollouts.roll_out(request).await })
        })
        .collect();
    assert_eq!(in_flight(&server, 4).await, [2, 2]);
    calls.iter().for_each(|call| call.abort());
}

#[tokio::test]
async fn a_large_batch_is_shared_and_its_reply_is_in_order() {
    let server = Server::start().await;
    let hold = Arc::new(Notify::new());
    let device = Device { hold: Some(hold.clone()), ..Device::default() };
    let [mut worker, _other] = two(&server, &device).await;
    let twin = twin(&server, &mut worker).await;
    let (mut rollouts, large) = (server.rollouts(), request(&twin, 41, LONG));
    let call = tokio::spawn(async move { rollouts.roll_out(large).await });
    assert_eq!(in_flight(&server, 2).await, [1, 1]);
    // Notified once for each of the two, whenever it gets there.
    while !call.is_finished() {
        hold.notify_waiters();
        tokio::time::sleep(Duration::from_millis(10)).await;
    }
    let reply = call.await.unwrap().unwrap().into_inner();
    let costs = reply.costs.unwrap().unpack::<f64>("costs").unwrap().1;
    assert_eq!(costs, (0..41).map(|i| f64::from(i * 6)).collect::<Vec<_>>());
    assert_eq!(reply.timing.unwrap().compute_s, 0.5);
    in_flight(&server, 0).await;
}

#[tokio::test]
async fn the_best_of_a_batch_and_a_short_one_stay_at_one_worker() {
    for best in [1, 0] {
        let server = Server::start().await;
        let hold = Arc::new(Notify::new());
        let device = Device { hold: Some(hold.clone()), ..Device::default() };
        let [mut worker, _other] = two(&server, &device).await;
        let twin = twin(&server, &mut worker).await;
        let frames = if best > 0 { LONG } else { 10 };
        let returns = Some(Returns { best, ..Returns::default() });
        let batch = RollOutRequest { returns, ..request(&twin, 41, frames) };
        let mut rollouts = server.rollouts();
        let call = tokio::spawn(async move { rollouts.roll_out(batch).await });
        device.begun.notified().await;
        assert_eq!(in_flight(&server, 1).await.len(), 2);
        call.abort();
    }
}

#[tokio::test]
async fn a_batch_from_a_session_stays_at_the_worker_that_has_it() {
    let server = Server::start().await;
    let hold = Arc::new(Notify::new());
    let device = Device { hold: Some(hold.clone()), ..Device::default() };
    let [mut worker, mut other] = two(&server, &device).await;
    let twin = twin(&server, &mut worker).await;
    let session = format!("sessions/{}", uuid::Uuid::now_v7());
    let held = HeldSession {
        session: session.clone(),
        twin: twin.clone(),
        slots: 2,
        ..HeldSession::default()
    };
    let heartbeat = HeartbeatRequest {
        worker: other.id.to_string(),
        sessions: vec![held],
        ..HeartbeatRequest::default()
    };
    other.link.heartbeat(heartbeat).await.unwrap();
    let slots = State::Session(SessionSlots { session, slots: Vec::new() });
    let initial = Some(InitialState { state: Some(slots) });
    let batch = RollOutRequest { initial, ..request("", 41, LONG) };
    let mut rollouts = server.rollouts();
    let call = tokio::spawn(async move { rollouts.roll_out(batch).await });
    device.begun.notified().await;
    in_flight(&server, 1).await;
    while !call.is_finished() {
        hold.notify_waiters();
        tokio::time::sleep(Duration::from_millis(10)).await;
    }
    let reply = call.await.unwrap().unwrap().into_inner();
    assert_eq!(reply.worker, other.id.to_string());
}

#[tokio::test]
async fn a_part_goes_elsewhere_if_its_worker_is_not_there_and_nowhere_if_that_took_it() {
    let server = Server::start().await;
    let device = Device { echoes: true, ..Device::default() };
    let mut there = Worker::register_with(&server, device.clone()).await;
    let twin = twin(&server, &mut there).await;
    let _away = Worker::register_at(&server, "http://127.0.0.1:1").await;
    let reply = server.rollouts().roll_out(request(&twin, 40, LONG)).await.unwrap().into_inner();
    let costs = reply.costs.unwrap().unpack::<f64>("costs").unwrap().1;
    assert_eq!(costs, (0..40).map(|i| f64::from(i * 6)).collect::<Vec<_>>());

    let server = Server::start().await;
    let hold = Arc::new(Notify::new());
    let held = Device { hold: Some(hold), ..Device::default() };
    let mut held_worker = Worker::register_with(&server, held.clone()).await;
    let twin = self::twin(&server, &mut held_worker).await;
    let breaking = Device { breaks: Arc::new(true.into()), ..Device::default() };
    let _breaking = Worker::register_with(&server, breaking).await;
    let status = server.rollouts().roll_out(request(&twin, 40, LONG)).await.unwrap_err();
    let fault = bendtwin_proto::fault::fault(&status);
    assert_eq!((status.code(), fault.reason.as_str()), (Code::Unavailable, "WORKER_LOST"));
    // The other part is given up with it.
    held.given_up.notified().await;
}
