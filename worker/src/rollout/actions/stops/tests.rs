use bendtwin_core::{NodeKind, Pin};
use bendtwin_proto::v1::{
    ControlTrajectories, GripperPoses, Tensor, roll_out_request::Actions as Wire,
};

use super::*;
use crate::rollout::actions::Horizon;

const TABLE: Plane = Plane { normal: [0.0, 0.0, 1.0], offset_m: 0.1 };
/// Control points of two hands, the second on the table.
const START: [Point; 3] = [[0.0, 0.0, 0.14], [0.02, 0.0, 0.13], [0.3, 0.0, 0.1]];
const HANDS: [u32; 3] = [0, 0, 1];
const ALLOWED_M: f32 = 0.005;
const FRAMES: usize = 4;

/// Node 0 is pinned 10 mm below control point 0.
fn graph() -> Graph {
    Graph {
        rest_positions: vec![[0.0, 0.0, 0.13]],
        kinds: vec![NodeKind::Observed],
        control_rest: START.to_vec(),
        pins: vec![Pin { node: 0, control: 0, offset_m: [0.0, 0.0, -0.01] }],
        ..Graph::default()
    }
}

fn horizon() -> Horizon {
    Horizon { frames: FRAMES, fps: 30.0, times: None }
}

/// All control points go down by as much in every frame, along a slope.
fn lowered(by: f32) -> Actions {
    let at = |f: usize| START.map(|[x, y, z]| [x + 0.001 * f as f32, y, z - by * f as f32]);
    let rows: Vec<Point> = (0..=FRAMES).flat_map(at).collect();
    let positions = Some(Tensor::pack_points(&[1, FRAMES + 1, 3], &rows));
    let wire = ControlTrajectories { positions, interpolation: 0 };
    let actions = Actions::read(Some(Wire::Trajectories(wire)), 3, horizon()).unwrap();
    actions.with_hands(&HANDS)
}

fn floor(graph: &Graph, carried: Vec<Carried>) -> Floor<'_> {
    Floor { plane: TABLE, allowed_m: ALLOWED_M, graph, start: &START, carried }
}

fn close(a: f32, b: f32) -> bool {
    (a - b).abs() < 1e-6
}

#[test]
fn a_hand_stops_at_the_ground_as_a_whole() {
    let graph = graph();
    let actions = lowered(0.02);
    let mut controls = actions.controls(0, &START);
    let asked = controls.clone();
    let stops = actions.stop(&mut controls, &mut [], floor(&graph, Vec::new()));
    // In the last frame the pinned node of hand 0 would be 50 mm deep, hand 1 80 mm.
    let last = 3 * FRAMES;
    let lifted = |c: usize| controls[last + c][2] - asked[last + c][2];
    assert!(close(lifted(0), 0.045) && close(lifted(1), 0.045), "{controls:?}");
    assert!(close(lifted(2), 0.075), "{controls:?}");
    assert!(close(controls[last][0], asked[last][0]));
    let most = stops.most();
    assert!(close(most.shift_m, 0.075) && most.frame == FRAMES, "{most:?}");
    // Whatever is above the table stays as it was.
    assert_eq!(controls[..3], asked[..3]);
    let mut gently = lowered(0.001).controls(0, &START);
    let stops = actions.stop(&mut gently, &mut [], floor(&graph, Vec::new()));
    assert_eq!((stops.most(), gently), (Stopped::default(), lowered(0.001).controls(0, &START)));
}

/// A gripper that carries a hand and takes hold 20 mm in front of itself, and turns on its way down.
fn gripper(poses: &[[f32; 7]]) -> Actions {
    let knots = poses.len();
    let wire = GripperPoses {
        poses: Some(Tensor::pack(&[1, knots, 1, 7], poses.as_flattened())),
        gripper_of_control: None,
        interpolation: 0,
    };
    Actions::read(Some(Wire::Poses(wire)), 3, horizon()).unwrap()
}

fn poses(depth: f32) -> Vec<[f32; 7]> {
    let at = |f: usize| {
        let t = f as f32;
        [0.0, 0.01 * t, 0.2 - depth * t, 0.02 * t, 0.05 * t, 0.0, 1.0]
    };
    (0..=FRAMES).map(at).collect()
}

fn carried() -> Vec<Carried> {
    vec![Carried { gripper: 0, place: [0.02, 0.0, -0.05], began: None, until: usize::MAX }]
}

#[test]
fn a_gripper_stops_with_all_that_it_carries() {
    let graph = graph();
    for (depth, carried) in [(0.06, carried()), (0.06, Vec::new())] {
        let actions = gripper(&poses(depth));
        let mut controls = actions.controls(0, &START);
        let mut bodies = actions.bodies(0);
        let before = bodies.clone();
        let stops = actions.stop(&mut controls, &mut bodies, floor(&graph, carried.clone()));
        let lifted = bodies[FRAMES][2][3] - before[FRAMES][2][3];
        assert!(lifted > 0.02 && close(lifted, stops.most().shift_m), "{lifted}");
        for frame in 1..=FRAMES {
            let low = |x: Point| TABLE.offset_m - x[2];
            let deepest = controls[3 * frame..3 * frame + 3].iter().map(|x| low(*x));
            let middles = carried.iter().map(|p| low(at(&bodies[frame], p.place)));
            let most = deepest.chain(middles).fold(f32::MIN, f32::max);
            assert!(most < ALLOWED_M + 1e-6, "{most} in frame {frame}");
        }
    }
}

#[test]
fn gradients_through_a_stop_agree_with_differences() {
    let graph = graph();
    let weight = |i: usize| (1.7 * i as f32).sin();
    let value = |actions: &Actions, carried: &[Carried]| -> f64 {
        let mut controls = actions.controls(0, &START);
        let mut bodies = actions.bodies(0);
        actions.stop(&mut controls, &mut bodies, floor(&graph, carried.to_vec()));
        let points = controls.as_flattened().iter().enumerate().skip(9);
        let entries = bodies.as_flattened().as_flattened().iter().enumerate();
        points.map(|(i, x)| f64::from(*x) * f64::from(weight(i))).sum::<f64>()
            + entries.map(|(i, x)| f64::from(*x) * f64::from(weight(i + 500))).sum::<f64>()
    };
    for carried in [carried(), Vec::new()] {
        let poses = poses(0.06);
        let actions = gripper(&poses);
        let mut controls = actions.controls(0, &START);
        let mut bodies = actions.bodies(0);
        let stops = actions.stop(&mut controls, &mut bodies, floor(&graph, carried.clone()));
        assert!(stops.most().shift_m > 0.02);
        let point = |i: usize| -> Point {
            std::array::from_fn(|c| if 3 * i + c < 9 { 0.0 } else { weight(3 * i + c) })
        };
        let pose = |i: usize| -> Pose {
            std::array::from_fn(|r| std::array::from_fn(|c| weight(500 + 12 * i + 4 * r + c)))
        };
        let mut by = Gradient {
            controls: (0..controls.len()).map(point).collect(),
            poses: (0..bodies.len()).map(pose).collect(),
            ..Gradient::default()
        };
        stops.back(&actions, &mut by);
        let found = actions.gradient(0, &START, &by);
        for (i, found) in found.iter().enumerate() {
            let moved = |by: f32| {
                let mut poses = poses.clone();
                poses[i / 7][i % 7] += by;
                value(&gripper(&poses), &carried)
            };
            let expected = (moved(2e-3) - moved(-2e-3)) / 4e-3;
            let error = (f64::from(*found) - expected).abs();
            assert!(error < 5e-3 * (1.0 + expected.abs()), "{i}: {found} {expected}");
        }
    }
}
