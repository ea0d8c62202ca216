//! Small captures and twins for this crate's tests.

use bendtwin_core::{
    Capture, Environment, Graph, NodeKind, Params, Pin, Point, Sequence, Timing, Twin,
    capture::{HeldPoint, Object},
};
use bendtwin_core_kit::twin_of;

/// A chain of `n` points 10 cm apart along x that moves by `step` per frame as a whole, both ends
/// held.
pub(crate) fn chain(n: usize, frames: usize, train: usize, step: Point) -> Capture {
    let at = |f: usize, p: usize| -> Point {
        let rest = [0.1 * p as f32, 0.0, 1.0];
        std::array::from_fn(|a| rest[a] + step[a] * f as f32)
    };
    let points: Vec<Point> = (0..frames).flat_map(|f| (0..n).map(move |p| at(f, p))).collect();
    let controls = (0..frames).flat_map(|f| [at(f, 0), at(f, n - 1)]).collect();
    let held = |point: u32, control: u32| HeldPoint { point, control };
    Capture {
        name: "chain".into(),
        fps: 100.0,
        environment: Environment { gravity: [0.0; 3], ground: None },
        source_to_world: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
        object: Object {
            point_count: n,
            edges: (1..n as u32).map(|i| [i - 1, i]).collect(),
            pins: vec![held(0, 0), held(n as u32 - 1, 1)],
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

/// The graph of [`chain`], without bending.
pub(crate) fn chain_graph(n: usize) -> Graph {
    let rest: Vec<Point> = (0..n).map(|p| [0.1 * p as f32, 0.0, 1.0]).collect();
    let pin = |node: u32, control: u32| Pin { node, control, offset_m: [0.0; 3] };
    Graph {
        control_rest: vec![rest[0], rest[n - 1]],
        rest_positions: rest,
        kinds: vec![NodeKind::Observed; n],
        masses: vec![1.0; n],
        object_ids: vec![0; n],
        observed_points: (0..n as u32).collect(),
        springs: (1..n as u32).map(|i| [i - 1, i]).collect(),
        triplets: Vec::new(),
        pins: vec![pin(0, 0), pin(n as u32 - 1, 1)],
        ..Graph::default()
    }
}

/// A soft twin on [`chain_graph`].
pub(crate) fn chain_twin(n: usize) -> Twin {
    let graph = chain_graph(n);
    let params = Params {
        spring_stiffness: vec![10.0; n - 1],
        spring_dashpot: vec![1.0; n - 1],
        rest_lengths_m: vec![0.1; n - 1],
        ..Params::default()
    };
    Twin {
        environment: Environment { gravity: [0.0; 3], ground: None },
        timing: Timing { fps: 100.0, substeps: 20 },
        ..twin_of(graph, params)
    }
}
