//! Places to grasp, searched together with the motion. The cost of a plan is the sum of the squares of its
//! poses, so that the nearest place to the origin is the cheapest; the force of a grasp is least at 0.3 m.

use std::sync::Arc;

use bendtwin_contract_kit::plan as cases;
use bendtwin_proto::v1::{
    GraspSearch, GripperPoses, InitialState, OpenSessionRequest, PlanMethod, PlanRequest,
    PlanUpdate, Plausibility, StepSessionRequest, Tensor,
    initial_state::{SessionSlots, State},
    plan_method::{Cem, Gradient, Method, Mppi, PredictiveSampling},
    roll_out_request::Actions,
    session_service_client::SessionServiceClient,
};
use serde_json::{Value, json};
use tokio::sync::Notify;
use tonic::Code;

use super::plans::{TWIN, planned, started};
use crate::worker::{Device, grasps::force_n};

/// The nominal plan lifts the gripper from x = 1 m by 0.3 m, and turns it.
fn nominal() -> Vec<[f32; 7]> {
    let half = std::f32::consts::FRAC_1_SQRT_2;
    vec![
        [1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0],
        [1.0, 0.0, 0.1, 0.0, 0.0, 0.0, 1.0],
        [1.0, 0.0, 0.3, 0.0, 0.0, half, half],
    ]
}

fn poses(shape: &[usize], rows: &[[f32; 7]]) -> Option<Tensor> {
    Some(Tensor::pack(shape, rows.as_flattened()))
}

/// A search of places along x.
fn request(twin: &str, places: &[f32]) -> PlanRequest {
    let mut request = cases::sound_with_places(&TWIN);
    let rollout = request.rollout.as_mut().unwrap();
    rollout.twin = twin.to_owned();
    rollout.actions = Some(Actions::Poses(GripperPoses {
        poses: poses(&[1, 3, 1, 7], &nominal()),
        ..GripperPoses::default()
    }));
    let rows: Vec<[f32; 7]> = places.iter().map(|x| [*x, 0.0, 0.0, 0.0, 0.0, 0.0, 2.0]).collect();
    let search = GraspSearch { poses: poses(&[places.len(), 1, 7], &rows), grippers: vec![0] };
    PlanRequest { grasp_search: Some(search), samples: 32, iterations: 8, ..request }
}

fn with(mut request: PlanRequest, plausibility: Plausibility) -> PlanRequest {
    request.rollout.as_mut().unwrap().plausibility = Some(plausibility);
    request
}

fn rows(update: &PlanUpdate) -> Vec<[f32; 7]> {
    let (shape, values) = update.knots.as_ref().unwrap().unpack::<f32>("knots").unwrap();
    assert_eq!(shape, [1, 3, 1, 7]);
    values.as_chunks::<7>().0.to_vec()
}

fn costs(update: &PlanUpdate) -> Vec<f64> {
    update.grasp_costs.as_ref().unwrap().unpack::<f64>("grasp_costs").unwrap().1
}

/// Cost of rows of poses, as the device has it.
fn squares(rows: &[[f32; 7]]) -> f64 {
    rows.iter().flatten().map(|x| f64::from(*x).powi(2)).sum()
}

const PLACES: [f32; 5] = [0.4, 0.2, 0.9, 0.1, 0.45];

#[tokio::test]
async fn every_method_finds_the_cheapest_place_that_holds_something() {
    let (server, _worker, twin) = started(Device::default()).await;
    let methods = [
        Method::Mppi(Mppi::default()),
        Method::Cem(Cem::default()),
        Method::PredictiveSampling(PredictiveSampling {}),
        Method::Gradient(Gradient { rate: Some(Tensor::pack(&[1], &[0.05f32])) }),
    ];
    for method in methods {
        let method = Some(PlanMethod { method: Some(method) });
        let request = PlanRequest { method, ..request(&twin, &PLACES) };
        let updates = planned(&server, request).await.unwrap();
        let all: Vec<f64> = updates.iter().map(|update| update.cost).collect();
        assert!(all.is_sorted_by(|a, b| a >= b), "{all:?}");
        for update in &updates {
            let costs = costs(update);
            assert_eq!(costs[update.grasp.unwrap() as usize], update.cost);
            assert_eq!(costs.len(), 5);
            // At 0.9 m there is nothing to hold.
            assert_eq!(costs[2], f64::INFINITY);
            let x = rows(update)[0][0];
            assert_eq!(x, PLACES[update.grasp.unwrap() as usize]);
            assert!((update.cost - squares(&rows(update))).abs() < 1e-9);
        }
        let last = updates.last().unwrap();
        assert_eq!((last.grasp, last.iterations), (Some(3), 8));
        assert!(last.cost < last.nominal_cost && last.diverged > 0, "{last:?}");
        // The plan of a place begins as the nominal plan moves: lifted by 0.3 m, and turned.
        let moved: Vec<[f32; 7]> =
            nominal().into_iter().map(|p| [&[0.1], &p[1..]].concat().try_into().unwrap()).collect();
        assert!((last.nominal_cost - squares(&moved)).abs() < 1e-6, "{}", last.nominal_cost);
        let force = force_n(f64::from(PLACES[3])).unwrap();
        assert_eq!((last.grasp_force_n, last.grasp_force_limit_n), (Some(force), None));
        assert!(last.simulated <= 8 * 32 + 1);
    }
}

#[tokio::test]
async fn limits_of_force_and_strain_decide_between_places() {
    let (server, _worker, twin) = started(Device::default()).await;
    let limited = |newtons| {
        let grasp_force_n = Some(newtons);
        with(request(&twin, &PLACES), Plausibility { grasp_force_n, ..Plausibility::default() })
    };
    let last = |updates: Vec<PlanUpdate>| updates.last().unwrap().clone();
    // Forces, counted by hand: 1.1, 1.1, 2.1 and 1.6 N.
    for (limit, place) in [(3.0, 3), (1.2, 1)] {
        let found = last(planned(&server, limited(limit)).await.unwrap());
        assert_eq!((found.grasp, found.grasp_force_limit_n), (Some(place), Some(limit)));
        assert!(found.grasp_force_n.unwrap() <= limit, "{found:?}");
        assert_eq!(found.overstrained > 0, limit < 2.0);
    }
    // Where none is within, the least beyond wins: 0.2 and 0.4 m are alike, and 0.2 m is cheaper.
    let found = last(planned(&server, limited(0.5)).await.unwrap());
    assert_eq!(found.grasp, Some(1));
    assert!(found.grasp_force_n.unwrap() > 0.5);
    // With `refuse` it is an error.
    let mut refused = limited(0.5);
    refused.rollout.as_mut().unwrap().plausibility.as_mut().unwrap().refuse = true;
    let status = planned(&server, refused).await.unwrap_err();
    assert!(status.message().contains("every plan diverged"), "{status}");
    // Without places the limit counts as well, and the force is reported.
    let plain = PlanRequest { grasp_search: None, ..limited(3.0) };
    let status = last(planned(&server, plain).await.unwrap());
    assert_eq!((status.grasp, status.grasp_costs), (None, None));
    assert_eq!((status.grasp_force_n, status.grasp_force_limit_n), (Some(0.0), Some(3.0)));
}

#[tokio::test]
async fn places_that_hold_nothing_are_named() {
    let (server, _worker, twin) = started(Device::default()).await;
    let status = planned(&server, request(&twin, &[0.6, 0.7, 0.8])).await.unwrap_err();
    assert_eq!(status.code(), Code::FailedPrecondition, "{status}");
    assert!(status.message().contains("no plan grasps anything"), "{status}");
}

#[tokio::test]
async fn the_same_seed_finds_the_same_and_a_deadline_ends_it() {
    let (server, _worker, twin) = started(Device::default()).await;
    let seeded = |seed| PlanRequest { seed, ..request(&twin, &PLACES) };
    let last = |updates: Vec<PlanUpdate>| updates.last().unwrap().clone();
    let first = last(planned(&server, seeded(3)).await.unwrap());
    let second = last(planned(&server, seeded(3)).await.unwrap());
    assert_eq!((&first.knots, &first.grasp_costs), (&second.knots, &second.grasp_costs));
    assert_ne!(first.knots, last(planned(&server, seeded(4)).await.unwrap()).knots);

    let hold = Arc::new(Notify::new());
    let device = Device { hold: Some(hold.clone()), ..Device::default() };
    let (server, _worker, twin) = started(device.clone()).await;
    // One batch passes, the next one hangs.
    hold.notify_one();
    let in_time = PlanRequest { deadline_s: 1.0, ..request(&twin, &PLACES) };
    let stopped = last(planned(&server, in_time).await.unwrap());
    assert!(stopped.last && stopped.stopped_by_deadline && stopped.grasp.is_some());
    assert_eq!((stopped.iterations, stopped.simulated), (1, 32));
    // Dropping the stream stops the work.
    let stream = server.planning().plan(request(&twin, &PLACES)).await.unwrap();
    device.begun.notified().await;
    drop(stream);
    tokio::time::timeout(std::time::Duration::from_secs(60), device.given_up.notified())
        .await
        .unwrap();
}

#[tokio::test]
async fn slots_that_hold_something_are_refused_and_others_are_stepped() {
    let (server, _worker, twin) = started(Device::default()).await;
    let mut sessions = SessionServiceClient::new(server.channel.clone());
    let open = OpenSessionRequest { twin, slots: 2, ..OpenSessionRequest::default() };
    let session = sessions.open_session(open).await.unwrap().into_inner().name;
    let from = |slot: u32| {
        let mut request = request("", &PLACES);
        let slots = SessionSlots { session: session.clone(), slots: vec![slot] };
        let initial = Some(InitialState { state: Some(State::Session(slots)) });
        request.rollout.as_mut().unwrap().initial = initial;
        request
    };
    let found = planned(&server, from(0)).await.unwrap();
    assert_eq!(found.last().unwrap().grasp, Some(3));
    // The device says that grasp 0 of slot 1 is closed.
    let status = planned(&server, from(1)).await.unwrap_err();
    assert_eq!(status.code(), Code::InvalidArgument, "{status}");
    assert!(status.message().contains("gripper 0"), "{status}");
    let mut opened = from(1);
    let grasps = &mut opened.rollout.as_mut().unwrap().grasps;
    grasps[0].closed = Some(Tensor::pack(&[3], &[0u32, 1, 1]));
    assert_eq!(planned(&server, opened).await.unwrap().last().unwrap().grasp, Some(3));
    // A step plans from a place, and advances from there.
    let step = |slot| {
        let mut search = from(slot);
        search.rollout.as_mut().unwrap().initial = None;
        StepSessionRequest {
            name: session.clone(),
            slot,
            search: Some(search),
            execute_frames: 1,
            ..StepSessionRequest::default()
        }
    };
    let stepped = sessions.step_session(step(0)).await.unwrap().into_inner();
    assert_eq!(stepped.plan.unwrap().grasp, Some(3));
    assert!(stepped.advanced.is_some());
    let status = sessions.step_session(step(1)).await.unwrap_err();
    assert!(status.message().contains("gripper 0"), "{status}");
}

#[tokio::test]
async fn over_http_places_are_lists() {
    let (server, _worker, twin) = started(Device::default()).await;
    let pose = |x: f64| json!([[x, 0, 0, 0, 0, 0, 1]]);
    let body = json!({
        "rollout": {
            "twin": twin,
            "poses": {"poses": [[pose(1.0), pose(1.0), pose(1.0)]]},
            "grasps": [{"sphere": {"radius_m": 0.03}}],
            "costs": [{"keypoints": {"nodes": [0], "targets": [[0, 0, 0]]}}],
        },
        "grasp_search": {"poses": [pose(0.4), pose(0.9), pose(0.25)]},
        "samples": 12,
    });
    let reply = server.http.post(server.url("/v1/plans")).json(&body).send().await.unwrap();
    let text = reply.text().await.unwrap();
    let mut data = text.lines().filter_map(|line| line.strip_prefix("data:"));
    let last: Value = serde_json::from_str(data.next_back().unwrap()).unwrap();
    assert_eq!((&last["grasp"], &last["last"]), (&json!(2), &json!(true)), "{last}");
    assert_eq!(last["knots"][0][0][0][0], json!(0.25), "{last}");
    assert_eq!(last["grasp_costs"].as_array().map(Vec::len), Some(3));
}
