//! Steps of closed loops: a correction, a plan and an advance in one call.

use std::sync::{Arc, atomic::Ordering};

use bendtwin_proto::{
    fault::fault,
    v1::{
        ControlTrajectories, CorrectSessionRequest, Cost, Ensemble, InitialState, KnotTimes,
        Observation, OpenSessionRequest, PlanRequest, Returns, RollOutRequest, StepSessionRequest,
        SteppedSession, Tensor,
        cost::{Keypoints, Kind},
        knot_times::Times,
        roll_out_request::Actions,
        session_service_client::SessionServiceClient,
    },
    worker::v1::manage_session_request::Call,
};
use prost::Message as _;
use serde_json::{Value, json};
use tokio::sync::Notify;
use tonic::{Code, Status, transport::Channel};

use super::rollouts::twin;
use crate::{
    harness::{Server, read},
    worker::{Device, Worker},
};

/// A server with a worker whose costs are lowest at the origin, and a session of two slots there.
struct Loop {
    server: Server,
    _worker: Worker,
    device: Device,
    session: String,
}

impl Loop {
    async fn start(device: Device) -> Self {
        let server = Server::start().await;
        let device = Device { bowl: true, ..device };
        let mut worker = Worker::register_with(&server, device.clone()).await;
        let twin = twin(&server, &mut worker).await;
        let open = OpenSessionRequest { twin, slots: 2, ..OpenSessionRequest::default() };
        let opened = sessions(&server).open_session(open).await.unwrap().into_inner();
        Self { server, _worker: worker, device, session: opened.name }
    }

    /// A step of slot 1: a plan of twelve frames, of which three are executed.
    fn request(&self) -> StepSessionRequest {
        let positions = Some(Tensor::pack_points(&[1, 3, 1], &[[0.4; 3]; 3]));
        let actions = ControlTrajectories { positions, ..ControlTrajectories::default() };
        let keypoints = Keypoints {
            nodes: Some(Tensor::pack(&[1], &[0u32])),
            targets: Some(Tensor::pack_points(&[1], &[[0.0; 3]])),
            ..Keypoints::default()
        };
        let rollout = RollOutRequest {
            actions: Some(Actions::Trajectories(actions)),
            frames: 12,
            costs: vec![Cost { kind: Some(Kind::Keypoints(keypoints)), ..Cost::default() }],
            ..RollOutRequest::default()
        };
        let search = PlanRequest {
            rollout: Some(rollout),
            samples: 16,
            iterations: 2,
            ..Default::default()
        };
        StepSessionRequest {
            name: self.session.clone(),
            slot: 1,
            correction: Some(seen([0.1; 3])),
            search: Some(search),
            execute_frames: 3,
            ..StepSessionRequest::default()
        }
    }

    async fn step(&self, request: StepSessionRequest) -> Result<SteppedSession, Status> {
        let stepped = sessions(&self.server).step_session(request).await;
        stepped.map(tonic::Response::into_inner)
    }

    async fn post(&self, body: Vec<u8>) -> (u16, Value) {
        let url = self.server.url(&format!("/v1/{}/step", self.session));
        let post = self.server.http.post(url).body(body);
        read(post.header("content-type", "application/x-protobuf").send().await.unwrap()).await
    }

    /// Calls that changed or asked for states since the session was opened.
    fn calls(&self) -> Vec<&'static str> {
        let calls = self.device.sessions.lock().unwrap();
        let names = calls.iter().map(|call| match call {
            Call::Open(_) => "open",
            Call::Correct(_) => "correct",
            Call::States(_) => "states",
            _ => "other",
        });
        names.skip(1).collect()
    }

    fn advances(&self) -> usize {
        self.device.advances.lock().unwrap().len()
    }
}

fn sessions(server: &Server) -> SessionServiceClient<Channel> {
    SessionServiceClient::new(server.channel.clone())
}

/// A correction by a point.
fn seen(point: [f32; 3]) -> CorrectSessionRequest {
    let points = Some(Tensor::pack_points(&[1], &[point]));
    let observation = Some(Observation { points, ..Observation::default() });
    CorrectSessionRequest { observation, ..CorrectSessionRequest::default() }
}

fn points(tensor: &Option<Tensor>) -> (Vec<usize>, Vec<[f32; 3]>) {
    tensor.as_ref().unwrap().unpack_points("points").unwrap()
}

#[tokio::test]
async fn a_step_corrects_plans_and_advances() {
    let looped = Loop::start(Device::default()).await;
    let stepped = looped.step(looped.request()).await.unwrap();
    let [correction] = &stepped.corrected.unwrap().corrections[..] else { panic!() };
    assert_eq!((correction.slot, correction.moved_mm), (1, 1.0));
    assert_eq!(stepped.refused, None);
    let plan = stepped.plan.unwrap();
    assert!(plan.last && !plan.stopped_by_deadline && plan.cost <= plan.nominal_cost);
    // Row 0 is where the session is.
    let (_, knots) = points(&plan.knots);
    assert_eq!(knots[0], [0.5, 0.0, 0.0]);
    // The slot is corrected before the plan asks where it is.
    assert_eq!(looped.calls(), ["correct", "states"]);
    let advance = looped.device.advances.lock().unwrap()[0].clone();
    assert_eq!(advance.commit_slots, [1]);
    let rollout = advance.request.unwrap();
    assert_eq!((rollout.frames, rollout.costs.len(), rollout.fidelity), (3, 0, 0));
    // The knots of the plan, at the times that they have over its horizon.
    let Some(Actions::Trajectories(executed)) = rollout.actions else { panic!() };
    assert_eq!(executed.positions, plan.knots);
    let Some(Times::PeriodS(period)) = rollout.knot_times.unwrap().times else { panic!() };
    assert!((period - 6.0 / 30.0).abs() < 1e-12, "{period}");
    // The state is that in which they end, and comes once.
    let advanced = stepped.advanced.unwrap();
    assert_eq!((&advanced.final_positions, &advanced.final_controls), (&None, &None));
    let state = stepped.state.unwrap();
    assert_eq!(points(&state.positions), (vec![1], vec![knots[2]]));
    assert_eq!(state.controls.unwrap().shape, [1, 3]);
    let times = stepped.times.unwrap();
    assert!(times.plan_s > 0.0 && times.advance_s > 0.0 && times.correct_s > 0.0);
    assert!(times.total_s >= times.correct_s + times.plan_s + times.advance_s);
    // If requested, the final state is also in the rollout.
    let returns = Some(Returns { final_state: true, ..Returns::default() });
    let request = StepSessionRequest { returns, correction: None, ..looped.request() };
    let stepped = looped.step(request).await.unwrap();
    assert_eq!((&stepped.corrected, stepped.advanced.is_some()), (&None, true));
    assert_eq!(points(&stepped.advanced.unwrap().final_positions).0, [1, 1]);
}

#[tokio::test]
async fn the_same_over_http() {
    let looped = Loop::start(Device::default()).await;
    let body = json!({
        "slot": 1,
        "correction": {"observation": {"points": [[0.1, 0.1, 0.1]]}},
        "search": {
            "rollout": {
                "trajectories": {"positions": [[[[0.5, 0, 0]], [[0.5, 0, 0]], [[0.5, 0, 0]]]]},
                "frames": 12,
                "costs": [{"keypoints": {"nodes": [0], "targets": [[0, 0, 0]]}}],
            },
            "samples": 8,
        },
        "execute_frames": 3,
        "deadline_s": 30.0,
    });
    let path = format!("/v1/{}/step", looped.session);
    let (status, stepped) = looped.server.post(&path, body.clone()).await;
    assert_eq!(status, 200, "{stepped}");
    assert_eq!(stepped["corrected"]["corrections"][0]["slot"], 1);
    assert_eq!(stepped["plan"]["last"], true);
    assert_eq!(stepped["state"]["positions"][0], stepped["plan"]["knots"][0][2][0]);
    assert!(stepped["times"]["total_s"].as_f64().unwrap() > 0.0);
    let mut far = body;
    far["correction"]["observation"]["points"][0][0] = json!(850.0);
    let (status, stepped) = looped.server.post(&path, far).await;
    assert_eq!((status, &stepped["refused"]["reason"]), (200, &json!("OBSERVATION_NOT_EXPLAINED")));
    assert_eq!(looped.advances(), 2);
}

#[tokio::test]
async fn after_a_refused_correction_the_step_continues_from_the_prediction() {
    let looped = Loop::start(Device::default()).await;
    for (far, reason) in [(850.0, "OBSERVATION_NOT_EXPLAINED"), (950.0, "OBJECT_LOST")] {
        let request = StepSessionRequest { correction: Some(seen([far; 3])), ..looped.request() };
        let stepped = looped.step(request).await.unwrap();
        assert_eq!(stepped.refused.unwrap().reason, reason);
        assert_eq!((stepped.corrected, stepped.lost), (None, reason == "OBJECT_LOST"));
        assert!(stepped.plan.is_some() && stepped.state.is_some());
    }
    assert_eq!(looped.advances(), 2);
}

#[tokio::test]
async fn without_frames_to_execute_the_slot_stays() {
    let looped = Loop::start(Device::default()).await;
    let request = StepSessionRequest { execute_frames: 0, ..looped.request() };
    let stepped = looped.step(request).await.unwrap();
    assert_eq!((stepped.advanced, looped.advances()), (None, 0));
    assert_eq!(points(&stepped.state.unwrap().positions), (vec![1], vec![[1.0, 2.0, 3.0]]));
}

#[tokio::test]
async fn if_the_advance_diverges_the_state_is_where_the_plan_began() {
    let looped = Loop::start(Device { diverges: true, ..Device::default() }).await;
    let stepped = looped.step(looped.request()).await.unwrap();
    assert_eq!(stepped.advanced.unwrap().diverged.len(), 1);
    assert_eq!(points(&stepped.state.unwrap().positions), (vec![1], vec![[1.0, 2.0, 3.0]]));
}

#[tokio::test]
async fn at_the_deadline_the_best_so_far_is_executed() {
    let hold = Arc::new(Notify::new());
    // Batches of samples wait, the advance does not.
    let device = Device { hold: Some(hold.clone()), hold_above: 1, ..Device::default() };
    let looped = Loop::start(device).await;
    hold.notify_one();
    let mut request = StepSessionRequest { deadline_s: 1.0, ..looped.request() };
    request.search.as_mut().unwrap().iterations = 10;
    let stepped = looped.step(request).await.unwrap();
    let plan = stepped.plan.unwrap();
    assert!(plan.stopped_by_deadline && plan.last && plan.iterations == 1, "{plan:?}");
    assert!(stepped.advanced.is_some() && looped.advances() == 1);
}

#[tokio::test]
async fn a_worker_that_breaks_off_in_the_search_has_not_advanced_the_slot() {
    let looped = Loop::start(Device::default()).await;
    looped.device.breaks.store(true, Ordering::SeqCst);
    let status = looped.step(looped.request()).await.unwrap_err();
    assert_eq!(fault(&status).reason, "SESSION_LOST", "{status}");
    assert_eq!((looped.calls(), looped.advances()), (vec!["correct", "states"], 0));
}

#[tokio::test]
async fn what_is_wrong_is_refused_over_both_transports_before_anything_changes() {
    let looped = Loop::start(Device::default()).await;
    let with = |change: &dyn Fn(&mut StepSessionRequest)| {
        let mut request = looped.request();
        change(&mut request);
        request
    };
    let search = |change: &dyn Fn(&mut PlanRequest)| {
        with(&|request| request.search.as_mut().map(change).unwrap())
    };
    let rollout = |change: &dyn Fn(&mut RollOutRequest)| {
        search(&|search| search.rollout.as_mut().map(change).unwrap())
    };
    let returns = |returns: Returns| with(&|request| request.returns = Some(returns.clone()));
    let correction = |change: &dyn Fn(&mut CorrectSessionRequest)| {
        with(&|request| request.correction.as_mut().map(change).unwrap())
    };
    let cases = [
        ("`slot`", with(&|r| r.slot = 2)),
        ("`search`", with(&|r| r.search = None)),
        ("`search.rollout`", search(&|s| s.rollout = None)),
        ("`search.rollout.initial`", rollout(&|r| r.initial = Some(InitialState::default()))),
        ("`search.rollout.returns`", rollout(&|r| r.returns = Some(Returns::default()))),
        ("`twin`", rollout(&|r| r.twin = "twins/0190a000-0000-7000-8000-00000000dead".into())),
        ("`rollout.costs`", rollout(&|r| r.costs.clear())),
        ("`sigma`", search(&|s| s.sigma = Some(Tensor::pack(&[1], &[-1f32])))),
        ("`execute_frames`", with(&|r| r.execute_frames = 13)),
        ("`deadline_s`", with(&|r| r.deadline_s = -1.0)),
        ("`deadline_s`", with(&|r| r.deadline_s = f64::NAN)),
        ("`correction`", correction(&|c| c.slots = vec![0])),
        ("`correction`", correction(&|c| c.name = "sessions/x".into())),
        ("`observation`", correction(&|c| c.observation = None)),
        ("`returns.best`", returns(Returns { best: 1, ..Returns::default() })),
        ("`returns.part_frames`", returns(Returns { part_frames: 1, ..Returns::default() })),
        (
            "`returns.nodes`",
            returns(Returns {
                nodes: Some(Tensor::pack(&[1], &[5u32])),
                every_frames: 1,
                ..Returns::default()
            }),
        ),
    ];
    for (names, request) in cases {
        let body = StepSessionRequest { name: String::new(), ..request.clone() }.encode_to_vec();
        let status = looped.step(request).await.expect_err(names);
        assert_eq!(status.code(), Code::InvalidArgument, "{names}: {status}");
        assert!(status.message().contains(names), "{names}: {status}");
        let (code, problem) = looped.post(body).await;
        assert_eq!(code, 400, "{names}: {problem}");
        assert!(problem["detail"].as_str().unwrap().contains(names), "{names}: {problem}");
    }
    assert_eq!((looped.calls(), looped.advances()), (vec![], 0));
    let gone = "sessions/0190a000-0000-7000-8000-00000000dead";
    let status = looped.step(with(&|r| r.name = gone.into())).await.unwrap_err();
    assert_eq!(fault(&status).reason, "SESSION_LOST");
}

#[tokio::test]
async fn an_ensemble_and_knots_at_their_own_times_are_executed_as_planned() {
    let looped = Loop::start(Device::default()).await;
    let mut request = looped.request();
    let rollout = request.search.as_mut().unwrap().rollout.as_mut().unwrap();
    rollout.ensemble = Some(Ensemble { members: 1, ..Ensemble::default() });
    let times = Some(KnotTimes { times: Some(Times::PeriodS(0.1)) });
    rollout.knot_times.clone_from(&times);
    looped.step(request).await.unwrap();
    let advance = looped.device.advances.lock().unwrap()[0].request.clone().unwrap();
    assert_eq!((advance.ensemble, advance.knot_times), (None, times));
}
