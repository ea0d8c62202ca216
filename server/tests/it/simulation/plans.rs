//! Plans at the server: batch after batch at a worker, updates to the client.

use std::{sync::Arc, time::Duration};

use bendtwin_contract::rollout::TwinShape;
use bendtwin_contract_kit::plan as cases;
use bendtwin_proto::v1::{
    ControlTrajectories, PlanMethod, PlanRequest, PlanUpdate, Plausibility, Returns, Tensor,
    plan_method::{Cem, Gradient, Method, Mppi, PredictiveSampling},
    plan_update::Origin,
    roll_out_request::Actions,
};
use prost::Message as _;
use tokio::sync::Notify;
use tonic::{Code, Status};

use super::rollouts;
use crate::{
    harness::{Server, read},
    worker::{Device, Worker},
};

/// The twin of the tests' workers, as the cases have it.
pub(super) const TWIN: TwinShape =
    TwinShape { skin_points: Some(9), has_capture: false, ..rollouts::TWIN };

/// A server with a worker whose costs are lowest at the origin, and a twin.
pub(super) async fn started(device: Device) -> (Server, Worker, String) {
    let server = Server::start().await;
    let mut worker = Worker::register_with(&server, Device { bowl: true, ..device }).await;
    let twin = rollouts::twin(&server, &mut worker).await;
    (server, worker, twin)
}

/// A plan that begins with a control point half a metre beside the origin.
fn request(twin: &str) -> PlanRequest {
    let mut request = PlanRequest { samples: 16, iterations: 4, ..cases::sound(&TWIN) };
    let rollout = request.rollout.as_mut().unwrap();
    rollout.twin = twin.to_owned();
    let positions = Some(Tensor::pack_points(&[1, 3, 1], &[[0.5, 0.0, 0.0]; 3]));
    rollout.actions = Some(Actions::Trajectories(ControlTrajectories {
        positions,
        ..ControlTrajectories::default()
    }));
    request
}

fn with(twin: &str, method: Method) -> PlanRequest {
    PlanRequest { method: Some(PlanMethod { method: Some(method) }), ..request(twin) }
}

pub(super) async fn planned(
    server: &Server,
    request: PlanRequest,
) -> Result<Vec<PlanUpdate>, Status> {
    let mut stream = server.planning().plan(request).await?.into_inner();
    let mut updates = Vec::new();
    while let Some(update) = stream.message().await? {
        updates.push(update);
    }
    Ok(updates)
}

fn knots(update: &PlanUpdate) -> Vec<[f32; 3]> {
    let (shape, knots) = update.knots.as_ref().unwrap().unpack_points("knots").unwrap();
    assert_eq!(shape, [1, 3, 1]);
    knots
}

#[tokio::test]
async fn every_method_lowers_the_cost_and_says_the_cost_of_its_very_knots() {
    let (server, _worker, twin) = started(Device::default()).await;
    let methods = [
        Method::Mppi(Mppi::default()),
        Method::Cem(Cem::default()),
        Method::PredictiveSampling(PredictiveSampling {}),
        Method::Gradient(Gradient::default()),
    ];
    for method in methods {
        let updates = planned(&server, with(&twin, method.clone())).await.unwrap();
        let costs: Vec<f64> = updates.iter().map(|u| u.cost).collect();
        assert!(costs.is_sorted_by(|a, b| a >= b), "{method:?}: {costs:?}");
        assert_eq!(updates[0].nominal_cost, 0.75);
        assert!(updates.iter().rev().skip(1).all(|update| !update.last));
        let last = updates.last().unwrap();
        assert!(last.last && !last.stopped_by_deadline && last.cost < 0.75, "{method:?}");
        assert_eq!((last.iterations, last.diverged, &last.rollout), (4, 0, &None));
        assert!(last.origin() == Origin::Sample || last.origin() == Origin::Mean);
        let found = knots(last);
        assert_eq!(found[0], [0.5, 0.0, 0.0], "row 0 stays");
        let squares = found.iter().flatten().map(|x| f64::from(*x).powi(2)).sum::<f64>();
        assert_eq!(last.cost, squares);
        // As they came back they are the next nominal plan.
        let mut next = with(&twin, method);
        next.rollout.as_mut().unwrap().actions = Some(Actions::Trajectories(ControlTrajectories {
            positions: last.knots.clone(),
            ..ControlTrajectories::default()
        }));
        let again = planned(&server, next).await.unwrap();
        assert_eq!(again[0].nominal_cost, last.cost);
    }
}

/// The cost is lowest at the origin, half a metre from the start, where the strain is 2.
#[tokio::test]
async fn plans_keep_the_limit_of_the_strain_unless_it_is_lifted() {
    let (server, _worker, twin) = started(Device { strains: true, ..Device::default() }).await;
    let last = |updates: Vec<PlanUpdate>| updates.last().unwrap().clone();
    let strain = |update: &PlanUpdate| {
        let far = knots(update).iter().map(|p| (p[0] - 0.5).abs()).fold(0.0, f32::max);
        f64::from(4.0 * far)
    };
    let methods = [
        Method::Mppi(Mppi::default()),
        Method::Cem(Cem::default()),
        Method::PredictiveSampling(PredictiveSampling {}),
        Method::Gradient(Gradient { rate: Some(Tensor::pack(&[1], &[0.1f32])) }),
    ];
    for method in methods {
        let request = |limit| {
            let mut request = with(&twin, method.clone());
            request.sigma = Some(Tensor::pack(&[1], &[0.3f32]));
            request.iterations = 12;
            let strain = Some(limit);
            request.rollout.as_mut().unwrap().plausibility =
                (limit != 1.0).then(|| Plausibility { strain, ..Plausibility::default() });
            request
        };
        let kept = last(planned(&server, request(1.0)).await.unwrap());
        assert!(kept.strain <= 1.0 && strain(&kept) == kept.strain, "{method:?}: {kept:?}");
        assert!(kept.overstrained > 0 && kept.diverged == 0 && kept.cost < 0.75, "{method:?}");
        let lifted = last(planned(&server, request(f64::INFINITY)).await.unwrap());
        assert!(lifted.strain > 1.0 && lifted.cost < kept.cost, "{method:?}: {lifted:?}");
        assert_eq!((lifted.strain_limit, lifted.overstrained), (f64::INFINITY, 0));
        let narrow = last(planned(&server, request(0.5)).await.unwrap());
        assert!(narrow.strain <= 0.5 && narrow.strain_limit == 0.5, "{method:?}: {narrow:?}");
    }
    // A plan that begins beyond the limit returns within it.
    let mut beyond = request(&twin);
    let positions = Tensor::pack_points(&[1, 3, 1], &[[0.5; 3], [1.5; 3], [1.5; 3]]);
    beyond.rollout.as_mut().unwrap().actions = Some(Actions::Trajectories(ControlTrajectories {
        positions: Some(positions),
        ..ControlTrajectories::default()
    }));
    (beyond.sigma, beyond.iterations) = (Some(Tensor::pack(&[1], &[0.2f32])), 40);
    let updates = planned(&server, beyond).await.unwrap();
    assert!(last(updates).strain <= 1.0);
}

#[tokio::test]
async fn the_same_seed_gives_the_same_plan_and_the_best_is_rolled_out() {
    let (server, _worker, twin) = started(Device::default()).await;
    let with_seed = |seed| {
        let mut request = PlanRequest { seed, ..request(&twin) };
        let returns = Some(Returns { final_state: true, ..Returns::default() });
        request.rollout.as_mut().unwrap().returns = returns;
        request
    };
    let last = |updates: Vec<PlanUpdate>| updates.last().unwrap().clone();
    let first = last(planned(&server, with_seed(3)).await.unwrap());
    let second = last(planned(&server, with_seed(3)).await.unwrap());
    assert_eq!((&first.knots, first.cost), (&second.knots, second.cost));
    let other = last(planned(&server, with_seed(4)).await.unwrap());
    assert_ne!(first.knots, other.knots);
    let costs = first.rollout.unwrap().costs.unwrap().unpack::<f64>("costs").unwrap().1;
    assert_eq!(costs, [first.cost]);
}

#[tokio::test]
async fn a_nominal_plan_is_moved_on_by_what_was_executed() {
    let (server, _worker, twin) = started(Device::default()).await;
    let mut request = request(&twin);
    let rollout = request.rollout.as_mut().unwrap();
    let positions = Tensor::pack_points(&[1, 3, 1], &[[2.5; 3], [1.5; 3], [0.5; 3]]);
    rollout.actions = Some(Actions::Trajectories(ControlTrajectories {
        positions: Some(positions),
        ..ControlTrajectories::default()
    }));
    request.sigma = Some(Tensor::pack(&[1], &[0f32]));
    request.shift_frames = 1.0;
    let updates = planned(&server, request).await.unwrap();
    assert_eq!(knots(&updates[0]), [[1.5; 3], [0.5; 3], [0.5; 3]]);
}

#[tokio::test]
async fn at_the_deadline_the_best_so_far_comes_back() {
    let hold = Arc::new(Notify::new());
    let device = Device { hold: Some(hold.clone()), ..Device::default() };
    let (server, _worker, twin) = started(device.clone()).await;
    // One batch passes, the next one hangs.
    hold.notify_one();
    let request = PlanRequest { deadline_s: 1.0, ..request(&twin) };
    let updates = planned(&server, request.clone()).await.unwrap();
    let last = updates.last().unwrap();
    assert!(last.last && last.stopped_by_deadline && last.cost <= last.nominal_cost);
    assert_eq!((last.iterations, last.simulated), (1, 16));
    // The first iteration is finished, however long it takes: not beyond the call's own deadline.
    let mut call = tonic::Request::new(request);
    call.set_timeout(Duration::from_millis(1500));
    let mut stream = server.planning().plan(call).await.unwrap().into_inner();
    assert_eq!(stream.message().await.unwrap_err().code(), Code::DeadlineExceeded);
}

#[tokio::test]
async fn a_dropped_stream_stops_the_planning() {
    let device = Device { hold: Some(Arc::new(Notify::new())), ..Device::default() };
    let (server, _worker, twin) = started(device.clone()).await;
    let stream = server.planning().plan(request(&twin)).await.unwrap();
    device.begun.notified().await;
    drop(stream);
    tokio::time::timeout(Duration::from_secs(60), device.given_up.notified()).await.unwrap();
}

#[tokio::test]
async fn a_server_that_stops_ends_its_plans() {
    let device = Device { hold: Some(Arc::new(Notify::new())), ..Device::default() };
    let (server, _worker, twin) = started(device.clone()).await;
    let mut stream = server.planning().plan(request(&twin)).await.unwrap().into_inner();
    device.begun.notified().await;
    let Server { handle, .. } = server;
    let stopped = tokio::spawn(handle.shutdown());
    let status = stream.message().await.unwrap_err();
    assert_eq!(status.code(), Code::Unavailable, "{status}");
    stopped.await.unwrap();
}

#[tokio::test]
async fn plans_that_all_diverge_are_an_error() {
    let (server, _worker, twin) = started(Device::default()).await;
    let mut request = request(&twin);
    let rollout = request.rollout.as_mut().unwrap();
    rollout.actions = Some(Actions::Trajectories(ControlTrajectories {
        positions: Some(Tensor::pack_points(&[1, 3, 1], &[[0.0; 3]; 3])),
        ..ControlTrajectories::default()
    }));
    request.sigma = Some(Tensor::pack(&[1], &[0f32]));
    let status = planned(&server, request).await.unwrap_err();
    assert_eq!(status.code(), Code::FailedPrecondition, "{status}");
    assert!(status.message().contains("every plan diverged"), "{status}");
}

#[tokio::test]
async fn each_fault_is_refused_over_both_transports() {
    let (server, _worker, twin) = started(Device::default()).await;
    for case in cases::malformed(&TWIN) {
        let mut request = case.request;
        if let Some(rollout) = &mut request.rollout {
            rollout.twin.clone_from(&twin);
        }
        let body = request.encode_to_vec();
        let status = planned(&server, request).await.expect_err(case.what);
        assert!(status.message().contains(case.names), "{}: {status}", case.what);
        let post = server.http.post(server.url("/v1/plans")).body(body);
        let post = post.header("content-type", "application/x-protobuf");
        let (code, problem) = read(post.send().await.unwrap()).await;
        assert!([400, 409].contains(&code), "{}: {problem}", case.what);
        assert!(problem["detail"].as_str().unwrap().contains(case.names), "{}", case.what);
    }
}

#[tokio::test]
async fn over_http_updates_are_events() {
    let (server, _worker, twin) = started(Device::default()).await;
    let body = |positions: serde_json::Value| {
        serde_json::json!({
            "rollout": {
                "twin": twin,
                "trajectories": {"positions": positions},
                "costs": [{"keypoints": {"nodes": [0], "targets": [[0, 0, 0]]}}],
            },
            "samples": 4,
            "seed": 7,
            "sigma": [0.1],
        })
    };
    let good = body(serde_json::json!([[[[0.5, 0, 0]], [[0.5, 0, 0]], [[0.5, 0, 0]]]]));
    let reply = server.http.post(server.url("/v1/plans")).json(&good).send().await.unwrap();
    assert_eq!(reply.headers()["content-type"], "text/event-stream");
    let text = reply.text().await.unwrap();
    let data: Vec<serde_json::Value> = text
        .lines()
        .filter_map(|line| line.strip_prefix("data:"))
        .map(|line| serde_json::from_str(line).unwrap())
        .collect();
    assert_eq!(text.matches("event: update").count(), data.len(), "{text}");
    let last = data.last().unwrap();
    assert_eq!((&last["last"], &last["nominal_cost"]), (&true.into(), &0.75.into()));
    assert!(last["cost"].as_f64().unwrap() <= 0.75 && last["knots"][0][0][0][0] == 0.5);
    let mut diverges = body(serde_json::json!([[[[0, 0, 0]], [[0, 0, 0]]]]));
    diverges["sigma"] = serde_json::json!([0]);
    let reply = server.http.post(server.url("/v1/plans")).json(&diverges).send().await.unwrap();
    let text = reply.text().await.unwrap();
    assert!(text.contains("event: error") && text.contains("EVERY_PLAN_DIVERGED"), "{text}");
    let (code, problem) = server.post("/v1/plans", serde_json::json!({"rollouts": 1})).await;
    assert_eq!(code, 400, "{problem}");
}
