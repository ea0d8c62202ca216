//! Rollouts of a planner's twin, in the words of its twin.

use std::f64::consts::PI;

use bendtwin_core::{Fidelity, PlannerQuality, PlannersTwin};
use bendtwin_engine::world::{Grasping, Hold, Phase};
use bendtwin_proto::v1::{
    self,
    cost::{
        Coverage, Order, Winding,
        winding::{Around, Axis},
    },
};

use super::*;
use crate::{request::initial::Start, twin::rest_shape::RestShape};

/// The chain with a planner's twin of its first, third and last node; the second hangs between two of
/// these.
fn with_planner() -> Twin {
    let mut twin = twin();
    let mut small = super::twin();
    small.graph.rest_positions.remove(1);
    small.graph.kinds.remove(1);
    small.graph.masses = vec![1.5, 1.5, 1.0];
    small.graph.object_ids.remove(1);
    small.graph.observed_points = vec![Graph::NOT_OBSERVED; 3];
    small.graph.springs = vec![[0, 3], [1, 0], [2, 1]];
    small.graph.triplets = vec![[0, 1, 2]];
    small.params.spring_stiffness.truncate(3);
    small.params.spring_dashpot.truncate(3);
    small.params.rest_lengths_m = vec![0.1, 0.2, 0.1];
    small.params.bend_stiffness.truncate(1);
    small.params.bend_damping.truncate(1);
    small.params.rest_angles_rad.truncate(1);
    small.timing.substeps = 30;
    small.skin = Skin::default();
    for _ in 0..2 {
        for weights in [&[(0, 1.0)][..], &[(0, 0.5), (1, 0.5)], &[(1, 1.0)], &[(2, 1.0)]] {
            small.skin.push(Graph::NOT_OBSERVED, weights, [Skin::NO_FRAME; 3], [0.0; 3]);
        }
    }
    twin.planner = Some(PlannersTwin { nodes: vec![0, 2, 3], twin: Box::new(small) });
    twin.quality.planner = Some(PlannerQuality {
        nodes: 3,
        springs: 3,
        triplets: 1,
        substeps: 30,
        mean_deviation_m: 1e-3,
        max_deviation_m: 4e-3,
        mean_travel_m: 0.1,
        frames: 30,
        actions: 8,
    });
    twin.check().unwrap();
    twin
}

struct Planning {
    bench: Bench,
    served: Served,
}

impl Planning {
    fn new() -> Self {
        Self::of(with_planner())
    }

    fn of(twin: Twin) -> Self {
        let bench = Bench::of(twin, bendtwin_engine::cpu_with_threads(2));
        let chosen = Served::choose(Arc::clone(&bench.warm), Fidelity::Planner, &bench.backend);
        let served = chosen.unwrap();
        Self { bench, served }
    }

    fn run(&self, request: RollOutRequest) -> Result<RollOutResponse, Error> {
        let (plan, wanted) = self.bench.plan_for(request, 0, self.served.clone())?;
        let Wanted::Ready(starts) = wanted else { panic!("no captures here") };
        Ok(self.bench.execute(&plan, &starts)?.remove(0))
    }
}

/// A request with these costs and returns, to the planner's twin.
fn asking(costs: Vec<Cost>, returns: Returns) -> RollOutRequest {
    let fidelity = v1::Fidelity::Planner.into();
    RollOutRequest { costs, returns: Some(returns), fidelity, ..request(2) }
}

fn cost(kind: Kind) -> Cost {
    Cost { kind: Some(kind), ..Cost::default() }
}

fn points(tensor: &Option<Tensor>) -> (Vec<usize>, Vec<[f32; 3]>) {
    tensor.as_ref().unwrap().unpack_points("t").unwrap()
}

#[test]
fn a_planner_answers_in_nodes_of_the_twin() {
    let planning = Planning::new();
    let keypoints = Keypoints {
        nodes: Some(Tensor::pack(&[2], &[1_u32, 3])),
        targets: Some(Tensor::pack_points(&[2], &[[0.0; 3]; 2])),
        ..Keypoints::default()
    };
    let returns = Returns {
        every_frames: 3,
        velocities: true,
        final_state: true,
        control_gradients: true,
        initial_gradients: true,
        ..Returns::default()
    };
    let reply = planning.run(asking(vec![cost(Kind::Keypoints(keypoints))], returns)).unwrap();
    assert_eq!((reply.fidelity(), reply.substeps), (v1::Fidelity::Planner, 30));
    assert_eq!(reply.deviation.unwrap().mean_m, 1e-3);
    let (shape, recorded) = points(&reply.positions);
    assert_eq!(shape, [2, 2, 4]);
    let (shape, ends) = points(&reply.final_positions);
    assert_eq!(shape, [2, 4]);
    assert_eq!(recorded[12..], ends[4..], "the last frame of the second instance");
    for (row, end) in ends.chunks(4).enumerate() {
        let middle: [f32; 3] = std::array::from_fn(|k| 0.5 * (end[0][k] + end[2][k]));
        assert!((0..3).all(|k| (middle[k] - end[1][k]).abs() < 1e-6), "{row}: {end:?}");
        let apart = |p: [f32; 3]| p.iter().map(|x| f64::from(*x).powi(2)).sum::<f64>().sqrt();
        let expected = 0.5 * (apart(end[1]) + apart(end[3]));
        let (_, costs) = reply.costs.as_ref().unwrap().unpack::<f64>("costs").unwrap();
        assert!((costs[row] - expected).abs() < 1e-5, "{} is not {expected}", costs[row]);
    }
    let (shape, gradients) = points(&reply.initial_position_gradients);
    assert_eq!(shape, [2, 4]);
    assert_eq!(gradients[1], [0.0; 3], "the planner's twin has no second node");
    assert_ne!(gradients[3], [0.0; 3]);
    assert_eq!(points(&reply.control_gradients).0, [2, 7, 1]);
}

/// The gradient of a cost by where the control point goes, against central differences.
#[test]
fn gradients_are_those_of_the_planner() {
    let planning = Planning::new();
    let ask = |x: f32| {
        let keypoints = Keypoints {
            nodes: Some(Tensor::pack(&[1], &[1_u32])),
            targets: Some(Tensor::pack_points(&[1], &[[0.3, 0.1, 0.4]])),
            squared: true,
            ..Keypoints::default()
        };
        let returns = Returns { action_gradients: true, ..Returns::default() };
        let mut request = asking(vec![cost(Kind::Keypoints(keypoints))], returns);
        let knots = [[0.0, 0.0, 0.6], [x, 0.0, 0.6]];
        request.actions = Some(Actions::Trajectories(ControlTrajectories {
            positions: Some(Tensor::pack_points(&[1, 2, 1], &knots)),
            interpolation: 0,
        }));
        planning.run(request).unwrap()
    };
    let value = |reply: &RollOutResponse| {
        reply.costs.as_ref().unwrap().unpack::<f64>("costs").unwrap().1[0]
    };
    let step = 5e-3;
    let difference =
        (value(&ask(0.05 + step)) - value(&ask(0.05 - step))) / (2.0 * f64::from(step));
    let gradient = f64::from(points(&ask(0.05).action_gradients).1[1][0]);
    assert!((gradient - difference).abs() < 0.02 * difference.abs(), "{gradient}, {difference}");
}

#[test]
fn states_go_through_a_planner_and_back() {
    let planning = Planning::new();
    let rest = twin().graph.rest_positions;
    let given = GivenState {
        positions: Some(Tensor::pack_points(&[4], &rest)),
        velocities: Some(Tensor::pack_points(&[4], &[[0.1, 0.0, 0.0]; 4])),
        ..GivenState::default()
    };
    let returns = Returns { every_frames: 6, ..Returns::default() };
    let plain = planning.run(asking(Vec::new(), returns.clone())).unwrap();
    let mut request = asking(Vec::new(), returns);
    request.initial = Some(InitialState { state: Some(State::Given(given)) });
    let moving = planning.run(request).unwrap();
    assert_ne!(points(&plain.positions).1, points(&moving.positions).1);
    // A state of a session is one of the twin, and stays what it is.
    let own = &planning.served.planner.as_ref().unwrap().own;
    let state = bendtwin_engine::model::State::rest(&planning.bench.warm.twin.graph);
    let start = Start::new(Arc::new(state), Arc::new(vec![[0.0, 0.0, 0.6]]));
    let thin = own.thinned(Starts::Shared(start)).unwrap();
    assert_eq!(thin.of(0).state.positions.len(), 3);
    let back = own.carried(&thin.of(0).state);
    assert_eq!(back.positions.len(), 4);
    let again = Start::new(Arc::new(back), Arc::new(vec![[0.0, 0.0, 0.6]]));
    let again = own.thinned(Starts::Shared(again)).unwrap();
    assert_eq!(again.of(0).state, thin.of(0).state);
}

#[test]
fn what_a_planner_does_not_measure_is_refused() {
    let planning = Planning::new();
    let target = Some(Tensor::pack_points(&[1], &[[0.0; 3]]));
    let cloud = |point_set: v1::PointSet| {
        let point_set = point_set.into();
        cost(Kind::TargetCloud(TargetCloud { points: target.clone(), point_set }))
    };
    let nodes = Some(Tensor::pack(&[1], &[1_u32]));
    let keypoints = Keypoints { nodes, targets: target.clone(), ..Keypoints::default() };
    let keypoints = || cost(Kind::Keypoints(keypoints.clone()));
    let run = |costs| planning.run(asking(costs, Returns::default()));
    let refused = run(vec![cloud(v1::PointSet::Skin), keypoints()]).unwrap_err();
    assert!(refused.to_string().contains("skin_points"), "{refused}");
    let covered = |point_set: v1::PointSet| {
        let (points, point_set) = (target.clone(), point_set.into());
        cost(Kind::Coverage(Coverage { points, reach_m: 0.1, point_set }))
    };
    let refused = run(vec![keypoints(), covered(v1::PointSet::Skin)]).unwrap_err();
    assert!(refused.to_string().contains("`costs[1].coverage`"), "{refused}");
    run(vec![cloud(v1::PointSet::Skin), covered(v1::PointSet::Skin)]).unwrap();
    run(vec![covered(v1::PointSet::Nodes), keypoints()]).unwrap();
    run(vec![cloud(v1::PointSet::Skin)]).unwrap();
    run(vec![cloud(v1::PointSet::Nodes), keypoints()]).unwrap();
    let beyond = Keypoints {
        nodes: Some(Tensor::pack(&[1], &[4_u32])),
        targets: target.clone(),
        ..Keypoints::default()
    };
    assert!(run(vec![cost(Kind::Keypoints(beyond))]).is_err(), "the twin has four nodes");
    let bench = Bench::new();
    let none = Served::choose(Arc::clone(&bench.warm), Fidelity::Planner, &bench.backend);
    let none = none.err().unwrap();
    assert_eq!(
        (none.category(), none.reason()),
        (Category::FailedPrecondition, "PLANNERS_TWIN_UNKNOWN")
    );
}

/// The second node is nearest to the first or to the third, which is in the list.
#[test]
fn chains_of_nodes_are_those_of_the_planner_in_their_order() {
    let planning = Planning::new();
    let list = |nodes: &[u32]| Some(Tensor::pack(&[nodes.len()], nodes));
    let order = |nodes: &[u32]| {
        let direction = vec![0.0, 0.0, 1.0];
        let order = Order { nodes: list(nodes), direction, gap_m: 0.15, skin_points: None };
        cost(Kind::Order(order))
    };
    let winding = |nodes: &[u32]| {
        let axis = Axis { point: vec![0.2, 0.0, 0.4], direction: vec![0.0, 1.0, 0.0] };
        let around = Some(Around::Axis(axis));
        cost(Kind::Winding(Winding { nodes: list(nodes), around, turns: 1.0, skin_points: None }))
    };
    let returns = Returns { final_state: true, ..Returns::default() };
    let run = |costs| planning.run(asking(costs, returns.clone()));
    let asked = run(vec![order(&[3, 2, 1, 0]), winding(&[0, 1, 2, 3])]).unwrap();
    let ends = points(&asked.final_positions).1;
    let terms = f64s(&asked.cost_terms);
    for (row, end) in ends.chunks(4).enumerate() {
        let lack = |from: usize, to: usize| (0.15 - f64::from(end[to][2] - end[from][2])).max(0.0);
        let expected = (lack(3, 2).powi(2) + lack(2, 0).powi(2)) / 2.0;
        assert!(expected > 1e-4, "{end:?}");
        assert!((terms[2 * row] - expected).abs() < 1e-6, "{} {expected}", terms[2 * row]);
        let angle = |i: usize| f64::from(end[i][0] - 0.2).atan2(f64::from(end[i][2] - 0.4));
        let turns = (angle(3) - angle(0) + PI).rem_euclid(2.0 * PI) - PI;
        let expected = (turns / (2.0 * PI) - 1.0).powi(2);
        assert!((terms[2 * row + 1] - expected).abs() < 1e-5, "{} {expected}", terms[2 * row + 1]);
    }
    for costs in [vec![order(&[3, 3])], vec![winding(&[0, 0, 0])]] {
        let refused = run(costs).unwrap_err();
        assert_eq!(refused.reason(), "INVALID_ROLLOUT");
        assert!(
            refused.to_string().contains("nodes` are all nearest to the same node"),
            "{refused}"
        );
    }
    // Points of the skin are the twin's own.
    let skin =
        Order { skin_points: list(&[3, 2]), direction: vec![0.0, 0.0, 1.0], ..Order::default() };
    run(vec![cost(Kind::Order(skin))]).unwrap();
}

/// The rest lengths of a twin are not those of its small model: such a state never reaches that.
#[test]
fn states_of_another_rest_shape_are_refused() {
    let planning = Planning::new();
    let params = planning.bench.warm.twin.params.clone();
    let rest = Arc::new(RestShape::new(params, None));
    let state = bendtwin_engine::model::State::rest(&planning.bench.warm.twin.graph);
    let plain = || Start::new(Arc::new(state.clone()), Arc::new(vec![[0.0, 0.0, 0.6]]));
    let corrected = Start { rest: Some(rest), ..plain() };
    let served = |starts: &Starts| planning.served.clone().with_rests(starts.rests());
    let refused = served(&Starts::Each(vec![plain(), corrected.clone()])).err().unwrap();
    assert_eq!(refused.reason(), "INVALID_ROLLOUT");
    assert!(refused.to_string().contains("EXACT or FAST"), "{refused}");
    assert!(served(&Starts::Each(vec![plain(), plain()])).is_ok());
    let exact = Served::exact(Arc::clone(&planning.bench.warm));
    assert!(exact.with_rests(Starts::Shared(corrected).rests()).is_ok());
}

/// The second node is not the planner's, so a grasp of it alone would open in silence.
#[test]
fn grasps_that_the_planner_would_open_are_refused() {
    let planning = Planning::new();
    let own = &planning.served.planner.as_ref().unwrap().own;
    let held = |phase: Phase, nodes: &[u32]| {
        let holds = nodes.iter().map(|&node| Hold { node, grasp: 0, place: [0.0; 3] }).collect();
        let grasping = Grasping { phases: vec![phase], holds };
        let rest = bendtwin_engine::model::State::rest(&planning.bench.warm.twin.graph);
        let state = bendtwin_engine::model::State { grasping, ..rest };
        own.thinned(Starts::Shared(Start::new(Arc::new(state), Arc::new(vec![[0.0, 0.0, 0.6]]))))
    };
    let refused = held(Phase::Closed, &[1]).err().unwrap();
    assert!(refused.to_string().contains("grasp 0"), "{refused}");
    let kept = held(Phase::Closed, &[1, 2]).unwrap();
    assert_eq!(kept.of(0).state.grasping.holds.len(), 1);
    // Nothing was held.
    assert!(held(Phase::Closed, &[]).is_ok());
    assert!(held(Phase::Slipped, &[]).is_ok());

    // A state that the request gives.
    let given = |holders: [u32; 4]| {
        let rest = twin().graph.rest_positions;
        let grasping = v1::Grasping {
            phases: Some(Tensor::pack(&[1], &[1_u32])),
            holders: Some(Tensor::pack(&[4], &holders)),
            places: Some(Tensor::pack_points(&[4], &[[0.0; 3]; 4])),
        };
        let given = GivenState {
            positions: Some(Tensor::pack_points(&[4], &rest)),
            grasping: Some(grasping),
            ..GivenState::default()
        };
        let mut request = asking(Vec::new(), Returns::default());
        request.initial = Some(InitialState { state: Some(State::Given(given)) });
        own.rewrite(&mut request)
    };
    let refused = given([0, 1, 0, 0]).err().unwrap();
    assert!(refused.to_string().contains("grasp more nodes"), "{refused}");
    assert!(given([0, 1, 1, 0]).is_ok());
}

/// Which costs are asked for must not change where the skin touches.
#[test]
fn keypoints_at_nodes_add_nothing_to_a_skin_that_touches() {
    let mut touching = with_planner();
    touching.params.contact.skin = true;
    touching.planner.as_mut().unwrap().twin.params.contact.skin = true;
    let planning = Planning::of(touching);
    let named = |nodes: Option<Tensor>, skin_points: Option<Tensor>| {
        let targets = Some(Tensor::pack_points(&[1], &[[0.0; 3]]));
        let keypoints = Keypoints { nodes, targets, skin_points, ..Keypoints::default() };
        planning.run(asking(vec![cost(Kind::Keypoints(keypoints))], Returns::default()))
    };
    let one = || Some(Tensor::pack(&[1], &[1_u32]));
    let refused = named(one(), None).unwrap_err();
    assert!(refused.to_string().contains("skin_contact"), "{refused}");
    named(None, one()).unwrap();
}
