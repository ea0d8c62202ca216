use std::{sync::Arc, time::Duration};

use base64::{Engine, prelude::BASE64_STANDARD};
use bendtwin_contract::rollout::{self, Limits, TwinShape};
use bendtwin_contract_kit::rollout as cases;
use bendtwin_core::Problem as _;
use bendtwin_proto::v1::{
    ControlTrajectories, Returns, RollOutRequest, RollOutResponse, Tensor,
    roll_out_request::Actions,
};
use bendtwin_proto::worker::v1::HeartbeatRequest;
use prost::Message;
use serde_json::json;
use tokio::sync::Notify;
use tonic::Code;

use crate::{
    harness::{Server, read},
    worker::{Device, Worker},
};

/// The shape of [`twin`].
pub(crate) const TWIN: TwinShape = TwinShape {
    nodes: 5,
    springs: 4,
    triplets: 3,
    controls: 1,
    skin_points: None,
    rods: None,
    substeps: 10,
    fast_substeps: None,
    planner: None,
    has_capture: true,
};

/// A twin of 5 nodes and 1 control point.
pub(crate) async fn twin(server: &Server, worker: &mut Worker) -> String {
    let fit = server.fit().await;
    let lease = worker.lease(Duration::from_secs(5)).await.unwrap();
    assert_eq!(lease.job, fit);
    worker.complete(&lease, b"a twin").await.unwrap()
}

pub(crate) fn request(twin: &str, batch: usize) -> RollOutRequest {
    let positions = Some(Tensor::pack(&[batch, 2, 1, 3], &vec![0.0f32; batch * 6]));
    RollOutRequest {
        twin: twin.to_owned(),
        actions: Some(Actions::Trajectories(ControlTrajectories { positions, interpolation: 0 })),
        frames: 10,
        ..RollOutRequest::default()
    }
}

fn costs(response: &RollOutResponse) -> Vec<f64> {
    response.costs.as_ref().unwrap().unpack("costs").unwrap().1
}

#[tokio::test]
async fn unary_is_one_part_and_streams_come_in_parts() {
    let server = Server::start().await;
    let mut worker = Worker::register(&server).await;
    let twin = twin(&server, &mut worker).await;
    let mut rollouts = server.rollouts();
    let whole = rollouts.roll_out(request(&twin, 40)).await.unwrap().into_inner();
    assert_eq!(costs(&whole), (0..40).map(f64::from).collect::<Vec<_>>());
    assert_eq!(whole.worker, worker.id.to_string());
    let timing = whole.timing.unwrap();
    assert!(timing.compute_s == 0.5 && timing.queue_s >= 0.0);

    let mut parts = rollouts.stream_roll_out(request(&twin, 40)).await.unwrap().into_inner();
    let mut seen = Vec::new();
    while let Some(part) = parts.message().await.unwrap() {
        assert_eq!(part.first_instance as usize, seen.len());
        seen.extend(costs(&part));
    }
    assert_eq!(seen, costs(&whole));
    // The best of a batch are known when all of it is.
    let returns = Some(Returns { best: 3, ..Returns::default() });
    let best = RollOutRequest { returns, ..request(&twin, 40) };
    let mut parts = rollouts.stream_roll_out(best).await.unwrap().into_inner();
    assert_eq!(costs(&parts.message().await.unwrap().unwrap()).len(), 40);
    assert!(parts.message().await.unwrap().is_none());
    // The worker answered for it: it counts as warm.
    let (_, workers) = server.get("/v1/workers").await;
    assert_eq!(workers["workers"][0]["warm_twins"], json!([twin]));
}

#[tokio::test]
async fn http_takes_and_gives_json_and_protobuf() {
    let server = Server::start().await;
    let mut worker = Worker::register(&server).await;
    let twin = twin(&server, &mut worker).await;
    let path = format!("/v1/{twin}/rollouts");
    let positions = json!([[[[0, 0, 0]], [[0, 0, 0.1]]], [[[0, 0, 0]], [[0, 0, 0.2]]]]);
    let costs_json = json!([{"weight": 1, "keypoints": {"nodes": [4], "targets": [[0, 0, 1]]}}]);
    let body = json!({
        "trajectories": {"positions": positions, "interpolation": "CUBIC"},
        "initial": {"rest": {}},
        "frames": 30,
        "costs": costs_json,
        "returns": {"every_frames": 10, "encoding": "INT16"},
    });
    let (status, reply) = server.post(&path, body).await;
    assert_eq!((status, &reply["costs"]), (200, &json!([0.0, 1.0])), "{reply}");

    let bytes: Vec<u8> = [0.0f32; 6].iter().flat_map(|x| x.to_le_bytes()).collect();
    let packed =
        json!({"dtype": "FLOAT32", "shape": [1, 2, 1, 3], "data": BASE64_STANDARD.encode(bytes)});
    let body = json!({"trajectories": {"positions": packed}});
    let (status, reply) = server.post(&format!("{path}?tensors=base64"), body).await;
    assert_eq!(status, 200, "{reply}");
    assert_eq!(reply["costs"], json!({"dtype": "FLOAT64", "shape": [1], "data": "AAAAAAAAAAA="}));

    let call = server.http.post(server.url(&path)).header("content-type", "application/x-protobuf");
    let response = call.body(request(&twin, 3).encode_to_vec()).send().await.unwrap();
    assert_eq!(response.headers()["content-type"], "application/x-protobuf");
    let reply = RollOutResponse::decode(response.bytes().await.unwrap()).unwrap();
    assert_eq!(costs(&reply), [0.0, 1.0, 2.0]);
}

#[tokio::test]
async fn a_malformed_request_gets_the_fault_of_the_check() {
    let server = Server::start().await;
    let mut worker = Worker::register(&server).await;
    let twin = twin(&server, &mut worker).await;
    let of = |request| RollOutRequest { twin: twin.clone(), ..request };
    let mut rollouts = server.rollouts();
    rollouts.roll_out(of(cases::sound(&TWIN))).await.unwrap();
    let mut refused = 0;
    for case in cases::malformed(&TWIN) {
        let request = of(case.request);
        let checked = rollout::check_for(&request, &TWIN, &Limits::default(), 0);
        // Twins here have a capture.
        let Err(expected) = checked else { continue };
        let status = rollouts.roll_out(request).await.unwrap_err();
        assert_eq!(bendtwin_proto::fault::fault(&status), expected.fault(), "{}", case.what);
        refused += 1;
    }
    assert!(refused > 70, "{refused}");
}

#[tokio::test]
async fn limits_are_those_of_the_servers_options_and_workers_receive_them() {
    let server = Server::start_with(|o| o.limits.rollout.instances = 2).await;
    let mut worker = Worker::register(&server).await;
    let limits = Limits { instances: 2, ..Limits::default() };
    assert_eq!(worker.rollout_limits, limits);
    let twin = twin(&server, &mut worker).await;
    server.rollouts().roll_out(request(&twin, 2)).await.unwrap();
    let status = server.rollouts().roll_out(request(&twin, 3)).await.unwrap_err();
    let fault = bendtwin_proto::fault::fault(&status);
    assert_eq!(fault.reason, "ROLLOUT_TOO_LARGE");
    assert!(fault.message.contains("split the batch"), "{fault}");
}

#[tokio::test]
async fn a_worker_that_cannot_be_reached_is_replaced_once() {
    let server = Server::start().await;
    let mut away = Worker::register_at(&server, "http://127.0.0.1:1").await;
    let twin = twin(&server, &mut away).await;
    let mut rollouts = server.rollouts();
    let status = rollouts.roll_out(request(&twin, 1)).await.unwrap_err();
    assert_eq!(bendtwin_proto::fault::fault(&status).reason, "WORKER_LOST");
    let there = Worker::register(&server).await;
    let mut away = Worker::register_at(&server, "http://127.0.0.1:1").await;
    // The one that has the twin loaded is asked first.
    let (worker, warm_twins) = (away.id.to_string(), vec![twin.clone()]);
    let heartbeat = HeartbeatRequest { worker, warm_twins, ..HeartbeatRequest::default() };
    away.link.heartbeat(heartbeat).await.unwrap();
    let reply = rollouts.roll_out(request(&twin, 1)).await.unwrap().into_inner();
    assert_eq!(reply.worker, there.id.to_string());
}

/// The rollout may be the reason why the worker ended: it must not end the next one, too.
#[tokio::test]
async fn a_rollout_that_a_worker_took_is_not_sent_to_another() {
    let server = Server::start().await;
    let mut first = Worker::register(&server).await;
    let twin = twin(&server, &mut first).await;
    let mut rollouts = server.rollouts();
    rollouts.roll_out(request(&twin, 1)).await.unwrap();
    let device = Device::default();
    let second = Worker::register_with(&server, device.clone()).await;
    first.kill_endpoint();
    // The first has the twin loaded, so it is asked.
    let status = rollouts.roll_out(request(&twin, 1)).await.unwrap_err();
    let fault = bendtwin_proto::fault::fault(&status);
    assert_eq!((status.code(), fault.reason.as_str()), (Code::Unavailable, "WORKER_LOST"));
    assert!(fault.message.contains("not sent to another worker"), "{fault}");
    let untouched = tokio::time::timeout(Duration::ZERO, device.begun.notified()).await;
    assert!(untouched.is_err(), "the second worker got it, too");
    // The next goes to the second, while the first is left alone.
    let reply = rollouts.roll_out(request(&twin, 1)).await.unwrap().into_inner();
    assert_eq!(reply.worker, second.id.to_string());
}

/// A rollout is as likely the cause of a worker's end as the fit that happens to run there.
#[tokio::test]
async fn a_worker_that_ends_during_a_rollout_costs_its_fit_no_attempt() {
    let server = Server::start_with(|o| {
        // The worker says nothing of itself until its rollout has begun.
        o.lease_s = 5.0;
        o.heartbeat_interval_s = 1.0;
    })
    .await;
    let device = Device { hold: Some(Arc::new(Notify::new())), ..Device::default() };
    let mut worker = Worker::register_with(&server, device.clone()).await;
    let twin = twin(&server, &mut worker).await;
    let fit = server.fit().await;
    let lease = worker.lease(Duration::ZERO).await.unwrap();
    assert_eq!(lease.job, fit);
    let mut rollouts = server.rollouts();
    let rollout = tokio::spawn(async move { rollouts.roll_out(request(&twin, 1)).await });
    device.begun.notified().await;
    // Nothing is heard of the worker from here on.
    let queued = async {
        loop {
            let (_, got) = server.get(&format!("/v1/{fit}")).await;
            if got["job"]["state"] == "QUEUED" {
                return got;
            }
            tokio::time::sleep(Duration::from_millis(20)).await;
        }
    };
    let got = tokio::time::timeout(Duration::from_secs(60), queued).await.unwrap();
    assert_eq!((&got["job"]["attempts"], &got["job"]["attempt_faults"]), (&json!(0), &json!([])));
    rollout.abort();
}

#[tokio::test]
async fn without_workers_and_without_twins() {
    let server = Server::start().await;
    let mut rollouts = server.rollouts();
    let unknown = "twins/00000000-0000-7000-8000-000000000000";
    let status = rollouts.roll_out(request(unknown, 1)).await.unwrap_err();
    assert_eq!(status.code(), Code::NotFound);
    let mut breaking = Worker::register_with(
        &server,
        Device { breaks: Arc::new(true.into()), ..Device::default() },
    )
    .await;
    let twin = twin(&server, &mut breaking).await;
    let status = rollouts.roll_out(request(&twin, 1)).await.unwrap_err();
    assert_eq!(
        (status.code(), bendtwin_proto::fault::fault(&status).reason.as_str()),
        (Code::Unavailable, "WORKER_LOST")
    );
    // It is left alone for a while: no worker is available.
    let status = rollouts.roll_out(request(&twin, 1)).await.unwrap_err();
    assert_eq!(bendtwin_proto::fault::fault(&status).reason, "NO_WORKER");
    use tonic_types::StatusExt;
    assert!(status.get_details_retry_info().is_some());
}

#[tokio::test]
async fn full_queues_deadlines_and_clients_that_leave() {
    let server = Server::start_with(|o| {
        o.limits.rollouts_per_worker = 1;
        o.limits.rollout_queue = 1;
    })
    .await;
    let hold = Arc::new(Notify::new());
    let device = Device { hold: Some(hold.clone()), ..Device::default() };
    let mut worker = Worker::register_with(&server, device.clone()).await;
    let twin = twin(&server, &mut worker).await;
    let call = |timeout: Option<Duration>| {
        let mut rollouts = server.rollouts();
        let mut request = tonic::Request::new(request(&twin, 1));
        if let Some(timeout) = timeout {
            request.set_timeout(timeout);
        }
        tokio::spawn(async move { rollouts.roll_out(request).await })
    };
    let running = call(None);
    device.begun.notified().await;
    let waiting = call(None);
    // Two have their places; a third finds none.
    let refused = loop {
        let refused = call(Some(Duration::from_millis(100))).await.unwrap().unwrap_err();
        if refused.code() == Code::ResourceExhausted {
            break refused;
        }
        // The second had not come yet, so this one waited in its place.
        assert!(matches!(refused.code(), Code::DeadlineExceeded | Code::Cancelled));
    };
    use tonic_types::StatusExt;
    assert!(refused.get_details_retry_info().unwrap().retry_delay.is_some());
    let body = json!({"trajectories": {"positions": [[[[0, 0, 0]], [[0, 0, 0]]]]}});
    let (status, problem) = server.post(&format!("/v1/{twin}/rollouts"), body.clone()).await;
    assert_eq!((status, &problem["reason"]), (429, &json!("WORKERS_BUSY")));

    // The client of the first leaves: the worker hears of it, and the second has its turn.
    running.abort();
    device.given_up.notified().await;
    device.begun.notified().await;
    hold.notify_one();
    waiting.await.unwrap().unwrap();

    let timed = format!("/v1/{twin}/rollouts?timeout_s=0.05");
    let response = server.http.post(server.url(&timed)).json(&body).send().await.unwrap();
    let (status, problem) = read(response).await;
    assert_eq!((status, &problem["reason"]), (504, &json!("DEADLINE_EXCEEDED")));
    device.given_up.notified().await;
}

#[tokio::test]
async fn large_json_is_refused_in_favour_of_bytes() {
    let server = Server::start_with(|o| {
        o.limits.rollout.json_bytes = 2_000;
        o.limits.rollout.json_reply_bytes = 2_000;
    })
    .await;
    let mut worker = Worker::register(&server).await;
    let twin = twin(&server, &mut worker).await;
    let path = format!("/v1/{twin}/rollouts");
    // A body of any declared length, and one in chunks.
    let long = format!("{{\"trajectories\": {}}}", " ".repeat(3_000));
    for chunked in [false, true] {
        let request =
            server.http.post(server.url(&path)).header("content-type", "application/json");
        let request = if chunked {
            let chunks = long.as_bytes().chunks(500).map(|c| Ok::<_, std::io::Error>(c.to_vec()));
            let chunks: Vec<_> = chunks.collect();
            request.body(reqwest::Body::wrap_stream(futures::stream::iter(chunks)))
        } else {
            request.body(long.clone())
        };
        let (status, problem) = read(request.send().await.unwrap()).await;
        assert_eq!((status, &problem["reason"]), (413, &json!("CONTENT_TOO_LARGE")), "{problem}");
        assert!(
            problem["detail"].as_str().unwrap().contains("application/x-protobuf"),
            "{problem}"
        );
    }
    // Decided before anything is computed: 10 frames of 5 nodes and 10 instances.
    let knots = vec![vec![[[0.0; 3]]; 2]; 10];
    let body = json!({
        "trajectories": {"positions": knots},
        "frames": 10,
        "returns": {"every_frames": 1},
    });
    let (status, problem) = server.post(&path, body.clone()).await;
    assert_eq!((status, &problem["reason"]), (400, &json!("ROLLOUT_TOO_LARGE")), "{problem}");
    assert!(problem["detail"].as_str().unwrap().contains("?tensors=base64"), "{problem}");
    let (status, reply) = server.post(&format!("{path}?tensors=base64"), body.clone()).await;
    assert_eq!(status, 200, "{reply}");
    let call = server.http.post(server.url(&path)).json(&body);
    let reply = call.header("accept", "application/x-protobuf").send().await.unwrap();
    let reply = RollOutResponse::decode(reply.bytes().await.unwrap()).unwrap();
    assert_eq!(costs(&reply).len(), 10);
}

#[tokio::test]
async fn an_answer_in_many_chunks_is_the_whole_answer() {
    let server = Server::start().await;
    let mut worker = Worker::register(&server).await;
    let twin = twin(&server, &mut worker).await;
    let knots = vec![vec![[[0; 3]]; 2]; 20_000];
    let body = json!({"trajectories": {"positions": knots}});
    let (status, reply) = server.post(&format!("/v1/{twin}/rollouts"), body.clone()).await;
    assert_eq!(status, 200, "{reply}");
    let costs = reply["costs"].as_array().unwrap();
    assert!(costs.len() == 20_000 && costs[19_999] == 19_999.0, "{}", costs.len());
    let path = format!("/v1/{twin}/rollouts?tensors=base64");
    let (_, reply) = server.post(&path, body).await;
    let costs = BASE64_STANDARD.decode(reply["costs"]["data"].as_str().unwrap()).unwrap();
    assert_eq!(costs[8 * 19_999..], 19_999.0f64.to_le_bytes());
    // Nothing is held any more.
    let held = "bendtwin_memory_budget_bytes{state=\"used\"} ";
    let used = async || {
        let text = server.http.get(server.url("/metrics")).send().await.unwrap().text().await;
        let text = text.unwrap();
        let line = text.lines().find_map(|l| l.strip_prefix(held)).map(str::to_owned);
        line.unwrap_or_else(|| panic!("no gauge of the memory in {text}"))
    };
    for _ in 0..500 {
        if used().await == "0" {
            return;
        }
        tokio::time::sleep(Duration::from_millis(10)).await;
    }
    panic!("{} bytes are still held", used().await);
}

#[tokio::test]
async fn a_body_that_never_fits_is_refused_with_what_would() {
    let server = Server::start_with(|o| o.memory_mib = Some(64)).await;
    let mut worker = Worker::register(&server).await;
    let twin = twin(&server, &mut worker).await;
    // 400,000 instances of 24 bytes, for which three times the memory is taken.
    let large = request(&twin, 400_000);
    let refused = server.rollouts().roll_out(large.clone()).await.unwrap_err();
    let fault = bendtwin_proto::fault::fault(&refused);
    assert_eq!((refused.code(), &*fault.reason), (Code::InvalidArgument, "MEMORY_TOO_SMALL"));
    assert!(fault.message.contains("at most 22020096 are given"), "{fault}");
    let path = format!("/v1/{twin}/rollouts");
    let call = server.http.post(server.url(&path)).header("content-type", "application/x-protobuf");
    let (status, problem) = read(call.body(large.encode_to_vec()).send().await.unwrap()).await;
    assert_eq!((status, &problem["reason"]), (400, &json!("MEMORY_TOO_SMALL")), "{problem}");
    server.rollouts().roll_out(request(&twin, 30_000)).await.unwrap();
}

#[tokio::test]
async fn requests_are_checked_before_they_are_decoded() {
    let server = Server::start().await;
    let mut worker = Worker::register(&server).await;
    let twin = twin(&server, &mut worker).await;
    let returns = Returns {
        nodes: Some(Tensor { shape: vec![0; 200_000], ..Tensor::default() }),
        ..Returns::default()
    };
    let shaped = RollOutRequest { returns: Some(returns), ..request(&twin, 1) };
    let refused = server.rollouts().roll_out(shaped.clone()).await.unwrap_err();
    assert!(refused.message().contains("more than 8 dimensions"), "{refused}");
    let path = format!("/v1/{twin}/rollouts");
    let call = server.http.post(server.url(&path)).header("content-type", "application/x-protobuf");
    let (status, problem) = read(call.body(shaped.encode_to_vec()).send().await.unwrap()).await;
    assert_eq!((status, &problem["reason"]), (400, &json!("INVALID_ROLLOUT")), "{problem}");
    assert!(problem["detail"].as_str().unwrap().contains("more than 8 dimensions"), "{problem}");
}

/// Half a minute of work for what is assumed of a worker at first: 12 elements, 10 substeps.
fn large(twin: &str) -> RollOutRequest {
    RollOutRequest { frames: 100_000, ..request(twin, 100) }
}

#[tokio::test]
async fn small_rollouts_pass_large_ones() {
    let server = Server::start().await;
    let hold = Arc::new(Notify::new());
    let device = Device { hold: Some(hold.clone()), hold_above: 1, ..Device::default() };
    let mut worker = Worker::register_with(&server, device.clone()).await;
    let twin = twin(&server, &mut worker).await;
    let mut large_ones = Vec::new();
    for _ in 0..8 {
        let (mut rollouts, request) = (server.rollouts(), large(&twin));
        large_ones.push(tokio::spawn(async move { rollouts.roll_out(request).await }));
    }
    device.begun.notified().await;
    let (_, ready) = server.get("/readyz").await;
    assert!(ready["rollouts"].as_u64().unwrap() >= 1, "{ready}");
    // As many slots as there are large ones, and still there is one for a small one.
    for _ in 0..8 {
        let mut rollouts = server.rollouts();
        let small = rollouts.roll_out(request(&twin, 1));
        let answered = tokio::time::timeout(Duration::from_secs(60), small).await;
        answered.expect("a small rollout does not wait for large ones").unwrap();
    }
    let (_, metrics) = server.get("/metrics").await;
    let metrics = metrics.as_str().unwrap();
    // Of the two slots that large ones may take their owner leaves one to others.
    assert!(metrics.contains("bendtwin_rollouts_waiting{class=\"large\"} 7"), "{metrics}");
    assert!(metrics.contains("bendtwin_rollouts_waiting{class=\"small\"} 0"), "{metrics}");
    assert!(large_ones.iter().all(|l| !l.is_finished()));
    large_ones.iter().for_each(tokio::task::JoinHandle::abort);
}

#[tokio::test]
async fn a_refusal_says_how_long_the_work_ahead_takes() {
    let server = Server::start_with(|o| {
        o.limits.rollouts_per_worker = 1;
        o.limits.rollout_queue = 2;
    })
    .await;
    let device = Device { hold: Some(Arc::default()), ..Device::default() };
    let mut worker = Worker::register_with(&server, device.clone()).await;
    let twin = twin(&server, &mut worker).await;
    let call = || {
        let (mut rollouts, request) = (server.rollouts(), large(&twin));
        tokio::spawn(async move { rollouts.roll_out(request).await })
    };
    let running = call();
    device.begun.notified().await;
    let waiting = call();
    // One is under way, one waits; the other place is kept for smaller ones.
    let refused = loop {
        let refused = call();
        match tokio::time::timeout(Duration::from_millis(200), refused).await {
            Ok(refused) => break refused.unwrap().unwrap_err(),
            Err(_) => assert!(!waiting.is_finished()),
        }
    };
    use tonic_types::StatusExt;
    let retry = refused.get_details_retry_info().unwrap().retry_delay.unwrap();
    // Two of 100 x 100,000 x 10 x 12 at 4e7 a second.
    assert_eq!(retry, Duration::from_secs(60), "{refused}");
    let body = large(&twin).encode_to_vec();
    let call = server.http.post(server.url(&format!("/v1/{twin}/rollouts")));
    let call = call.header("content-type", "application/x-protobuf").body(body);
    let response = call.send().await.unwrap();
    assert_eq!(response.status(), 429);
    assert_eq!(response.headers()["retry-after"], "60");
    running.abort();
    waiting.abort();
}

/// A worker that other servers keep busy says so, and the next one is asked.
#[tokio::test]
async fn a_busy_worker_is_passed_over_and_all_of_them_mean_a_wait() {
    let server = Server::start().await;
    let (one, two) = (Device::default(), Device::default());
    let busy = [one.is_busy.clone(), two.is_busy.clone()];
    let mut first = Worker::register_with(&server, one).await;
    let second = Worker::register_with(&server, two).await;
    let twin = twin(&server, &mut first).await;
    busy[0].store(true, std::sync::atomic::Ordering::SeqCst);
    for _ in 0..4 {
        let reply = server.rollouts().roll_out(request(&twin, 1)).await.unwrap().into_inner();
        assert_eq!(reply.worker, second.id.to_string());
    }
    busy[1].store(true, std::sync::atomic::Ordering::SeqCst);
    let refused = server.rollouts().roll_out(request(&twin, 1)).await.unwrap_err();
    assert_eq!(refused.code(), Code::ResourceExhausted);
    assert_eq!(bendtwin_proto::fault::fault(&refused).reason, "WORKERS_BUSY", "{refused}");
}
