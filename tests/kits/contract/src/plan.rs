//! Requests for plans.

use bendtwin_contract::rollout::TwinShape;
use bendtwin_proto::v1::{
    ActionSpace, Grasp, GraspSearch, Grasping, GripperPoses, InitialState, PlanBounds, PlanMethod,
    PlanRequest, RollOutRequest, Sphere, Tensor,
    action_space::Coordinates,
    grasp::{CaptureHand, Region},
    initial_state::{GivenState, State},
    plan_method::{Cem, Gradient, Method, Mppi},
    roll_out_request::Actions,
};

use crate::rollout;

const POSE: [f32; 7] = [0.0, 0.0, 0.1, 0.0, 0.0, 0.0, 1.0];

/// A malformed request.
#[derive(Clone, Debug)]
pub struct Case {
    /// The fault in a few words.
    pub what: &'static str,
    /// Text of the message: the field, or the limit.
    pub names: &'static str,
    /// The request; its twin is left to the caller.
    pub request: PlanRequest,
}

/// A plan of three knots for a twin.
pub fn sound(twin: &TwinShape) -> PlanRequest {
    let mut rollout = rollout::sound(twin);
    if let Some(Actions::Trajectories(t)) = &mut rollout.actions {
        let shape = [1, 3, twin.controls as usize];
        t.positions = Some(Tensor::pack_points(&shape, &vec![[0.0; 3]; shape.iter().product()]));
    }
    PlanRequest { rollout: Some(rollout), samples: 4, ..PlanRequest::default() }
}

/// The same with poses of one gripper.
pub fn sound_with_poses(twin: &TwinShape) -> PlanRequest {
    let good = sound(twin);
    let poses = Some(Tensor::pack(&[1, 3, 1, 7], &POSE.repeat(3)));
    let actions = Some(Actions::Poses(GripperPoses { poses, ..GripperPoses::default() }));
    let rollout = good.rollout.map(|rollout| RollOutRequest { actions, ..rollout });
    PlanRequest { rollout, ..good }
}

/// The same with two grippers, of which the first takes nodes at three places.
pub fn sound_with_places(twin: &TwinShape) -> PlanRequest {
    let mut good = sound_with_poses(twin);
    let poses = Some(Tensor::pack(&[1, 3, 2, 7], &POSE.repeat(6)));
    let region = Some(Region::Sphere(Sphere { center: Vec::new(), radius_m: 0.03 }));
    if let Some(rollout) = &mut good.rollout {
        rollout.actions = Some(Actions::Poses(GripperPoses { poses, ..GripperPoses::default() }));
        rollout.grasps = vec![Grasp { region, ..Grasp::default() }];
    }
    let poses = Some(Tensor::pack(&[3, 1, 7], &POSE.repeat(3)));
    let grasp_search = Some(GraspSearch { poses, grippers: vec![0] });
    PlanRequest { grasp_search, samples: 9, iterations: 3, ..good }
}

/// Requests with one fault each for a twin, which has neither rods nor a capture nor a fast
/// variant. A fault of the rollout that has one instance is among them.
pub fn malformed(twin: &TwinShape) -> Vec<Case> {
    let good = sound(twin);
    let mut cases = Vec::new();
    let mut add = |what, names, request| cases.push(Case { what, names, request });
    add("no rollout", "`rollout`", PlanRequest { rollout: None, ..good.clone() });
    let with = |change: &dyn Fn(&mut RollOutRequest)| {
        let mut request = good.clone();
        request.rollout.as_mut().map(change);
        request
    };
    add("two instances", "`rollout.actions`", with(&|r| r.actions = rollout::sound(twin).actions));
    add("no costs", "`rollout.costs`", with(&|r| r.costs.clear()));
    add("no actions", "`rollout.actions`", with(&|r| r.actions = None));
    add("100001 frames", "`rollout.frames`", with(&|r| r.frames = 100_001));
    add("no fast variant", "fast variant", with(&|r| r.fidelity = 2));
    let samples = |samples, iterations| PlanRequest { samples, iterations, ..good.clone() };
    add("a million instances", "number of instances", samples(1_000_000, 1));
    add("2^32 - 1 iterations", "number of plans", samples(4, u32::MAX));
    add("2^32 - 1 samples", "number of plans", samples(u32::MAX, 1));
    let faults = numbers(&good).into_iter().chain(spaces(&good, twin)).chain(places(twin));
    for (what, names, request) in faults {
        add(what, names, request);
    }
    cases
}

type Named = Vec<(&'static str, &'static str, PlanRequest)>;

fn floats(values: &[f32]) -> Option<Tensor> {
    Some(Tensor::pack(&[values.len()], values))
}

fn numbers(good: &PlanRequest) -> Named {
    let sigma = |values: &[f32]| PlanRequest { sigma: floats(values), ..good.clone() };
    let method =
        |method| PlanRequest { method: Some(PlanMethod { method: Some(method) }), ..good.clone() };
    let bounds = |bounds| PlanRequest { bounds: Some(bounds), ..good.clone() };
    let none = PlanBounds::default;
    let crossed = PlanBounds { low: floats(&[1.0]), high: floats(&[0.0]), ..none() };
    let indices = Some(Tensor::pack(&[1], &[1u32]));
    let rate = |values: &[f32]| Method::Gradient(Gradient { rate: floats(values) });
    let of = |change: &dyn Fn(&mut PlanRequest)| {
        let mut request = good.clone();
        change(&mut request);
        request
    };
    vec![
        ("two sigmas", "`sigma`", sigma(&[0.1, 0.1])),
        ("a sigma that is NaN", "`sigma`", sigma(&[f32::NAN])),
        ("a negative sigma", "`sigma`", sigma(&[-0.1])),
        ("sigmas as indices", "`sigma`", of(&|r| r.sigma.clone_from(&indices))),
        ("correlation 1", "`correlation`", of(&|r| r.correlation = 1.0)),
        ("a correlation that is NaN", "`correlation`", of(&|r| r.correlation = f64::NAN)),
        ("samples that do not become finer", "`finest`", of(&|r| r.finest = Some(2.0))),
        ("a negative deadline", "`deadline_s`", of(&|r| r.deadline_s = -1.0)),
        ("a deadline that is NaN", "`deadline_s`", of(&|r| r.deadline_s = f64::NAN)),
        ("an infinite shift", "`shift_frames`", of(&|r| r.shift_frames = f64::INFINITY)),
        ("a shift back", "`shift_frames`", of(&|r| r.shift_frames = -1.0)),
        (
            "a temperature below 0",
            "`method.mppi.temperature`",
            method(Method::Mppi(Mppi { temperature: -1.0 })),
        ),
        (
            "a memory of 1",
            "`method.cem.memory`",
            method(Method::Cem(Cem { memory: Some(1.0), ..Cem::default() })),
        ),
        ("a rate of 0", "`method.gradient.rate`", method(rate(&[0.0]))),
        ("two rates", "`method.gradient.rate`", method(rate(&[0.1, 0.1]))),
        ("crossed bounds", "`bounds.low`", bounds(crossed)),
        ("two bounds", "`bounds.high`", bounds(PlanBounds { high: floats(&[0.0; 2]), ..none() })),
        (
            "a speed below 0",
            "`bounds.speed`",
            bounds(PlanBounds { speed: floats(&[-1.0]), ..none() }),
        ),
        (
            "a bound that is NaN",
            "`bounds.low`",
            bounds(PlanBounds { low: floats(&[f32::NAN]), ..none() }),
        ),
    ]
}

fn spaces(good: &PlanRequest, twin: &TwinShape) -> Named {
    let space = |space| PlanRequest { space: Some(space), ..good.clone() };
    let of = |coordinates: Coordinates| ActionSpace {
        coordinates: coordinates.into(),
        ..ActionSpace::default()
    };
    let controls = twin.controls as usize;
    let groups = |values: &[u32]| Some(Tensor::pack(&[values.len()], values));
    let grouped =
        |values| ActionSpace { group_of_control: groups(values), ..of(Coordinates::PerGroup) };
    let start = |value: f32, points: usize| ActionSpace {
        start: Some(Tensor::pack_points(&[points], &vec![[value; 3]; points])),
        ..ActionSpace::default()
    };
    vec![
        (
            "coordinates 9",
            "`space.coordinates`",
            space(ActionSpace { coordinates: 9, ..start(0.0, controls) }),
        ),
        ("rotations of points", "`space.coordinates`", space(of(Coordinates::Rigid))),
        ("no groups", "`space.group_of_control`", space(of(Coordinates::PerGroup))),
        ("a group too many", "`space.group_of_control`", space(grouped(&vec![0; controls + 1]))),
        ("group 2^32 - 1", "`space.group_of_control`", space(grouped(&vec![u32::MAX; controls]))),
        (
            "groups of all together",
            "`space.group_of_control`",
            space(ActionSpace { coordinates: 0, ..grouped(&vec![0; controls]) }),
        ),
        ("a start of another shape", "`space.start`", space(start(0.0, controls + 1))),
        ("a start that is NaN", "`space.start`", space(start(f32::NAN, controls))),
    ]
}

/// Faults of a search of places to grasp.
fn places(twin: &TwinShape) -> Named {
    let good = sound_with_places(twin);
    let search = |shape: &[usize], values: &[f32], grippers: &[u32]| PlanRequest {
        grasp_search: Some(GraspSearch {
            poses: Some(Tensor::pack(shape, values)),
            grippers: grippers.to_vec(),
        }),
        ..good.clone()
    };
    let some = |places: usize, grippers: usize, of: &[u32]| {
        search(&[places, grippers, 7], &POSE.repeat(places * grippers), of)
    };
    let with = |change: &dyn Fn(&mut RollOutRequest)| {
        let mut request = good.clone();
        request.rollout.as_mut().map(change);
        request
    };
    let nodes = twin.nodes as usize;
    let held = |phase: u32| GivenState {
        positions: Some(Tensor::pack_points(&[nodes], &vec![[0.0; 3]; nodes])),
        grasping: Some(Grasping {
            phases: Some(Tensor::pack(&[1], &[phase])),
            holders: Some(Tensor::pack(&[nodes], &vec![0u32; nodes])),
            places: Some(Tensor::pack_points(&[nodes], &vec![[0.0; 3]; nodes])),
        }),
        ..GivenState::default()
    };
    let from = |state: GivenState| {
        with(&|r| r.initial = Some(InitialState { state: Some(State::Given(state.clone())) }))
    };
    let mut of_zeros = POSE.repeat(3);
    of_zeros[10..14].fill(0.0);
    let mut infinite = POSE.repeat(3);
    infinite[7] = f32::INFINITY;
    let of_points = PlanRequest { grasp_search: good.grasp_search.clone(), ..sound(twin) };
    let none = Some(GraspSearch { poses: None, grippers: vec![0] });
    let hand = Some(Region::Hand(CaptureHand { hand: 0 }));
    vec![
        ("places of points", "`grasp_search`", of_points),
        ("no places", "`grasp_search.poses`", PlanRequest { grasp_search: none, ..good.clone() }),
        ("one place", "`grasp_search.poses`", some(1, 1, &[0])),
        ("257 places", "`grasp_search.poses`", some(257, 1, &[0])),
        ("places of another number of grippers", "`grasp_search.poses`", some(3, 2, &[0])),
        ("places without numbers of grippers", "`grasp_search.poses`", some(3, 1, &[])),
        ("places of two numbers", "`grasp_search.poses`", search(&[3, 7], &POSE.repeat(3), &[0])),
        ("a place far away", "`grasp_search.poses`", search(&[3, 1, 7], &infinite, &[0])),
        ("a place without a rotation", "at place 1", search(&[3, 1, 7], &of_zeros, &[0])),
        ("gripper 2 of two", "`grasp_search.grippers`", some(3, 1, &[2])),
        ("a gripper twice", "`grasp_search.grippers`", some(3, 2, &[0, 0])),
        ("a gripper without a grasp", "none of gripper 1", some(3, 2, &[0, 1])),
        ("no grasp", "`rollout.grasps`", with(&|r| r.grasps.clear())),
        ("a hand's grasp", "`rollout.grasps`", with(&|r| r.grasps[0].region.clone_from(&hand))),
        ("what is held already", "gripper 0", from(held(1))),
        ("what has slipped already", "gripper 0", from(held(2))),
        ("too few samples", "`samples`", PlanRequest { samples: 8, ..good.clone() }),
        ("too few iterations", "`iterations`", PlanRequest { iterations: 2, ..good.clone() }),
    ]
}
