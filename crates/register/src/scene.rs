//! An object with a known state, for this crate's tests: an L of foam, held at its foot by two
//! control points.

use std::sync::Arc;

use bendtwin_core::{
    CancelToken, Environment, Graph, NodeKind, Params, Point, Skin, Timing,
    environment::ControlVelocity,
};
use bendtwin_engine::{
    Backend, Model, Objective,
    backend::{Instance, Outputs},
    model::State,
    world::{Collider, Face, Pose, Shape},
};
use bendtwin_graph::{SurfacePoints, bind_skin};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::Obstacle;

/// Distance of neighbouring nodes [m].
pub(crate) const SPACING_M: f32 = 0.02;

/// A bar of 7 by 3 by 2 nodes, 4 cm apart, without gravity; its skin, of points 1 cm apart, is 1 cm
/// outside of the nodes.
pub(crate) fn coarse() -> Model {
    let grid = |counts: [usize; 3], spacing_m: f32, from_m: f32| {
        let at = move |i: usize| from_m + spacing_m * i as f32;
        (0..counts[0]).flat_map(move |x| {
            (0..counts[1]).flat_map(move |y| (0..counts[2]).map(move |z| [at(x), at(y), at(z)]))
        })
    };
    let rest: Vec<Point> = grid([7, 3, 2], 0.04, 0.0).collect();
    let on_a_face = |p: &Point| {
        let sides = p.iter().zip([0.25, 0.09, 0.05]);
        sides.into_iter().any(|(x, most)| (*x + 0.01).abs() < 1e-4 || (*x - most).abs() < 1e-4)
    };
    let skin: Vec<Point> = grid([27, 11, 7], 0.01, -0.01).filter(on_a_face).collect();
    let (graph, params) = foam(rest, Vec::new(), 0.04);
    let surface =
        SurfacePoints { observed_points: vec![Graph::NOT_OBSERVED; skin.len()], positions: skin };
    let skin = bind_skin(&graph, &surface);
    let environment = Environment { ground: None, gravity: [0.0; 3] };
    Model {
        graph: Arc::new(graph),
        skin: Arc::new(skin),
        params,
        environment,
        timing: Timing { fps: 30.0, substeps: 60 },
        control_velocity: ControlVelocity::True,
    }
}

/// The L: 13 nodes long, with a foot to one side, two layers.
pub(crate) fn model() -> Arc<Model> {
    let mut rest: Vec<Point> = Vec::new();
    for z in 0..2 {
        for x in 0..13 {
            for y in 0..7 {
                if y < 2 || x < 3 {
                    rest.push([x, y, z].map(|i| SPACING_M * i as f32));
                }
            }
        }
    }
    let control_rest = vec![[0.02, 0.12, 0.05], [0.04, 0.12, 0.05]];
    let (graph, params) = foam(rest, control_rest, SPACING_M);
    Arc::new(Model {
        skin: Arc::new(Skin::of_nodes(&graph)),
        graph: Arc::new(graph),
        params,
        environment: Environment { ground: None, ..Environment::Z_UP },
        timing: Timing { fps: 30.0, substeps: 60 },
        control_velocity: ControlVelocity::True,
    })
}

/// Nodes at a distance, each joined with those around it, and with control points near it.
fn foam(rest: Vec<Point>, control_rest: Vec<Point>, spacing_m: f32) -> (Graph, Params) {
    let n = rest.len();
    let all: Vec<Point> = rest.iter().chain(&control_rest).copied().collect();
    let length =
        |a: usize, b: usize| bendtwin_core::geometry::point_distance(all[a], all[b]) as f32;
    let mut springs = Vec::new();
    for a in 0..n {
        for b in a + 1..all.len() {
            let reach = if b < n { 1.8 } else { 2.2 };
            if length(a, b) < reach * spacing_m {
                springs.push([a as u32, b as u32]);
            }
        }
    }
    let lengths: Vec<f32> = springs.iter().map(|s| length(s[0] as usize, s[1] as usize)).collect();
    let graph = Graph {
        kinds: vec![NodeKind::Observed; n],
        masses: vec![1.0; n],
        object_ids: vec![0; n],
        observed_points: (0..n as u32).collect(),
        rest_positions: rest,
        control_rest,
        springs,
        ..Graph::default()
    };
    let params = Params {
        spring_stiffness: vec![3000.0; lengths.len()],
        spring_dashpot: vec![20.0; lengths.len()],
        rest_lengths_m: lengths,
        drag: 1.0,
        ..Params::default()
    };
    (graph, params)
}

/// The state, and the control points, after some frames in which the hand moves sideways and up.
pub(crate) fn moved(backend: &dyn Backend, frames: usize) -> (State, Vec<Point>) {
    let model = model();
    let rest = model.graph.control_rest.clone();
    let at = |f: usize| {
        let t = (f as f32 / frames.max(1) as f32).min(1.0);
        rest.iter().map(move |p| [p[0] - 0.1 * t, p[1] + 0.05 * t, p[2] + 0.15 * t])
    };
    let controls: Vec<Point> = (0..=frames).flat_map(at).collect();
    let last = controls[controls.len() - rest.len()..].to_vec();
    (roll(backend, &State::rest(&model.graph), controls, frames), last)
}

/// The state after some frames.
pub(crate) fn roll(
    backend: &dyn Backend,
    from: &State,
    controls: Vec<Point>,
    frames: usize,
) -> State {
    let instance = Instance {
        model: backend.load(model()).unwrap(),
        initial: Arc::new(from.clone()),
        controls: Arc::new(controls),
        frames,
        objective: Objective::default(),
        world: Arc::default(),
        motion: Arc::default(),
    };
    let outputs = Outputs { final_state: true, ..Outputs::NONE };
    let rollouts = backend.roll_out(&[instance], &outputs, &CancelToken::default()).unwrap();
    rollouts.into_iter().next().unwrap().final_state.unwrap()
}

/// Noise of a standard deviation per coordinate.
pub(crate) fn noisy(points: &[Point], deviation_m: f32, seed: u64) -> Vec<Point> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    // The sum of twelve uniform numbers less six is nearly normal.
    let mut normal = move || (0..12).map(|_| rng.random::<f32>()).sum::<f32>() - 6.0;
    points.iter().map(|p| p.map(|x| x + deviation_m * normal())).collect()
}

/// Mean and largest distance of points to others [m].
pub(crate) fn apart(a: &[Point], b: &[Point]) -> (f64, f64) {
    assert_eq!(a.len(), b.len());
    let distances = a.iter().zip(b).map(|(a, b)| bendtwin_core::geometry::point_distance(*a, *b));
    let (sum, most) = distances.fold((0.0, 0.0_f64), |(sum, most), d| (sum + d, most.max(d)));
    (sum / a.len() as f64, most)
}

/// A box that stands in the world, grown by nothing.
pub(crate) fn cuboid(low: Point, high: Point) -> Obstacle {
    let face = |axis: usize, sign: f32, offset_m: f32| {
        let mut normal = [0.0; 3];
        normal[axis] = sign;
        Face { normal, offset_m }
    };
    let faces = (0..3).flat_map(|i| [face(i, -1.0, -low[i]), face(i, 1.0, high[i])]).collect();
    standing(Shape::Convex(Arc::new(faces)))
}

/// A peg, or a ball, that stands in the world.
pub(crate) fn peg(from: Point, to: Point, radius_m: f32) -> Obstacle {
    standing(Shape::Capsule { from, to, radius_m })
}

fn standing(shape: Shape) -> Obstacle {
    let collider = Collider { body: None, shape, friction: 0.5, restitution: 0.0 };
    Obstacle { collider, motion: Pose::default() }
}
