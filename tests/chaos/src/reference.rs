//! Answers of an undisturbed server of the same binary: twins of some captures, and rollouts of one
//! of these twins. Everything that the disturbed server answers is compared with it.

use std::{ops::RangeInclusive, path::Path, time::Duration};

use bendtwin_harness::{
    Api, Isolation, Setup, TestCluster, command::run_ok, http::Http, reference::FIT,
};
use bendtwin_proto::{
    json::{TensorFormat, Write},
    v1::{
        ControlTrajectories, Cost, Returns, RollOutRequest, RollOutResponse, Tensor, cost,
        initial_state::GivenState, roll_out_request::Actions,
    },
};
use bytes::Bytes;
use reqwest::Method;
use serde_json::Value;

/// A fit of well under a second, and one of seconds, which kills meet at its work.
const SETTINGS: [&str; 2] = [
    r#"{"graph": {"max_nodes": 20}, "search": {"generations": 1}, "refine": {"passes": 1}}"#,
    r#"{"seed": 11, "graph": {"max_nodes": 40},
        "search": {"starts": 1, "generations": 60, "population": 8}, "refine": {"passes": 20}}"#,
];
/// Captures: the arguments of `bendtwin capture make`. Those after the first `FITTED` are uploaded
/// and read, but not fitted.
const CAPTURES: [&[&str]; 5] = [
    &["rope", "--tiny", "--seed", "1"],
    &["cable", "--tiny", "--seed", "2"],
    &["rope", "--tiny", "--seed", "3", "--frames", "12"],
    &["bar", "--tiny", "--seed", "4"],
    &["toy", "--tiny", "--seed", "5", "--raw"],
];
const FITTED: usize = 3;
const FRAMES: usize = 10;
/// Slots of sessions.
const SLOTS: usize = 3;

/// An archive of a capture.
#[derive(Clone, Debug)]
pub(crate) struct Archive {
    /// Name under which it is uploaded to be fitted: it becomes part of the twin.
    pub(crate) name: String,
    pub(crate) content: Bytes,
    /// BLAKE3.
    pub(crate) digest: String,
}

/// A fit and its result.
#[derive(Clone, Debug)]
pub(crate) struct Work {
    /// Number of the archive.
    pub(crate) archive: usize,
    pub(crate) settings: &'static str,
    /// The twin file.
    pub(crate) twin: Bytes,
    /// BLAKE3.
    pub(crate) digest: String,
}

/// A rollout and its result.
#[derive(Clone, Debug)]
pub(crate) struct Rollout {
    /// The request without a twin.
    pub(crate) request: RollOutRequest,
    pub(crate) reply: RollOutResponse,
    /// The request as JSON.
    pub(crate) body: String,
    pub(crate) document: Value,
}

/// A rollout in steps of a frame, and the state that it ends in as a whole.
#[derive(Clone, Debug)]
pub(crate) struct Walk {
    /// Requests without a twin, with an instance for each slot.
    pub(crate) steps: Vec<RollOutRequest>,
    pub(crate) slots: u32,
    pub(crate) end: GivenState,
}

/// Results of an undisturbed server.
#[derive(Clone, Debug)]
pub(crate) struct References {
    pub(crate) archives: Vec<Archive>,
    pub(crate) works: Vec<Work>,
    pub(crate) rollouts: Vec<Rollout>,
    pub(crate) walk: Walk,
    /// Rest positions of the control points of the twin [m], shape [control, 3].
    controls: Vec<[f32; 3]>,
}

impl References {
    /// Starts a server and asks it. What fails here is no matter of faults, so it panics.
    pub(crate) async fn make(folder: &Path) -> anyhow::Result<Self> {
        let archives = CAPTURES.into_iter().map(|arguments| archive(folder, arguments));
        let archives: Vec<Archive> = archives.collect::<anyhow::Result<_>>()?;
        let setup = Setup {
            own_workers: 2,
            isolation: Isolation::Nested,
            // As the disturbed ones: a GPU has other last bits.
            worker_args: &["--backend", "cpu"],
            ..Setup::default()
        };
        let cluster = TestCluster::start(setup).await;
        let api = cluster.api();
        let mut fits = Vec::new();
        for (number, archive) in archives.iter().enumerate().take(FITTED) {
            let capture = api.upload_as(&archive.content, &archive.name, "").await?;
            for settings in SETTINGS {
                fits.push((number, settings, api.fit(&capture.name, settings, 0).await?.name));
            }
        }
        let mut works = Vec::new();
        for (archive, settings, fit) in fits {
            let fit = api.succeeded(&fit, FIT).await;
            let digest = api.get_twin(&fit.twin).await?.digest;
            let twin = api.export(&fit.twin).await?;
            works.push(Work { archive, settings, twin, digest });
        }
        let controls = bendtwin_core::Twin::decode(&works[1].twin)?.graph.control_rest;
        let rollouts = rollouts(&api, &cluster.http(), &works[1].twin, &controls).await?;
        let walk = walk(&api, &works[1].twin, &controls).await?;
        Ok(Self { archives, works, rollouts, walk, controls })
    }

    /// A batch of any size for the twin.
    pub(crate) fn batch(&self, twin: String, batch: usize, frames: usize) -> RollOutRequest {
        RollOutRequest { twin, ..request(&self.controls, batch, frames) }
    }

    /// The twin of the rollouts: its file.
    pub(crate) fn twin(&self) -> &Bytes {
        &self.works[1].twin
    }
}

fn archive(folder: &Path, arguments: &[&str]) -> anyhow::Result<Archive> {
    let name = format!("{}-{}", arguments[0], arguments[3]);
    let path = folder.join(format!("{name}.zip")).to_string_lossy().into_owned();
    let mut all = vec!["capture", "make", arguments[0], path.as_str()];
    all.extend(&arguments[1..]);
    run_ok(&all);
    let content = Bytes::from(std::fs::read(&path)?);
    let digest = blake3::hash(&content).to_hex().to_string();
    Ok(Archive { name, content, digest })
}

async fn rollouts(
    api: &Api,
    http: &Http,
    file: &Bytes,
    controls: &[[f32; 3]],
) -> anyhow::Result<Vec<Rollout>> {
    let twin = api.import(file).await?.name;
    let mut rollouts = Vec::new();
    for request in requests(controls) {
        let body =
            serde_json::to_string(&Write { message: &request, tensors: TensorFormat::Lists })?;
        let reply = api.roll_out(RollOutRequest { twin: twin.clone(), ..request.clone() }).await?;
        let document = http
            .request(Method::POST, &format!("/v1/{twin}/rollouts"))
            .header("content-type", "application/json")
            .timeout(Duration::from_secs(60))
            .body(body.clone());
        let document = document.send().await?.error_for_status()?.json().await?;
        let (reply, document) = (lasting(reply), lasting_document(document));
        rollouts.push(Rollout { request, reply, body, document });
    }
    Ok(rollouts)
}

async fn walk(api: &Api, file: &Bytes, controls: &[[f32; 3]]) -> anyhow::Result<Walk> {
    let twin = api.import(file).await?.name;
    let whole = api.roll_out(RollOutRequest { twin, ..way(controls, 0..=FRAMES) }).await?;
    let steps = (0..FRAMES).map(|frame| way(controls, frame..=frame + 1)).collect();
    Ok(Walk { steps, slots: SLOTS as u32, end: end(whole) })
}

/// A way of all control points by frames, each instance another one.
fn way(rest: &[[f32; 3]], frames: RangeInclusive<usize>) -> RollOutRequest {
    let mut positions = Vec::new();
    for instance in 0..SLOTS {
        for frame in frames.clone() {
            let along = 1e-3 * frame as f32 * (1 + instance) as f32;
            positions.extend(rest.iter().map(|p| [p[0] + along, p[1], p[2] + along]));
        }
    }
    let shape = [SLOTS, frames.count(), rest.len()];
    let positions = Some(Tensor::pack_points(&shape, &positions));
    RollOutRequest {
        actions: Some(Actions::Trajectories(ControlTrajectories { positions, interpolation: 0 })),
        returns: Some(Returns { final_state: true, ..Returns::default() }),
        ..RollOutRequest::default()
    }
}

/// The state that a rollout ends in, as one to begin in.
pub(crate) fn end(reply: RollOutResponse) -> GivenState {
    GivenState {
        positions: reply.final_positions,
        velocities: reply.final_velocities,
        twists: reply.final_twists,
        controls: reply.final_controls,
        commanded_controls: reply.final_commanded_controls,
        grasping: reply.final_grasping,
    }
}

/// Batches of a few sizes, with every kind of result.
fn requests(rest: &[[f32; 3]]) -> Vec<RollOutRequest> {
    let paths = Returns { every_frames: 1, final_state: true, ..Returns::default() };
    let gradients = Returns { control_gradients: true, ..Returns::default() };
    [(4, paths), (1, gradients), (16, Returns::default())]
        .map(|(batch, returns)| RollOutRequest {
            returns: Some(returns),
            ..request(rest, batch, FRAMES)
        })
        .into()
}

/// A batch that moves all control points together along a line, each instance by another way.
fn request(rest: &[[f32; 3]], batch: usize, frames: usize) -> RollOutRequest {
    let mut positions = Vec::new();
    for instance in 0..batch {
        for knot in 0..2 {
            let along = 1e-2 * knot as f32 * (1.0 + instance as f32 / batch as f32);
            positions.extend(rest.iter().map(|p| [p[0] + along, p[1], p[2] + along]));
        }
    }
    let positions = Tensor::pack_points(&[batch, 2, rest.len()], &positions);
    let target = cost::Kind::Keypoints(cost::Keypoints {
        nodes: Some(Tensor::pack::<u32>(&[1], &[0])),
        targets: Some(Tensor::pack_points(&[1], &[[0.0; 3]])),
        squared: false,
        skin_points: None,
    });
    RollOutRequest {
        actions: Some(Actions::Trajectories(ControlTrajectories {
            positions: Some(positions),
            interpolation: 0,
        })),
        frames: frames as u32,
        costs: vec![Cost { weight: Some(1.0), kind: Some(target), ..Cost::default() }],
        ..RollOutRequest::default()
    }
}

/// The parts of a reply that repeat: everything but the worker and the times.
pub(crate) fn lasting(reply: RollOutResponse) -> RollOutResponse {
    RollOutResponse { timing: None, worker: String::new(), ..reply }
}

/// The lasting part of a reply as JSON.
pub(crate) fn lasting_document(mut reply: Value) -> Value {
    if let Some(fields) = reply.as_object_mut() {
        fields.remove("timing");
        fields.remove("worker");
    }
    reply
}
