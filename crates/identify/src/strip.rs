//! A strip of soft material that a hand holds at one end, and recordings of it, for tests.

use std::sync::Arc;

use bendtwin_core::{
    CancelToken, Capture, Environment, Graph, NodeKind, Params, Pin, Plane, Point, Sequence,
    Timing, Twin, capture::Object, geometry::point_distance,
};
use bendtwin_core_kit::twin_of;
use bendtwin_engine::{
    Model, Objective,
    backend::{Instance, Outputs},
    cpu_with_threads,
    model::State,
    stable_substeps,
};

/// Distance of neighbouring nodes [m].
const SPACING_M: f32 = 0.02;
/// Frames a second.
const FPS: f64 = 30.0;

/// A strip of 20 x 2 x 2 nodes along x, which lies on the ground if there is one, held near x = 0.
pub(crate) fn strip(on_ground: bool) -> Twin {
    let mut nodes: Vec<Point> = Vec::new();
    for i in 0..20 {
        for (j, k) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
            nodes.push([i as f32, j as f32, k as f32 + 0.05].map(|x| SPACING_M * x));
        }
    }
    let control_rest: Vec<Point> = nodes[..4].to_vec();
    let n = nodes.len() as u32;
    let mut springs: Vec<[u32; 2]> = Vec::new();
    for a in 0..n {
        for b in a + 1..n {
            if point_distance(nodes[a as usize], nodes[b as usize]) < 1.8 * f64::from(SPACING_M) {
                springs.push([a, b]);
            }
        }
    }
    let mut rest_lengths_m: Vec<f32> = springs
        .iter()
        .map(|s| point_distance(nodes[s[0] as usize], nodes[s[1] as usize]) as f32)
        .collect();
    for c in 0..4 {
        springs.push([c + 4, n + c]);
        rest_lengths_m.push(SPACING_M);
        springs.push([c, n + (c + 1) % 4]);
        rest_lengths_m.push(SPACING_M);
    }
    let e = springs.len();
    let plane = Plane { normal: [0.0, 0.0, 1.0], offset_m: 0.0 };
    let graph = Graph {
        kinds: vec![NodeKind::Observed; nodes.len()],
        masses: vec![1.0; nodes.len()],
        object_ids: vec![0; nodes.len()],
        observed_points: (0..n).collect(),
        rest_positions: nodes,
        control_rest,
        springs,
        ..Graph::default()
    };
    let mut params = Params {
        spring_stiffness: vec![6e3; e],
        spring_dashpot: vec![10.0; e],
        rest_lengths_m,
        drag: 1.0,
        ..Params::default()
    };
    params.contact.ground_friction = 1.0;
    let mut twin = Twin {
        environment: Environment { gravity: [0.0, 0.0, -9.81], ground: on_ground.then_some(plane) },
        timing: Timing { fps: FPS, substeps: 1 },
        control_hands: vec![0; 4],
        ..twin_of(graph, params)
    };
    twin.timing.substeps = stable_substeps(&Model::from(&twin)).needed * 3 / 2;
    twin
}

/// A strip in weightlessness that a second hand holds in its middle, so that only the half between the
/// hands moves with the first.
pub(crate) fn held_in_the_middle() -> Twin {
    let mut twin = strip(false);
    twin.environment.gravity = [0.0; 3];
    let n = twin.graph.node_count() as u32;
    for node in 36..44 {
        let control = twin.graph.control_rest.len() as u32;
        twin.graph.pins.push(Pin { node, control, offset_m: [0.0; 3] });
        twin.graph.control_rest.push(twin.graph.rest_positions[node as usize]);
        twin.control_hands.push(1);
    }
    assert_eq!((n, twin.graph.control_count()), (80, 12));
    twin
}

/// The recording of a twin whose first hand is displaced so at each frame [m], with an error of some
/// millimetres that lasts and is shared by neighbours.
pub(crate) fn record(
    twin: &Twin,
    frames: usize,
    train: usize,
    path: impl Fn(f32) -> Point,
) -> Capture {
    let at = |frame: usize| path(frame as f32 / FPS as f32);
    let moved = |frame: usize| {
        let by = at(frame);
        let points = twin.graph.control_rest.iter().zip(&twin.control_hands);
        points.map(move |(p, hand)| match hand {
            0 => std::array::from_fn(|a| p[a] + by[a]),
            _ => *p,
        })
    };
    let controls: Vec<Point> = (0..frames).flat_map(moved).collect();
    let backend = cpu_with_threads(1);
    let model = backend.load(Arc::new(Model::from(twin))).unwrap();
    let batch = [Instance {
        model,
        initial: Arc::new(State::rest(&twin.graph)),
        controls: Arc::new(controls.clone()),
        frames: frames - 1,
        objective: Objective::default(),
        world: Arc::default(),
        motion: Arc::default(),
    }];
    let outputs = Outputs { every: 1, initial: true, ..Outputs::NONE };
    let rollout = backend.roll_out(&batch, &outputs, &CancelToken::default()).unwrap().remove(0);
    assert_eq!(rollout.diverged, None);
    let off = |(index, p): (usize, &Point)| -> Point {
        let t = (index / twin.graph.node_count()) as f32 / FPS as f32;
        std::array::from_fn(|a| p[a] + 0.001 * (12.0 * p[0] + 3.0 * t + 2.0 * a as f32).sin())
    };
    let first = twin.graph.node_count();
    let mut points = rollout.positions;
    let seen: Vec<Point> = points.iter().enumerate().map(off).collect();
    // The twin begins where it is.
    points[first..].copy_from_slice(&seen[first..]);
    Capture {
        name: "strip".into(),
        fps: FPS,
        environment: twin.environment,
        source_to_world: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
        object: Object {
            point_count: twin.graph.node_count(),
            control_hands: twin.control_hands.clone(),
            ..Object::default()
        },
        others: Vec::new(),
        sequences: vec![Sequence {
            name: "one".into(),
            frame_count: frames,
            train_frame_count: train,
            visible: vec![true; points.len()],
            motion_valid: vec![true; points.len()],
            points,
            controls,
            truth_tracks: Vec::new(),
            start_frames: 1,
        }],
    }
}

/// A hand that lifts by 8 cm and shakes a little.
pub(crate) fn lift(t: f32) -> Point {
    [0.0, 0.0, 0.08 * (2.0 * t).min(1.0) + 0.02 * (std::f32::consts::TAU * 3.0 * t).sin() * t]
}

/// A hand that lifts the whole strip and shakes it.
pub(crate) fn lift_and_shake(t: f32) -> Point {
    let swing = (std::f32::consts::TAU * 2.0 * t).sin();
    [0.0, 0.05 * swing, 0.5 * (1.5 * t).min(1.0)]
}
