//! Requests with observations.

use bendtwin_contract::rollout::TwinShape;
use bendtwin_proto::v1::{
    Collider, InitialState, Observation, RegisterOptions, RegisterStateRequest, Tensor, World,
    initial_state::{GivenState, SessionSlots, State},
    observation::{Places, Tracks},
    tensor::Dtype,
};
use bytes::Bytes;

/// A malformed request.
#[derive(Clone, Debug)]
pub struct Case {
    /// The fault in a few words.
    pub what: &'static str,
    /// Text of the message: the field, or the limit.
    pub names: &'static str,
    /// The request; its twin is left to the caller.
    pub request: RegisterStateRequest,
}

/// Two points that are nodes of a twin.
pub fn sound() -> RegisterStateRequest {
    let observation = Observation {
        points: Some(points(2, 0.1)),
        tracks: Some(Tracks::Nodes(Tensor::pack(&[2], &[0u32, 1]))),
        ..Observation::default()
    };
    RegisterStateRequest { observation: Some(observation), ..RegisterStateRequest::default() }
}

/// Requests with one fault each for a twin without a capture.
pub fn malformed(twin: &TwinShape) -> Vec<Case> {
    let good = sound();
    let mut cases = Vec::new();
    let mut add = |what, names, request| cases.push(Case { what, names, request });
    for (what, names, observation) in observations(twin) {
        let observation = Some(observation);
        add(what, names, RegisterStateRequest { observation, ..good.clone() });
    }
    let none = RegisterStateRequest { observation: None, ..good.clone() };
    add("no observation", "`observation`", none);
    let controls = Some(points(twin.controls as usize + 1, 0.0));
    let control = RegisterStateRequest { controls, ..good.clone() };
    add("a control too many", "`controls`", control);
    let state = GivenState { positions: Some(points(1, 0.0)), ..GivenState::default() };
    for (what, names, state) in [
        ("a start that is too short", "`initial.given.positions`", State::Given(state)),
        ("a start in a session", "`initial.session`", State::Session(SessionSlots::default())),
    ] {
        let initial = Some(InitialState { state: Some(state) });
        add(what, names, RegisterStateRequest { initial, ..good.clone() });
    }
    let gravity = World { gravity: vec![f32::NAN; 3], ..World::default() };
    let colliders = World { colliders: vec![Collider::default()], ..World::default() };
    for (what, names, world) in [
        ("gravity that is no number", "`world.gravity`", gravity),
        ("a collider without shape", "`world.colliders[0].shape`", colliders),
    ] {
        add(what, names, RegisterStateRequest { world: Some(world), ..good.clone() });
    }
    let unturned = Some(Tensor::pack(&[1, 7], &[0.0f32; 7]));
    let grippers = RegisterStateRequest { grippers: unturned, ..good.clone() };
    add("a gripper without a rotation", "`grippers`", grippers);
    let options = RegisterOptions { settle_frames: Some(u32::MAX), ..RegisterOptions::default() };
    let options = Some(options);
    add("4294967295 frames", "`options.settle_frames`", RegisterStateRequest { options, ..good });
    cases
}

/// Points of one coordinate.
fn points(count: usize, x: f32) -> Tensor {
    Tensor::pack_points(&[count], &vec![[x; 3]; count])
}

fn observations(twin: &TwinShape) -> Vec<(&'static str, &'static str, Observation)> {
    const POINTS: &str = "`observation.points`";
    const NODES: &str = "`observation.nodes`";
    const WEIGHTS: &str = "`observation.weights`";
    let good = sound().observation.unwrap_or_default();
    let seen = |points: Tensor| Observation { points: Some(points), ..good.clone() };
    let claimed = Tensor {
        dtype: Dtype::Float32.into(),
        shape: vec![1_000_000_000, 3],
        data: Bytes::from_static(&[0; 24]),
        ..Tensor::default()
    };
    let nodes = |nodes: &[u32]| Observation {
        tracks: Some(Tracks::Nodes(Tensor::pack(&[nodes.len()], nodes))),
        ..good.clone()
    };
    let places = |points: Tensor, node_positions| Observation {
        tracks: Some(Tracks::Places(Places { points: Some(points), node_positions })),
        ..good.clone()
    };
    let weights = |weights: Tensor| Observation { weights: Some(weights), ..good.clone() };
    vec![
        ("no points", POINTS, Observation { points: None, ..good.clone() }),
        ("an empty list of points", POINTS, seen(Tensor::pack(&[0, 3], &[0.0f32; 0]))),
        ("points of two numbers", POINTS, seen(Tensor::pack(&[3, 2], &[0.0f32; 6]))),
        ("points of double precision", POINTS, seen(Tensor::pack(&[2, 3], &[0.0f64; 6]))),
        ("a point that is no number", POINTS, seen(points(2, f32::NAN))),
        ("a point in infinity", POINTS, seen(points(2, f32::INFINITY))),
        ("points in millimetres", POINTS, seen(points(2, 1200.0))),
        ("10^9 points that are not there", POINTS, seen(claimed)),
        ("200001 points", POINTS, seen(points(200_001, 0.0))),
        ("a node short", NODES, nodes(&[0])),
        ("a node that is not there", NODES, nodes(&[0, twin.nodes as u32])),
        ("a place short", "`observation.places.points`", places(points(1, 0.0), None)),
        (
            "a shape of another twin",
            "`observation.places.node_positions`",
            places(points(2, 0.0), Some(points(twin.nodes as usize + 1, 0.0))),
        ),
        ("a weight short", WEIGHTS, weights(Tensor::pack(&[1], &[1.0f32]))),
        ("whole weights", WEIGHTS, weights(Tensor::pack(&[2], &[1u32, 1]))),
        (
            "a velocity short",
            "`observation.velocities`",
            Observation { velocities: Some(points(1, 0.0)), ..good.clone() },
        ),
        (
            "17 cameras",
            "`observation.cameras`",
            Observation { cameras: Some(points(17, 0.0)), ..good.clone() },
        ),
    ]
}
