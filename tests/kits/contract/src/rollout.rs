//! Requests for rollouts.

mod measures;
mod points;
mod surroundings;
mod tasks;

use bendtwin_contract::rollout::TwinShape;
use bendtwin_proto::v1::{
    ControlTrajectories, Cost, Grasping, GripperPoses, InitialState, KnotTimes, Returns,
    RollOutRequest, Tensor,
    cost::{Keypoints, Kind, TargetCloud},
    initial_state::{CaptureFrame, GivenState, State},
    knot_times::Times,
    roll_out_request::Actions,
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
    pub request: RollOutRequest,
}

/// Two instances of three knots for a twin, with a cost.
pub fn sound(twin: &TwinShape) -> RollOutRequest {
    RollOutRequest {
        actions: trajectories(Some(zeros(&[2, 3, twin.controls, 3])), 0),
        costs: vec![cost(keypoints(&[0], 1))],
        ..RollOutRequest::default()
    }
}

/// The same by poses of a gripper, with a collider and a grasp.
pub fn sound_in_a_world(twin: &TwinShape) -> RollOutRequest {
    surroundings::sound(&sound(twin))
}

/// Requests with one fault each for a twin, which has neither rods nor a capture nor a fast
/// variant.
pub fn malformed(twin: &TwinShape) -> Vec<Case> {
    let mut cases = Vec::new();
    let good = sound(twin);
    let mut add = |what, names, request| cases.push(Case { what, names, request });
    for (what, names, actions) in actions(twin.controls) {
        add(what, names, RollOutRequest { actions, ..good.clone() });
    }
    for (what, names, state) in states(twin.nodes, twin.controls) {
        let initial = Some(InitialState { state: Some(state) });
        add(what, names, RollOutRequest { initial, ..good.clone() });
    }
    let measures = measures::costs(twin.nodes, twin.controls);
    let tasks = tasks::costs(twin.nodes);
    for (what, names, costs) in
        costs(twin.nodes).into_iter().chain(measures).chain(points::costs()).chain(tasks)
    {
        add(what, names, RollOutRequest { costs, ..good.clone() });
    }
    for (what, names, returns) in returns(twin.nodes).into_iter().chain(points::returns()) {
        add(what, names, RollOutRequest { returns: Some(returns), ..good.clone() });
    }
    let uncosted = Some(Returns { control_gradients: true, ..Returns::default() });
    let uncosted = RollOutRequest { costs: Vec::new(), returns: uncosted, ..good.clone() };
    add("gradients without costs", "returns.control_gradients", uncosted);
    let uncosted = Some(Returns { action_gradients: true, ..Returns::default() });
    let uncosted = RollOutRequest { costs: Vec::new(), returns: uncosted, ..good.clone() };
    add("gradients by actions without costs", "returns.action_gradients", uncosted);
    let uncosted = Some(Returns { gradient_norms: true, ..Returns::default() });
    let uncosted = RollOutRequest { costs: Vec::new(), returns: uncosted, ..good.clone() };
    add("norms of gradients without costs", "returns.gradient_norms", uncosted);
    for (what, names, times) in times() {
        let knot_times = Some(KnotTimes { times: Some(times) });
        add(what, names, RollOutRequest { knot_times, frames: 4, ..good.clone() });
    }
    let knot_times = Some(KnotTimes { times: Some(Times::PeriodS(0.1)) });
    add("times without a horizon", "`frames`", RollOutRequest { knot_times, ..good.clone() });
    add("100001 frames", "`frames`", RollOutRequest { frames: 100_001, ..good.clone() });
    add("2^32 - 1 frames", "`frames`", RollOutRequest { frames: u32::MAX, ..good.clone() });
    for limit in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let request = RollOutRequest { time_limit_s: Some(limit), ..good.clone() };
        add("a time limit that is not one", "`time_limit_s`", request);
    }
    let returns = Some(Returns { control_gradients: true, ..Returns::default() });
    let limited = RollOutRequest { returns, time_limit_s: Some(1.0), ..good.clone() };
    add("a time limit of gradients", "`time_limit_s`", limited);
    add("fidelity 7", "`fidelity`", RollOutRequest { fidelity: 7, ..good.clone() });
    add("no fast variant", "fast variant", RollOutRequest { fidelity: 2, ..good.clone() });
    cases.extend(surroundings::malformed(&good, twin));
    cases
}

fn zeros(shape: &[u64]) -> Tensor {
    let count = shape.iter().product::<u64>() as usize;
    let data = vec![0; 4 * count].into();
    Tensor { dtype: Dtype::Float32.into(), shape: shape.to_vec(), data, ..Tensor::default() }
}

/// Zeros but for one value in the middle.
fn with(shape: &[u64], value: f32) -> Tensor {
    let mut data = zeros(shape).data.to_vec();
    let middle = data.len() / 8 * 4;
    data[middle..middle + 4].copy_from_slice(&value.to_le_bytes());
    Tensor { data: data.into(), ..zeros(shape) }
}

fn trajectories(positions: Option<Tensor>, interpolation: i32) -> Option<Actions> {
    Some(Actions::Trajectories(ControlTrajectories { positions, interpolation }))
}

type Named<T> = Vec<(&'static str, &'static str, T)>;

fn actions(c: u64) -> Named<Option<Actions>> {
    const POSITIONS: &str = "`trajectories.positions`";
    let good = zeros(&[2, 3, c, 3]);
    let shaped = |shape: &[u64]| Tensor { shape: shape.to_vec(), ..good.clone() };
    let empty = |shape: &[u64]| Tensor { data: Bytes::new(), ..shaped(shape) };
    let typed = |dtype: i32| Tensor { dtype, ..good.clone() };
    let short = Tensor { data: good.data.slice(1..), ..good.clone() };
    let tensors = [
        ("no tensor", Tensor::default()),
        ("NaN", with(&[2, 3, c, 3], f32::NAN)),
        ("infinity", with(&[2, 3, c, 3], f32::INFINITY)),
        ("a byte short", short),
        ("no bytes", empty(&[2, 3, c, 3])),
        ("no shape", shaped(&[])),
        ("a flat shape", shaped(&[6 * c * 3])),
        ("one dimension more", shaped(&[2, 3, c, 3, 1])),
        ("a row more than there are bytes", shaped(&[2, 4, c, 3])),
        ("2^64 - 1 instances", shaped(&[u64::MAX, 3, c, 3])),
        ("a product that overflows", shaped(&[1 << 32, 1 << 32, c, 3])),
        ("no instances", empty(&[0, 3, c, 3])),
        ("no knots", empty(&[2, 0, c, 3])),
        ("no controls", empty(&[2, 3, 0, 3])),
        ("one knot", zeros(&[1, 1, c, 3])),
        ("a control too many", zeros(&[1, 2, c + 1, 3])),
        ("two coordinates", zeros(&[1, 2, c, 2])),
        ("FLOAT64", Tensor { data: vec![0; 144 * c as usize].into(), ..typed(2) }),
        ("UINT32", typed(3)),
        ("INT16_SCALED", Tensor { data: vec![0; 36 * c as usize].into(), ..typed(6) }),
        ("no type", typed(0)),
        ("type 77", typed(77)),
    ];
    let mut actions: Named<_> =
        tensors.into_iter().map(|(what, t)| (what, POSITIONS, trajectories(Some(t), 0))).collect();
    actions.push(("no positions", POSITIONS, trajectories(None, 0)));
    actions.push(("no actions", "`actions`", None));
    let unknown = trajectories(Some(good), 99);
    actions.push(("interpolation 99", "`trajectories.interpolation`", unknown));
    // A tensor with a zero in its shape has no bytes, with any other dimensions.
    let many = Tensor { dtype: 1, shape: vec![1 << 60, 2, 0, 3], ..Tensor::default() };
    actions.push(("2^60 instances of nothing", "instances", trajectories(Some(many), 0)));
    let many = Tensor { dtype: 1, shape: vec![1, 1 << 60, 0, 3], ..Tensor::default() };
    actions.push(("2^60 knots of nothing", "knots", trajectories(Some(many), 0)));
    actions.extend(
        poses(c).into_iter().map(|(what, names, p)| (what, names, Some(Actions::Poses(p)))),
    );
    actions
}

fn poses(c: u64) -> Named<GripperPoses> {
    const POSES: &str = "`poses.poses`";
    let pack = |last: [f32; 7]| {
        let rows: Vec<f32> = [[0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0], last].concat();
        Some(Tensor::pack(&[1, 2, 1, 7], &rows))
    };
    let good = || pack([0.0, 0.0, 0.1, 0.0, 0.0, 0.0, 1.0]);
    let of = |poses| GripperPoses { poses, ..GripperPoses::default() };
    let grippers = |map: Tensor| GripperPoses { gripper_of_control: Some(map), ..of(good()) };
    let count = c as usize;
    vec![
        ("no poses", POSES, of(None)),
        ("a quaternion of zeros", "length zero", of(pack([0.0; 7]))),
        ("NaN in a pose", POSES, of(pack([f32::NAN, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0]))),
        ("an infinite quaternion", POSES, of(pack([0.0, 0.0, 0.0, 0.0, 0.0, 0.0, f32::INFINITY]))),
        ("six numbers a pose", POSES, of(Some(zeros(&[1, 2, 1, 6])))),
        ("no grippers", "no grippers", of(Some(Tensor::pack::<f32>(&[1, 2, 0, 7], &[])))),
        (
            "a gripper that is not there",
            "gripper 5",
            grippers(Tensor::pack(&[count], &vec![5u32; count])),
        ),
        (
            "a control too many of a gripper",
            "`poses.gripper_of_control`",
            grippers(Tensor::pack(&[count + 1], &vec![0u32; count + 1])),
        ),
        ("grippers as floats", "`poses.gripper_of_control`", grippers(zeros(&[c]))),
    ]
}

fn states(n: u64, c: u64) -> Named<State> {
    const POSITIONS: &str = "`initial.given.positions`";
    const VELOCITIES: &str = "`initial.given.velocities`";
    const TWISTS: &str = "`initial.given.twists`";
    const CONTROLS: &str = "`initial.given.controls`";
    const COMMANDED: &str = "`initial.given.commanded_controls`";
    const PHASES: &str = "`initial.given.grasping.phases`";
    const HOLDERS: &str = "`initial.given.grasping.holders`";
    const CAPTURE: &str = "`initial.capture_frame.capture`";
    let given = |positions: Tensor, velocities: Option<Tensor>, twists: Option<Tensor>| {
        State::Given(GivenState {
            positions: Some(positions),
            velocities,
            twists,
            ..GivenState::default()
        })
    };
    let frame = |capture: &str| {
        State::CaptureFrame(CaptureFrame { capture: capture.to_owned(), sequence: 0, frame: 0 })
    };
    let good = || zeros(&[n, 3]);
    let with_controls = |controls: Tensor| {
        let (positions, controls) = (Some(good()), Some(controls));
        State::Given(GivenState { positions, controls, ..GivenState::default() })
    };
    let commanded = |controls: Option<Tensor>, commanded: Tensor| {
        let (positions, commanded_controls) = (Some(good()), Some(commanded));
        State::Given(GivenState {
            positions,
            controls,
            commanded_controls,
            ..GivenState::default()
        })
    };
    let holding = |phases: &[u32], holders: u64, holder: u32| {
        let holders = vec![holder; holders as usize];
        let grasping = Grasping {
            phases: Some(Tensor::pack(&[phases.len()], phases)),
            holders: Some(Tensor::pack(&[holders.len()], &holders)),
            places: Some(zeros(&[n, 3])),
        };
        let (positions, grasping) = (Some(good()), Some(grasping));
        State::Given(GivenState { positions, grasping, ..GivenState::default() })
    };
    vec![
        ("no state", POSITIONS, given(Tensor::default(), None, None)),
        ("a node short", POSITIONS, given(zeros(&[n - 1, 3]), None, None)),
        ("a node too many", POSITIONS, given(zeros(&[n + 1, 3]), None, None)),
        ("a batch of another size", POSITIONS, given(zeros(&[3, n, 3]), None, None)),
        ("NaN in the state", POSITIONS, given(with(&[n, 3], f32::NAN), None, None)),
        (
            "an infinite velocity",
            VELOCITIES,
            given(good(), Some(with(&[n, 3], f32::INFINITY)), None),
        ),
        ("velocities of another shape", VELOCITIES, given(good(), Some(zeros(&[1, 3])), None)),
        ("twists for a batch", TWISTS, given(good(), None, Some(zeros(&[2, 1])))),
        ("NaN in the twists", TWISTS, given(good(), None, Some(with(&[1], f32::NAN)))),
        ("controls for a batch", CONTROLS, with_controls(zeros(&[2, c, 3]))),
        ("NaN in the controls of the state", CONTROLS, with_controls(with(&[c, 3], f32::NAN))),
        ("a control too many in the state", CONTROLS, with_controls(zeros(&[c + 1, 3]))),
        ("commanded controls alone", COMMANDED, commanded(None, zeros(&[c, 3]))),
        (
            "commanded controls of another shape",
            COMMANDED,
            commanded(Some(zeros(&[c, 3])), zeros(&[c + 1, 3])),
        ),
        (
            "NaN in the commanded controls",
            COMMANDED,
            commanded(Some(zeros(&[c, 3])), with(&[c, 3], f32::NAN)),
        ),
        ("an unknown phase", PHASES, holding(&[3], n, 0)),
        ("a grasp too many in the state", PHASES, holding(&[1], n, 1)),
        ("a holder that is not there", HOLDERS, holding(&[1], n, 2)),
        ("a holder short", HOLDERS, holding(&[1], n - 1, 0)),
        ("a frame of an imported twin's capture", CAPTURE, frame("")),
        ("no capture name", CAPTURE, frame("x")),
    ]
}

fn times() -> Named<Times> {
    const AT: &str = "`knot_times.at_s`";
    const PERIOD: &str = "`knot_times.period_s`";
    let at = |times: &[f32]| Times::AtS(Tensor::pack(&[times.len()], times));
    vec![
        ("a time short", AT, at(&[0.0, 1.0])),
        ("times that do not begin at 0", AT, at(&[0.1, 0.2, 0.3])),
        ("times that do not rise", AT, at(&[0.0, 0.2, 0.2])),
        ("NaN in the times", AT, at(&[0.0, f32::NAN, 1.0])),
        ("a period of 0", PERIOD, Times::PeriodS(0.0)),
        ("a period that is NaN", PERIOD, Times::PeriodS(f64::NAN)),
    ]
}

fn cost(kind: Option<Kind>) -> Cost {
    Cost { weight: Some(1.0), kind, ..Cost::default() }
}

fn cloud(points: Option<Tensor>) -> Option<Kind> {
    Some(Kind::TargetCloud(TargetCloud { points, point_set: 0 }))
}

fn keypoints(nodes: &[u32], targets: u64) -> Option<Kind> {
    let nodes = Some(Tensor::pack(&[nodes.len()], nodes));
    let targets = Some(zeros(&[targets, 3]));
    Some(Kind::Keypoints(Keypoints { nodes, targets, ..Keypoints::default() }))
}

fn costs(n: u64) -> Named<Vec<Cost>> {
    const NAME: &str = "`costs[1].name`";
    const POINTS: &str = "`costs[0].target_cloud.points`";
    const NODES: &str = "`costs[0].keypoints.nodes`";
    let good = || cost(keypoints(&[0], 1));
    let weighted = |weight| vec![Cost { weight: Some(weight), ..good() }];
    let named = |name: &str| vec![good(), Cost { name: name.to_owned(), ..good() }];
    let of = |kind| vec![cost(kind)];
    vec![
        ("no kind", "`costs[0].kind`", of(None)),
        ("a weight that is NaN", "`costs[0].weight`", weighted(f64::NAN)),
        ("an infinite weight", "`costs[0].weight`", weighted(f64::INFINITY)),
        ("a weight beyond single precision", "`costs[0].weight`", weighted(1e300)),
        ("an unknown time", "`costs[0].when`", vec![Cost { when: 55, ..good() }]),
        ("a name twice", NAME, named("cost0")),
        ("a name of 129 bytes in 65 characters", NAME, named(&format!("{}x", "ä".repeat(64)))),
        ("a name with a line break", NAME, named("a\nb")),
        ("257 costs", "number of costs", vec![good(); 257]),
        ("a cloud without points", POINTS, of(cloud(None))),
        ("an empty cloud", POINTS, of(cloud(Some(zeros(&[0, 3]))))),
        ("NaN in the cloud", POINTS, of(cloud(Some(with(&[2, 3], f32::NAN))))),
        ("a node that is not there", NODES, of(keypoints(&[n as u32], 1))),
        ("node 2^32 - 1", NODES, of(keypoints(&[u32::MAX], 1))),
        ("no keypoints", NODES, of(keypoints(&[], 0))),
        ("more nodes than targets", "`costs[0].keypoints.targets`", of(keypoints(&[0, 1], 1))),
    ]
}

fn returns(n: u64) -> Named<Returns> {
    const NODES: &str = "`returns.nodes`";
    const PART: &str = "`returns.part_frames`";
    let recording =
        |nodes: Tensor| Returns { every_frames: 1, nodes: Some(nodes), ..Returns::default() };
    vec![
        ("a node to record that is not there", NODES, recording(Tensor::pack(&[1], &[n as u32]))),
        ("nodes as floats", NODES, recording(Tensor::pack(&[1], &[0f32]))),
        ("nodes as a matrix", NODES, recording(Tensor::pack(&[1, 1], &[0u32]))),
        (
            "an unknown encoding",
            "`returns.encoding`",
            Returns { encoding: 9, ..Returns::default() },
        ),
        (
            "velocities of no frames",
            "`returns.velocities`",
            Returns { velocities: true, ..Returns::default() },
        ),
        ("parts in time of one message", PART, Returns { part_frames: 1, ..Returns::default() }),
        (
            "parts in time of the best",
            PART,
            Returns { part_frames: 1, best: 1, ..Returns::default() },
        ),
        (
            "parts in time of gradients",
            PART,
            Returns { part_frames: 1, gradient_norms: true, ..Returns::default() },
        ),
        (
            "parts in time that cut a recording",
            PART,
            Returns { part_frames: 3, every_frames: 2, ..Returns::default() },
        ),
    ]
}
