//! Requests that take much memory, and the twins that they are made for.

use bendtwin_core::{Contact, Graph, NodeKind, Params, Timing, Twin};
use bendtwin_core_kit::twin_of;
use bendtwin_harness::Api;
use bendtwin_proto::{
    json::{TensorFormat, Write},
    v1::{
        ControlTrajectories, Cost, Returns, RollOutRequest, Tensor,
        cost::{Kind, Smoothness},
        roll_out_request::Actions,
    },
};

const CHAIN: usize = 4;
const CONTROLS: usize = 10_000;

/// Names of twins, and a file.
pub(super) struct Twins {
    /// Few nodes and one control point.
    pub(super) chain: String,
    /// Two nodes and thousands of control points.
    pub(super) controls: String,
    /// A file of many megabytes.
    pub(super) large: Vec<u8>,
}

impl Twins {
    pub(super) async fn import(api: &Api) -> Self {
        let file = |nodes, controls| twin(nodes, controls).encode().unwrap();
        let chain = api.import(&file(CHAIN, 1).into()).await.unwrap().name;
        let controls = api.import(&file(2, CONTROLS).into()).await.unwrap().name;
        Self { chain, controls, large: file(400_000, 1) }
    }
}

/// A chain of nodes that hangs from the first control point.
fn twin(n: usize, controls: usize) -> Twin {
    let node = |i: usize| i as u32;
    let graph = Graph {
        rest_positions: (0..n).map(|i| [0.1 * i as f32, 0.0, 0.5]).collect(),
        kinds: vec![NodeKind::Observed; n],
        masses: vec![1.0; n],
        object_ids: vec![0; n],
        observed_points: (0..n).map(node).collect(),
        control_rest: (0..controls).map(|i| [-0.1 - 0.1 * i as f32, 0.0, 0.5]).collect(),
        springs: (0..n).map(|i| [node(i), if i == 0 { node(n) } else { node(i - 1) }]).collect(),
        ..Graph::default()
    };
    let params = Params {
        spring_stiffness: vec![50.0; n],
        spring_dashpot: vec![1.0; n],
        rest_lengths_m: vec![0.1; n],
        drag: 1.0,
        contact: Contact::default(),
        ..Params::default()
    };
    Twin { timing: Timing { fps: 30.0, substeps: 20 }, ..twin_of(graph, params) }
}

/// Control points that rest for `knots` knots; the horizon is short.
fn resting(twin: &str, instances: usize, knots: usize, controls: usize) -> RollOutRequest {
    // Whole numbers, which are short in JSON: the control points stand apart, but none moves.
    let points = vec![[0.0f32; 3]; instances * knots * controls];
    let positions = Some(Tensor::pack_points(&[instances, knots, controls], &points));
    RollOutRequest {
        twin: twin.to_owned(),
        actions: Some(Actions::Trajectories(ControlTrajectories { positions, interpolation: 0 })),
        frames: 3,
        ..RollOutRequest::default()
    }
}

/// A large body for little work.
pub(super) fn many_knots(twin: &str, instances: usize, knots: usize) -> RollOutRequest {
    resting(twin, instances, knots, 1)
}

/// Few knots that become dense controls of many frames.
pub(super) fn many_controls(twin: &str, frames: u32) -> RollOutRequest {
    RollOutRequest { frames, ..resting(twin, 1, 2, CONTROLS) }
}

/// Gradients by all control points.
pub(super) fn gradients(twin: &str, frames: u32) -> RollOutRequest {
    let smooth = Cost { kind: Some(Kind::Smoothness(Smoothness {})), ..Cost::default() };
    let returns = Returns { control_gradients: true, ..Returns::default() };
    RollOutRequest { costs: vec![smooth], returns: Some(returns), ..many_controls(twin, frames) }
}

/// A small request for a large reply: 144 kB for each instance.
pub(super) fn many_frames(twin: &str, instances: usize) -> RollOutRequest {
    let returns = Returns { every_frames: 1, ..Returns::default() };
    RollOutRequest { frames: 3_000, returns: Some(returns), ..resting(twin, instances, 2, 1) }
}

/// A reply that is just small enough for lists of JSON.
pub(super) fn long_reply(twin: &str) -> RollOutRequest {
    many_frames(twin, 110)
}

/// The request as JSON, in which zeros are written as short as they can be.
pub(super) fn as_json(request: &RollOutRequest) -> Vec<u8> {
    let write = Write { message: request, tensors: TensorFormat::Lists };
    serde_json::to_string(&write).unwrap().replace("0.0", "0").into_bytes()
}
