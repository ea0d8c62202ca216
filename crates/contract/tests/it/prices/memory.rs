//! Memory, part by part.

use bendtwin_contract::rollout::{
    Error, Limits, Memory, PlannerShape, TwinShape, check_for, memory,
};
use bendtwin_proto::v1::{
    ControlTrajectories, Cost, Fidelity, GripperPoses, InitialState, PointSet, Returns,
    RollOutRequest, Tensor,
    cost::{Keypoints, Kind, TargetCloud},
    initial_state::{GivenState, State},
    roll_out_request::Actions,
};
use prost::Message as _;

const MIB: u64 = 1 << 20;

/// Two nodes that nobody would count, and ten thousand control points.
const MANY_CONTROLS: TwinShape = TwinShape {
    nodes: 2,
    springs: 1,
    triplets: 0,
    controls: 10_000,
    skin_points: Some(0),
    rods: Some(0),
    substeps: 1,
    fast_substeps: None,
    planner: None,
    has_capture: false,
};

fn zeros(shape: &[u64]) -> Option<Tensor> {
    let data = vec![0; 4 * shape.iter().product::<u64>() as usize].into();
    Some(Tensor { dtype: 1, shape: shape.to_vec(), data, ..Tensor::default() })
}

fn request(twin: &TwinShape, instances: u64, frames: u32) -> RollOutRequest {
    let positions = zeros(&[instances, 2, twin.controls, 3]);
    let trajectories = ControlTrajectories { positions, interpolation: 0 };
    let actions = Some(Actions::Trajectories(trajectories));
    RollOutRequest { actions, frames, ..RollOutRequest::default() }
}

fn of(request: &RollOutRequest, twin: &TwinShape) -> Memory {
    let limits = Limits { memory_bytes: u64::MAX, ..Limits::default() };
    memory(request, &check_for(request, twin, &limits, 0).unwrap(), twin, 0)
}

#[test]
fn a_few_knots_that_become_gigabytes_are_refused() {
    let request = request(&MANY_CONTROLS, 1, 100_000);
    assert!(request.encoded_len() < 300_000);
    let refused = check_for(&request, &MANY_CONTROLS, &Limits::default(), 0).unwrap_err();
    let Error::TooLarge { asked, limit, advice, .. } = refused else { panic!("{refused}") };
    // The dense controls alone: 12 bytes for each control point and frame boundary.
    assert!(asked > 12 * 100_001 * 10_000 && limit == Limits::default().memory_bytes);
    assert!(advice.contains("shorter horizon"), "{advice}");
    // A hundredth of it passes.
    let shorter = RollOutRequest { frames: 1_000, ..request };
    assert!(check_for(&shorter, &MANY_CONTROLS, &Limits::default(), 0).is_ok());
}

#[test]
fn starts_of_each_instance_are_counted() {
    // A pose moves any number of control points: 56 bytes an instance.
    let instances = 2_000;
    let mut poses = vec![0.0f32; instances * 2 * 7];
    poses.chunks_mut(7).for_each(|pose| pose[6] = 1.0);
    let poses = Some(Tensor::pack(&[instances, 2, 1, 7], &poses));
    let actions = Actions::Poses(GripperPoses { poses, ..GripperPoses::default() });
    let given = GivenState { positions: zeros(&[instances as u64, 2, 3]), ..GivenState::default() };
    let request = RollOutRequest {
        actions: Some(actions),
        initial: Some(InitialState { state: Some(State::Given(given)) }),
        ..RollOutRequest::default()
    };
    let starts = 12 * 10_000 * instances as u64;
    assert!(of(&request, &MANY_CONTROLS).fixed > starts);
    let at_rest = RollOutRequest { initial: None, ..request };
    assert!(of(&at_rest, &MANY_CONTROLS).fixed < starts / 100);
}

#[test]
fn gradients_count_states_of_all_frames() {
    let twin =
        TwinShape { nodes: 1_000, springs: 3_000, controls: 2, substeps: 10, ..MANY_CONTROLS };
    let mut request = request(&twin, 1, 10_000);
    request.costs = vec![Cost {
        kind: Some(bendtwin_proto::v1::cost::Kind::Smoothness(
            bendtwin_proto::v1::cost::Smoothness {},
        )),
        ..Cost::default()
    }];
    let forward = of(&request, &twin);
    request.returns = Some(Returns { control_gradients: true, ..Returns::default() });
    let backward = of(&request, &twin);
    assert!(forward.least() < 4 * MIB, "{forward:?}");
    assert!(backward.least() > 32 * 1_000 * 10_000, "{backward:?}");
}

#[test]
fn lanes_and_prepared_instances_are_counted() {
    let memory = Memory { request: 1000, fixed: 100, prepared: 10, running: 1 };
    assert_eq!((memory.least(), memory.bytes(8, 4), memory.bytes(2, 4)), (1111, 184, 122));
    let absurd = Memory { request: 0, fixed: 1, prepared: u64::MAX, running: u64::MAX };
    assert_eq!(absurd.bytes(usize::MAX, 3), u64::MAX);
}

#[test]
fn the_skin_counts_as_what_it_is_and_as_the_nodes_that_it_is_placed_from() {
    let twin = TwinShape { nodes: 1_000, skin_points: Some(20_000), controls: 1, ..MANY_CONTROLS };
    let mut asked = request(&twin, 1, 100);
    let mut counted = |returns: Returns| {
        asked.returns = Some(returns);
        of(&asked, &twin)
    };
    let recording = Returns { every_frames: 10, ..Returns::default() };
    let nodes = counted(recording.clone());
    let whole = Returns { point_set: PointSet::Skin.into(), ..recording };
    let skin = counted(whole.clone());
    // Ten frames of the reply, and of the engine's recording.
    assert!(skin.fixed - nodes.fixed > 4 * 10 * 12 * 19_000);
    assert!(skin.prepared - nodes.prepared >= 10 * 12 * 1_000);
    let some = Returns { skin_points: Some(Tensor::pack(&[1], &[5u32])), ..whole };
    assert!(counted(some).fixed < nodes.fixed);
    // A twin whose skin nobody has counted has no more points than nodes.
    let uncounted = TwinShape { skin_points: None, ..twin };
    let whole =
        Returns { point_set: PointSet::Skin.into(), every_frames: 10, ..Returns::default() };
    let request = RollOutRequest { returns: Some(whole), ..request(&uncounted, 1, 100) };
    assert_eq!(of(&request, &uncounted).fixed, nodes.fixed + 8 * 1_000);
}

#[test]
fn costs_at_the_skin_place_it() {
    let twin = TwinShape { nodes: 10, skin_points: Some(50_000), controls: 1, ..MANY_CONTROLS };
    let mut request = request(&twin, 1, 10);
    let mut running = |point_set: PointSet| {
        let points = zeros(&[1, 3]);
        let cloud = TargetCloud { points, point_set: point_set.into() };
        request.costs = vec![Cost { kind: Some(Kind::TargetCloud(cloud)), ..Cost::default() }];
        of(&request, &twin).running
    };
    let nodes = running(PointSet::Nodes);
    assert!(running(PointSet::Skin) - nodes >= 32 * 50_000);
    assert_eq!(running(PointSet::Unspecified), running(PointSet::Skin));
}

/// A request to a planner's twin is counted as what it becomes: records of the skin, keypoints at the
/// skin, and the larger of both models.
#[test]
fn a_planners_twin_counts_what_it_simulates() {
    let planner = PlannerShape { nodes: 500, springs: 9_000, triplets: 100, substeps: 400 };
    let twin = TwinShape {
        nodes: 1_000,
        springs: 3_000,
        triplets: 50,
        controls: 1,
        skin_points: Some(2_000),
        substeps: 10,
        planner: Some(planner),
        ..MANY_CONTROLS
    };
    let one = || Some(Tensor::pack(&[1], &[7_u32]));
    let both = |asked: RollOutRequest| {
        let planned = RollOutRequest { fidelity: Fidelity::Planner.into(), ..asked.clone() };
        (of(&asked, &twin), of(&planned, &twin))
    };
    let asked = request(&twin, 1, 20);

    let returns = Returns { every_frames: 2, nodes: one(), velocities: true, ..Returns::default() };
    let (exact, planned) = both(RollOutRequest { returns: Some(returns), ..asked.clone() });
    assert!(planned.prepared - exact.prepared >= 2 * 24 * 1_000 * 10);
    // A set of parameters of the larger model.
    let factors = Some(Tensor::pack(&[1], &[0.5_f32]));
    let vary = Some(bendtwin_proto::v1::Vary { friction: factors, ..Default::default() });
    let (exact, planned) = both(RollOutRequest { vary, ..asked.clone() });
    assert!(planned.fixed - exact.fixed >= 3 * 16 * (9_000 - 3_000 + 100 - 50));

    let keypoints = Keypoints { nodes: one(), targets: zeros(&[1, 3]), ..Keypoints::default() };
    let cost = Cost { kind: Some(Kind::Keypoints(keypoints)), ..Cost::default() };
    let asked = RollOutRequest { costs: vec![cost], ..asked };
    let (exact, planned) = both(asked.clone());
    assert!(planned.running - exact.running >= 128 * (2_000 + 1_000));

    let returns = Returns { control_gradients: true, ..Returns::default() };
    let (exact, planned) = both(RollOutRequest { returns: Some(returns), ..asked });
    assert!(planned.prepared - exact.prepared >= 16 * (9_000 - 3_000));
    let skin = 128 * (2_000 + 1_000);
    let gradients = 64 * (9_000 - 3_000);
    let tape = 48 * 1_001 * (400 - 10);
    assert!(planned.running - exact.running >= skin + gradients + tape);
}
