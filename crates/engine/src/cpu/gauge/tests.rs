use std::sync::Arc;

use bendtwin_core::{
    CancelToken, Contact, Environment, Graph, NodeKind, Params, Skin, Timing,
    environment::ControlVelocity,
};

use super::*;
use crate::{
    Backend, Objective, PointLoss, PointSet, Term, World,
    backend::{Outputs, Rollout},
    cpu_with_threads,
    model::State,
    objective::WeightedTerm,
    world::{Collider, IDENTITY, Motion, Shape},
};

const NODES: usize = 6;
const FRAMES: usize = 5;

/// A falling chain with a skin, beside a capsule that a body carries, and a term of every kind but
/// forces in every frame.
fn instance(backend: &dyn Backend) -> Instance {
    let rest: Vec<Point> =
        (0..NODES).map(|i| [0.05 * i as f32, 0.01 * (i % 2) as f32, 0.2]).collect();
    let graph = Graph {
        kinds: vec![NodeKind::Observed; NODES],
        masses: vec![1.0; NODES],
        object_ids: vec![0; NODES],
        observed_points: vec![Graph::NOT_OBSERVED; NODES],
        springs: (1..NODES as u32).map(|i| [i - 1, i]).collect(),
        rest_positions: rest.clone(),
        ..Graph::default()
    };
    let mut skin = Skin::default();
    skin.push(Graph::NOT_OBSERVED, &[(0, 0.5), (1, 0.5)], [Skin::NO_FRAME; 3], [0.0; 3]);
    skin.push(Graph::NOT_OBSERVED, &[(2, 1.0)], [1, 2, 3], [0.0, 0.01, 0.02]);
    let springs = graph.springs.len();
    let model = Model {
        skin: Arc::new(skin),
        params: Params {
            spring_stiffness: vec![200.0; springs],
            spring_dashpot: vec![1.0; springs],
            rest_lengths_m: vec![0.05; springs],
            contact: Contact { within_object: false, ..Contact::default() },
            ..Params::default()
        },
        graph: Arc::new(graph.clone()),
        environment: Environment { gravity: [0.0, 0.0, -9.81], ground: None },
        timing: Timing { fps: 30.0, substeps: 100 },
        control_velocity: ControlVelocity::True,
    };
    let targets: Vec<Point> = rest.iter().map(|p| [p[0] + 0.013, p[1] - 0.021, 0.1]).collect();
    let track = |of, points: &[u32], loss| Term::Track {
        of,
        points: points.to_vec(),
        targets: targets[..points.len()].to_vec(),
        loss,
    };
    let kinds = [
        Term::Chamfer { of: PointSet::Nodes, targets: targets.clone() },
        Term::Chamfer { of: PointSet::Skin, targets: targets.clone() },
        track(PointSet::Nodes, &[0, 3], PointLoss::SmoothL1 { beta_m: 0.01 }),
        track(PointSet::Nodes, &[5], PointLoss::Distance),
        track(PointSet::Skin, &[1, 0], PointLoss::SquaredDistance),
        Term::Acceleration,
        Term::Strain { limit: 0.01 },
        Term::Above { nodes: None, normal: [0.0, 0.0, 1.0], offset_m: 0.15 },
        Term::Within { nodes: None, low: [0.0; 3], high: [0.1, 0.2, 0.18] },
        Term::Clearance { collider: 0, margin_m: 0.15 },
        Term::Order {
            of: PointSet::Nodes,
            points: Arc::new(vec![0, 2, 4]),
            direction: [0.6, 0.0, 0.8],
            gap_m: 0.1,
        },
        Term::Winding {
            of: PointSet::Nodes,
            points: Arc::new(vec![0, 1, 3, 5]),
            origin: [0.1, 0.05, 0.0],
            direction: [0.0, 0.0, 1.0],
            turns: 1.0,
        },
        Term::Coverage { of: PointSet::Skin, targets: Arc::new(targets.clone()), reach_m: 0.1 },
    ];
    let terms = (1..=FRAMES).flat_map(|frame| {
        let weighted = |(group, term): (usize, &Term)| WeightedTerm {
            frame,
            weight: 1.0 + group as f32,
            group,
            term: term.clone(),
        };
        kinds.iter().enumerate().map(weighted).collect::<Vec<_>>()
    });
    let shape = Shape::Capsule { from: [0.0; 3], to: [0.1, 0.0, 0.0], radius_m: 0.02 };
    let collider = Collider { body: Some(0), shape, friction: 0.5, restitution: 0.0 };
    let pose = |frame: usize| {
        let mut pose = IDENTITY;
        (pose[0][3], pose[2][3]) = (0.1 + 0.01 * frame as f32, 0.3);
        pose
    };
    let groups = (0..kinds.len()).map(|group| group.to_string()).collect();
    let objective = Objective { groups, terms: Arc::new(terms.collect()) };
    let velocities = (0..NODES).map(|i| [0.1 * i as f32, 0.0, 0.3]).collect();
    Instance {
        model: backend.load(Arc::new(model)).unwrap(),
        initial: Arc::new(State { velocities, ..State::rest(&graph) }),
        controls: Arc::default(),
        frames: FRAMES,
        objective,
        world: Arc::new(World { bodies: 1, colliders: vec![collider], ..World::default() }),
        motion: Arc::new(Motion { poses: (0..=FRAMES).map(pose).collect(), ..Motion::default() }),
    }
}

fn simulated() -> (Instance, Rollout) {
    let backend = cpu_with_threads(1);
    let instance = instance(&*backend);
    let outputs = Outputs { every: 1, initial: true, frame_costs: true, ..Outputs::default() };
    let batch = std::slice::from_ref(&instance);
    let mut rollouts = backend.roll_out(batch, &outputs, &CancelToken::default()).unwrap();
    (instance, rollouts.remove(0))
}

#[test]
fn costs_along_a_simulated_path_are_those_of_its_simulation() {
    let (instance, rollout) = simulated();
    let gauge = Gauge::new(instance.model.model());
    assert_eq!(gauge.frame_costs(&instance, &rollout.positions), rollout.frame_costs);
    for (group, cost) in rollout.group_costs.iter().enumerate() {
        assert!(
            *cost > 1e-9,
            "the term of group {group} counts nothing: the test says nothing of it"
        );
    }
    // A path that ends early has no costs after that.
    let short = gauge.frame_costs(&instance, &rollout.positions[..3 * NODES]);
    let groups = instance.objective.groups.len();
    assert_eq!(short[..3 * groups], rollout.frame_costs[..3 * groups]);
    assert!(
        short.len() == rollout.frame_costs.len() && short[3 * groups..].iter().all(|c| *c == 0.0)
    );
}

#[test]
fn gradients_along_a_path_are_those_of_finite_differences() {
    let (instance, rollout) = simulated();
    let gauge = Gauge::new(instance.model.model());
    let gradient = gauge.gradient(&instance, &rollout.positions);
    // Of terms that do not change nothing is left, not even their rounding.
    let sum = |instance: &Instance, positions: &[Point]| {
        let costs = gauge.frame_costs(instance, positions);
        costs.iter().zip(&rollout.frame_costs).map(|(cost, before)| cost - before).sum::<f64>()
    };
    let largest = |all: &[f32]| all.iter().fold(0.0_f32, |most, x| most.max(x.abs()));
    let step = 1e-5_f32;
    // Between two kinks of a term, one where a limit or another nearest point is met, slopes on both
    // sides agree.
    let mut kinks = 0;
    let mut close =
        |found: f32, [less, more]: [f64; 2], widths: [f64; 2], most: f32, what: &str| {
            let slopes = [-less / widths[0], more / widths[1]];
            let allowed = 0.02 * f64::from(most);
            if (slopes[0] - slopes[1]).abs() > 3.0 * allowed {
                kinks += 1;
                return;
            }
            let expected = (more - less) / (widths[0] + widths[1]);
            let error = (expected - f64::from(found)).abs();
            assert!(error < allowed, "{what}: {found} is not {expected}");
        };
    let most = largest(gradient.positions.as_flattened());
    assert!(most > 0.1, "{most}");
    for i in 0..rollout.positions.len() {
        for axis in 0..3 {
            let own = f64::from(rollout.positions[i][axis]);
            let at = |by: f32| {
                let mut moved = rollout.positions.clone();
                moved[i][axis] += by;
                (f64::from(moved[i][axis]), sum(&instance, &moved))
            };
            let ((low, less), (high, more)) = (at(-step), at(step));
            let (found, widths) = (gradient.positions[i][axis], [own - low, high - own]);
            close(found, [less, more], widths, most, &format!("{i} {axis}"));
        }
    }
    let most = largest(gradient.poses.as_flattened().as_flattened());
    assert!(most > 1e-3, "{most}");
    for frame in 0..=FRAMES {
        for (row, column) in [(0, 3), (2, 3), (1, 1)] {
            let at = |by: f32| {
                let mut motion = Motion::clone(&instance.motion);
                motion.poses[frame][row][column] += by;
                sum(&Instance { motion: Arc::new(motion), ..instance.clone() }, &rollout.positions)
            };
            let (found, widths) = (gradient.poses[frame][row][column], [f64::from(step); 2]);
            let what = format!("pose {frame} {row} {column}");
            close(found, [at(-step), at(step)], widths, most, &what);
        }
    }
    assert!(kinks < 8, "{kinks} kinks: the test says little");
}
