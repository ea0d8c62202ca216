//! Rollout requests with one fault each.

use bendtwin_proto::v1::{
    ControlTrajectories, Cost, GripperPoses, InitialState, Returns, RollOutRequest, Tensor, Twin,
    cost,
    initial_state::{CaptureFrame, GivenState, State},
    roll_out_request::Actions,
    tensor::Dtype,
};
use bytes::Bytes;

use super::bad_names;

/// The requests, each with its fault.
pub(super) fn requests(twin: &Twin, file: &Bytes) -> Vec<(String, RollOutRequest)> {
    let rest = crate::rollouts::rest_controls(file);
    let good = crate::rollouts::request(twin, &rest);
    let mut requests = Vec::new();
    for name in bad_names("twins") {
        requests.push((format!("twin {name:?}"), RollOutRequest { twin: name, ..good.clone() }));
    }
    let controls = rest.len();
    for (what, tensor) in tensors(&[2, 3, controls, 3]) {
        let actions = ControlTrajectories { positions: tensor, interpolation: 0 };
        let actions = Some(Actions::Trajectories(actions));
        requests
            .push((format!("trajectories, {what}"), RollOutRequest { actions, ..good.clone() }));
    }
    requests.push(("no actions".to_owned(), RollOutRequest { actions: None, ..good.clone() }));
    let unknown = ControlTrajectories {
        positions: Some(Tensor::pack(&[1, 2, controls, 3], &vec![0f32; 6 * controls])),
        interpolation: 99,
    };
    let actions = Some(Actions::Trajectories(unknown));
    requests.push(("interpolation 99".to_owned(), RollOutRequest { actions, ..good.clone() }));
    for (what, poses) in poses(controls) {
        let actions = Some(Actions::Poses(poses));
        requests.push((format!("poses, {what}"), RollOutRequest { actions, ..good.clone() }));
    }
    for (what, state) in states(twin.node_count as usize) {
        let initial = Some(InitialState { state: Some(state) });
        requests
            .push((format!("initial state, {what}"), RollOutRequest { initial, ..good.clone() }));
    }
    for (what, cost) in costs() {
        let costs = vec![cost];
        requests.push((format!("cost, {what}"), RollOutRequest { costs, ..good.clone() }));
    }
    for (what, returns) in returns(twin.node_count) {
        let returns = Some(returns);
        requests.push((format!("returns, {what}"), RollOutRequest { returns, ..good.clone() }));
    }
    for frames in [100_001, u32::MAX] {
        requests.push((format!("{frames} frames"), RollOutRequest { frames, ..good.clone() }));
    }
    requests
}

/// Tensors that are not FLOAT32 or not of this shape.
fn tensors(shape: &[usize]) -> Vec<(&'static str, Option<Tensor>)> {
    let count = shape.iter().product();
    let good = Tensor::pack(shape, &vec![0.01f32; count]);
    let with = |value: f32| {
        let mut values = vec![0.01; count];
        values[count / 2] = value;
        Some(Tensor::pack(shape, &values))
    };
    let shaped = |shape: &[u64]| Some(Tensor { shape: shape.to_vec(), ..good.clone() });
    let typed = |dtype: Dtype| Some(Tensor { dtype: dtype.into(), ..good.clone() });
    let short = good.data.slice(..good.data.len() - 1);
    let zero =
        |shape: &[u64]| Some(Tensor { shape: shape.to_vec(), data: Bytes::new(), ..good.clone() });
    let (b, k, c) = (shape[0] as u64, shape[1] as u64, shape[2] as u64);
    vec![
        ("missing", None),
        ("empty", Some(Tensor::default())),
        ("NaN", with(f32::NAN)),
        ("infinity", with(f32::INFINITY)),
        ("-infinity", with(f32::NEG_INFINITY)),
        ("a byte short", Some(Tensor { data: short, ..good.clone() })),
        ("no bytes", Some(Tensor { data: Bytes::new(), ..good.clone() })),
        ("no shape", shaped(&[])),
        ("a flat shape", shaped(&[count as u64])),
        ("one dimension more", shaped(&[b, k, c, 3, 1])),
        ("one row more than there are bytes", shaped(&[b, k + 1, c, 3])),
        ("10^12 instances", shaped(&[1_000_000_000_000, k, c, 3])),
        ("2^64 - 1 instances", shaped(&[u64::MAX, k, c, 3])),
        ("a product that overflows", shaped(&[1 << 32, 1 << 32, c, 3])),
        ("no instances", zero(&[0, k, c, 3])),
        ("no knots", zero(&[b, 0, c, 3])),
        ("no controls", zero(&[b, k, 0, 3])),
        ("a dimension of 0 beside one of 10^18", zero(&[0, 1_000_000_000_000_000_000, c, 3])),
        ("one knot", Some(Tensor::pack(&[1, 1, shape[2], 3], &vec![0f32; shape[2] * 3]))),
        (
            "a control too many",
            Some(Tensor::pack(&[1, 2, shape[2] + 1, 3], &vec![0f32; (shape[2] + 1) * 6])),
        ),
        ("swapped dimensions", shaped(&[b, k, 3, c])),
        ("FLOAT64", typed(Dtype::Float64)),
        ("UINT32", typed(Dtype::Uint32)),
        ("UINT8", typed(Dtype::Uint8)),
        ("no type", typed(Dtype::Unspecified)),
        ("type 77", Some(Tensor { dtype: 77, ..good.clone() })),
    ]
}

fn poses(controls: usize) -> Vec<(&'static str, GripperPoses)> {
    let pack = |last: [f32; 7]| {
        let rows: Vec<f32> = [[0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0], last].concat();
        Some(Tensor::pack(&[1, 2, 1, 7], &rows))
    };
    let good = || pack([0.0, 0.0, 0.1, 0.0, 0.0, 0.0, 1.0]);
    let with = |poses| GripperPoses { poses, ..GripperPoses::default() };
    let grippers = |indices: &[u32]| GripperPoses {
        gripper_of_control: Some(Tensor::pack(&[indices.len()], indices)),
        ..with(good())
    };
    vec![
        ("missing", with(None)),
        ("a quaternion of zeros", with(pack([0.0; 7]))),
        ("NaN", with(pack([f32::NAN, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0]))),
        ("a quaternion of infinities", with(pack([0.0, 0.0, 0.0, 0.0, 0.0, 0.0, f32::INFINITY]))),
        ("six numbers", with(Some(Tensor::pack(&[1, 2, 1, 6], &[0f32; 12])))),
        ("no grippers", with(Some(Tensor::pack::<f32>(&[1, 2, 0, 7], &[])))),
        ("a gripper that is not there", grippers(&vec![5; controls])),
        ("gripper 2^32 - 1", grippers(&vec![u32::MAX; controls])),
        ("a control too many", grippers(&vec![0; controls + 1])),
        (
            "grippers as floats",
            GripperPoses {
                gripper_of_control: Some(Tensor::pack(&[controls], &vec![0f32; controls])),
                ..with(good())
            },
        ),
    ]
}

fn states(nodes: usize) -> Vec<(&'static str, State)> {
    let points =
        |count: usize, value: f32| Some(Tensor::pack(&[count, 3], &vec![value; count * 3]));
    let given = |positions, velocities| {
        State::Given(GivenState { positions, velocities, twists: None, ..GivenState::default() })
    };
    let frame = |capture: &str, sequence, frame| {
        State::CaptureFrame(CaptureFrame { capture: capture.to_owned(), sequence, frame })
    };
    vec![
        ("no positions", given(None, None)),
        ("a node short", given(points(nodes - 1, 0.1), None)),
        ("a node too many", given(points(nodes + 1, 0.1), None)),
        ("NaN", given(points(nodes, f32::NAN), None)),
        ("infinite velocity", given(points(nodes, 0.1), points(nodes, f32::INFINITY))),
        ("velocities of another shape", given(points(nodes, 0.1), points(1, 0.0))),
        ("a batch of another size", {
            let values = vec![0.1f32; 3 * nodes * 3];
            given(Some(Tensor::pack(&[3, nodes, 3], &values)), None)
        }),
        ("a frame of an imported twin's capture", frame("", 0, 0)),
        ("a capture that is not there", {
            frame("captures/0190a000-0000-7000-8000-00000000dead", 0, 0)
        }),
        ("no capture name", frame("x", u32::MAX, u32::MAX)),
    ]
}

fn costs() -> Vec<(&'static str, Cost)> {
    let points = |values: &[[f32; 3]]| Some(Tensor::pack_points(&[values.len()], values));
    let weighted = |weight: f64, kind| Cost { weight: Some(weight), kind, ..Cost::default() };
    let cloud = |points| Some(cost::Kind::TargetCloud(cost::TargetCloud { points, point_set: 0 }));
    let keypoints = |nodes: &[u32], targets: &[[f32; 3]]| {
        Some(cost::Kind::Keypoints(cost::Keypoints {
            nodes: Some(Tensor::pack(&[nodes.len()], nodes)),
            targets: points(targets),
            squared: false,
            skin_points: None,
        }))
    };
    vec![
        ("no kind", weighted(1.0, None)),
        ("a weight that is NaN", weighted(f64::NAN, cloud(points(&[[0.0; 3]])))),
        ("an infinite weight", weighted(f64::INFINITY, cloud(points(&[[0.0; 3]])))),
        ("a cloud without points", weighted(1.0, cloud(None))),
        ("an empty cloud", weighted(1.0, cloud(points(&[])))),
        ("NaN in the cloud", weighted(1.0, cloud(points(&[[f32::NAN; 3]])))),
        ("a node that is not there", weighted(1.0, keypoints(&[u32::MAX], &[[0.0; 3]]))),
        ("more nodes than targets", weighted(1.0, keypoints(&[0, 1], &[[0.0; 3]]))),
        ("no keypoints", weighted(1.0, keypoints(&[], &[]))),
        ("NaN as a target", weighted(1.0, keypoints(&[0], &[[f32::NAN; 3]]))),
        ("an unknown time", Cost { when: 55, ..weighted(1.0, cloud(points(&[[0.0; 3]]))) }),
    ]
}

fn returns(nodes: u32) -> Vec<(&'static str, Returns)> {
    let recording =
        |nodes: Tensor| Returns { every_frames: 1, nodes: Some(nodes), ..Returns::default() };
    vec![
        ("a node that is not there", recording(Tensor::pack(&[1], &[nodes]))),
        ("node 2^32 - 1", recording(Tensor::pack(&[1], &[u32::MAX]))),
        ("nodes as floats", recording(Tensor::pack(&[1], &[0f32]))),
        ("nodes as a matrix", recording(Tensor::pack(&[1, 1], &[0u32]))),
        ("an unknown encoding", Returns { encoding: 9, every_frames: 1, ..Returns::default() }),
    ]
}
