//! Rollouts as a planner uses them: batches, beside a running fit, repeated bit for bit.

use std::time::Duration;

use bendtwin_proto::v1::{
    ControlTrajectories, Cost, Fidelity, GripperPoses, Returns, RollOutRequest, RollOutResponse,
    Tensor, Twin, cost, job::State, roll_out_request::Actions,
};

use crate::harness::{
    Api, Setup, TestCluster,
    api::{fraction, has_ended},
    reference::{ENDLESS, capture, reference},
};

const STATE: Duration = Duration::from_secs(60);
const BATCH: usize = 16;
const FRAMES: usize = 10;

/// A batch that moves all control points together from their rest positions, each instance in
/// another direction.
pub(crate) fn request(twin: &Twin, rest: &[[f32; 3]]) -> RollOutRequest {
    let controls = twin.control_count as usize;
    assert_eq!(rest.len(), controls);
    let mut positions = Vec::new();
    for instance in 0..BATCH {
        for frame in 0..=FRAMES {
            let along = 1e-3 * frame as f32 * (instance as f32 - BATCH as f32 / 2.0);
            positions.extend(rest.iter().map(|p| [p[0] + along, p[1], p[2] + along.abs()]));
        }
    }
    let target = cost::Kind::Keypoints(cost::Keypoints {
        nodes: Some(Tensor::pack::<u32>(&[1], &[0])),
        targets: Some(Tensor::pack_points(&[1], &[[0.0; 3]])),
        squared: false,
        skin_points: None,
    });
    RollOutRequest {
        twin: twin.name.clone(),
        actions: Some(Actions::Trajectories(ControlTrajectories {
            positions: Some(Tensor::pack_points(&[BATCH, FRAMES + 1, controls], &positions)),
            interpolation: 0,
        })),
        costs: vec![Cost { weight: Some(1.0), kind: Some(target), ..Cost::default() }],
        returns: Some(Returns { every_frames: 1, final_state: true, ..Returns::default() }),
        ..RollOutRequest::default()
    }
}

/// Rest positions of the control points of a twin file.
pub(crate) fn rest_controls(file: &[u8]) -> Vec<[f32; 3]> {
    bendtwin_core::Twin::decode(file).unwrap().graph.control_rest
}

/// The parts of a reply that must repeat: everything but the worker and the timing.
fn content(reply: RollOutResponse) -> RollOutResponse {
    RollOutResponse { timing: None, worker: String::new(), ..reply }
}

async fn imported(api: &Api) -> (Twin, Vec<[f32; 3]>) {
    let file = reference().await.file;
    (api.import(&file).await.unwrap(), rest_controls(&file))
}

#[tokio::test]
async fn a_fast_rollout_says_what_answered_and_how_far_it_strays() {
    let server = TestCluster::ordinary().await;
    let api = server.api();
    let (twin, rest) = imported(&api).await;
    let exact = api.roll_out(request(&twin, &rest)).await.unwrap();
    assert_eq!((exact.fidelity(), exact.substeps), (Fidelity::Exact, twin.substeps));
    assert_eq!(exact.deviation, None);
    let wish = RollOutRequest { fidelity: Fidelity::Fast.into(), ..request(&twin, &rest) };
    let fast = api.roll_out(wish.clone()).await.unwrap();
    assert_eq!(fast.fidelity(), Fidelity::Fast);
    assert!((1..=twin.substeps).contains(&fast.substeps), "{}", fast.substeps);
    let deviation = fast.deviation.unwrap();
    assert!(deviation.mean_m <= 1e-3 && deviation.mean_travel_m > 0.0, "{deviation:?}");
    assert_eq!(content(fast), content(api.roll_out(wish).await.unwrap()));

    // A twin file of a build that knew no variants.
    let mut old = bendtwin_core::Twin::decode(&reference().await.file).unwrap();
    old.quality.fast = None;
    let old = api.import(&old.encode().unwrap().into()).await.unwrap();
    let wish = RollOutRequest { fidelity: Fidelity::Fast.into(), ..request(&old, &rest) };
    let refused = api.roll_out(wish).await.unwrap_err();
    assert_eq!(refused.code(), tonic::Code::FailedPrecondition, "{refused}");
}

#[tokio::test]
async fn a_batch_is_answered_and_repeats_bit_for_bit_on_every_worker() {
    let server = TestCluster::ordinary().await;
    let api = server.api();
    let (twin, rest) = imported(&api).await;
    let request = request(&twin, &rest);
    let first = api.roll_out(request.clone()).await.unwrap();
    let (shape, costs) = first.costs.as_ref().unwrap().unpack::<f64>("costs").unwrap();
    assert_eq!(shape, [BATCH]);
    assert!(costs.iter().all(|c| c.is_finite()), "{costs:?}");
    let shape = first.positions.as_ref().unwrap().checked_shape("positions").unwrap();
    assert_eq!(shape, [BATCH, FRAMES, twin.node_count as usize, 3]);
    let moved = costs.iter().any(|c| (c - costs[0]).abs() > 1e-9);
    assert!(moved, "different actions cost the same: {costs:?}");

    let again = api.roll_out(request.clone()).await.unwrap();
    assert_eq!(content(first.clone()), content(again));

    server.kill_workers();
    let on_a_new_worker = retried(&api, &request).await;
    assert_ne!(first.worker, on_a_new_worker.worker);
    assert_eq!(content(first), content(on_a_new_worker));
}

#[tokio::test]
async fn a_streamed_batch_is_the_unary_one_in_parts() {
    let server = TestCluster::ordinary().await;
    let api = server.api();
    let (twin, rest) = imported(&api).await;
    let request = request(&twin, &rest);
    let whole = api.roll_out(request.clone()).await.unwrap();
    let whole = whole.costs.unwrap().unpack::<f64>("costs").unwrap().1;
    let mut parts = api.rollouts().stream_roll_out(request).await.unwrap().into_inner();
    let mut costs = Vec::new();
    while let Some(part) = parts.message().await.unwrap() {
        assert_eq!(part.first_instance as usize, costs.len());
        costs.extend(part.costs.unwrap().unpack::<f64>("costs").unwrap().1);
    }
    assert_eq!(costs, whole);
}

#[tokio::test]
async fn a_gripper_that_does_not_turn_is_a_translation() {
    let server = TestCluster::ordinary().await;
    let api = server.api();
    let (twin, rest) = imported(&api).await;
    let step = |frame: usize| 2e-3 * frame as f32;
    let shifted = |f| rest.iter().map(move |p| [p[0] + step(f), p[1], p[2] + step(f)]);
    let positions: Vec<_> = (0..=FRAMES).flat_map(shifted).collect();
    let poses: Vec<f32> = (0..=FRAMES)
        .flat_map(|f| [0.3 + step(f), 0.1, 0.2 + step(f), 0.0, 0.0, 0.0, 1.0])
        .collect();
    let by_positions = RollOutRequest {
        actions: Some(Actions::Trajectories(ControlTrajectories {
            positions: Some(Tensor::pack_points(&[1, FRAMES + 1, rest.len()], &positions)),
            interpolation: 0,
        })),
        ..request(&twin, &rest)
    };
    let by_poses = RollOutRequest {
        actions: Some(Actions::Poses(GripperPoses {
            poses: Some(Tensor::pack(&[1, FRAMES + 1, 1, 7], &poses)),
            ..GripperPoses::default()
        })),
        ..by_positions.clone()
    };
    let end = async |request| {
        let reply = api.roll_out(request).await.unwrap();
        reply.final_positions.unwrap().unpack_points("final").unwrap().1
    };
    let (a, b) = (end(by_positions).await, end(by_poses).await);
    let apart = a.iter().flatten().zip(b.iter().flatten()).map(|(x, y)| (x - y).abs());
    // Rotating by the identity rounds once per coordinate; the motion amplifies that a little.
    assert!(apart.fold(0.0, f32::max) < 1e-4);
}

#[tokio::test]
async fn rollouts_are_answered_while_a_fit_runs() {
    let server = TestCluster::start(Setup::default()).await;
    let api = server.api();
    let (twin, rest) = imported(&api).await;
    let request = request(&twin, &rest);
    let expected = content(api.roll_out(request.clone()).await.unwrap());

    let capture = api.upload(&capture().await, "").await.unwrap();
    let fit = api.fit(&capture.name, ENDLESS, 0).await.unwrap();
    let running = |f: &_| fraction(f) > 0.0 && f.state() == State::Running;
    let before = api.fit_when(&fit.name, "running", STATE, running).await;
    for _ in 0..15 {
        assert_eq!(content(api.roll_out(request.clone()).await.unwrap()), expected);
    }
    // The fit has no end, so none of the rollouts waited for it.
    let after = api.get_fit(&fit.name).await.unwrap();
    assert_eq!(after.state(), State::Running);
    assert_eq!(after.job.as_ref().unwrap().attempts, 1);
    assert!(fraction(&after) >= fraction(&before));
    api.cancel(&fit.name).await.unwrap();
    api.fit_when(&fit.name, "cancelled", STATE, has_ended).await;
}

/// The response of any worker: a planner repeats calls that were UNAVAILABLE.
async fn retried(api: &Api, request: &RollOutRequest) -> RollOutResponse {
    crate::harness::until("a worker that answers", STATE, async || {
        match api.roll_out(request.clone()).await {
            Ok(reply) => Some(reply),
            Err(status) => {
                assert_eq!(status.code(), tonic::Code::Unavailable, "{status:?}");
                None
            }
        }
    })
    .await
}
