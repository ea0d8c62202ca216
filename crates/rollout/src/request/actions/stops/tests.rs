use std::sync::Arc;

use bendtwin_core::{NodeKind, Pin};
use bendtwin_engine::model::State;
use bendtwin_proto::v1::{
    ControlTrajectories, GripperPoses, Tensor, roll_out_request::Actions as Wire,
};
use proptest::prelude::*;

use super::*;
use crate::request::actions::Horizon;

const TABLE: Plane = Plane { normal: [0.0, 0.0, 1.0], offset_m: 0.1 };
/// Control points of two hands, the second on the table.
const START: [Point; 3] = [[0.0, 0.0, 0.14], [0.02, 0.0, 0.13], [0.3, 0.0, 0.1]];
const HANDS: [u32; 3] = [0, 0, 1];
const ALLOWED_M: f32 = 0.005;
const FRAMES: usize = 4;
/// The middle of a grasp of the second gripper, in its coordinates.
const MIDDLE: Point = [0.01, 0.0, -0.03];

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

fn start(controls: &[Point]) -> Start {
    Start::new(Arc::new(State::default()), Arc::new(controls.to_vec()))
}

fn horizon(frames: usize) -> Horizon {
    Horizon { frames, fps: 30.0, times: None }
}

/// Actions with these positions of the control points in every frame.
fn trajectories(rows: &[Point]) -> Actions {
    let frames = rows.len() / 3 - 1;
    let positions = Some(Tensor::pack_points(&[1, frames + 1, 3], rows));
    let wire = ControlTrajectories { positions, interpolation: 0 };
    let actions = Actions::read(Some(Wire::Trajectories(wire)), 3, horizon(frames)).unwrap();
    actions.with_hands(&HANDS)
}

/// Actions with these poses of two grippers in every frame.
fn poses(rows: &[[f32; 7]]) -> Actions {
    let frames = rows.len() / 2 - 1;
    let poses = Some(Tensor::pack(&[1, frames + 1, 2, 7], rows.as_flattened()));
    let gripper_of_control = Some(Tensor::pack(&[3], &HANDS));
    let wire = GripperPoses { poses, gripper_of_control, interpolation: 0 };
    Actions::read(Some(Wire::Poses(wire)), 3, horizon(frames)).unwrap()
}

/// Actions that lower all control points by the same distance in every frame, along a slope.
fn lowered(by: f32) -> Actions {
    let at = |f: usize| START.map(|[x, y, z]| [x + 0.001 * f as f32, y, z - by * f as f32]);
    trajectories(&(0..=FRAMES).flat_map(at).collect::<Vec<_>>())
}

fn floor<'a>(graph: &'a Graph, start: &'a Start) -> Floor<'a> {
    Floor { plane: TABLE, allowed_m: ALLOWED_M, graph, own: None, start, middles: Vec::new() }
}

fn close(a: f32, b: f32) -> bool {
    (a - b).abs() < 1e-6
}

#[test]
fn a_hand_stops_at_the_ground_as_a_whole() {
    let (graph, start) = (graph(), start(&START));
    let actions = lowered(0.02);
    let mut controls = actions.controls(0, &START);
    let asked = controls.clone();
    let stops = actions.stop(&mut controls, &mut [], &floor(&graph, &start));
    // In the last frame the pinned node of hand 0 would be 50 mm deep, hand 1 80 mm.
    let last = 3 * FRAMES;
    let lifted = |c: usize| controls[last + c][2] - asked[last + c][2];
    assert!(close(lifted(0), 0.045) && close(lifted(1), 0.045), "{controls:?}");
    assert!(close(lifted(2), 0.075), "{controls:?}");
    assert!(close(controls[last][0], asked[last][0]));
    let most = stops.most();
    assert!(close(most.shift_m, 0.075) && most.frame == FRAMES, "{most:?}");
    // Everything above the table is unchanged.
    assert_eq!(controls[..3], asked[..3]);
    let mut gently = lowered(0.001).controls(0, &START);
    let stops = actions.stop(&mut gently, &mut [], &floor(&graph, &start));
    assert_eq!((stops.most(), gently), (Stopped::default(), lowered(0.001).controls(0, &START)));
}

#[test]
fn a_gripper_stops_with_all_that_it_carries() {
    let (graph, start) = (graph(), start(&START));
    let down = |f: usize| {
        let z = 0.2 - 0.06 * f as f32;
        [[0.0, 0.0, z, 0.0, 0.0, 0.0, 1.0f32], [0.3, 0.0, 0.2, 0.0, 0.0, 0.0, 1.0]]
    };
    let actions = poses(&(0..=FRAMES).flat_map(down).collect::<Vec<_>>());
    let run = |middles: Vec<(usize, Point)>| {
        let (mut controls, mut bodies) = (actions.controls(0, &START), actions.bodies(0));
        let floor = Floor { middles, ..floor(&graph, &start) };
        let stops = actions.stop(&mut controls, &mut bodies, &floor);
        (stops.most(), controls, bodies)
    };
    // The pinned node of gripper 0 would be 210 mm deep.
    let (most, controls, bodies) = run(Vec::new());
    assert!(close(most.shift_m, 0.205) && most.frame == FRAMES, "{most:?}");
    assert!(close(controls[3 * FRAMES][2], 0.105), "{controls:?}");
    assert!(close(bodies[2 * FRAMES][2][3], 0.2 - 0.24 + 0.205), "{bodies:?}");
    // The other one goes nowhere.
    assert!(bodies.iter().skip(1).step_by(2).all(|body| *body == bodies[1]));
    // The middle of a grasp 100 mm below the pose is 30 mm deeper than that node.
    let (most, ..) = run(vec![(0, [0.0, 0.0, -0.1])]);
    assert!(close(most.shift_m, 0.235), "{most:?}");
}

#[test]
fn a_hand_may_keep_its_depth_and_that_of_the_twin_at_rest() {
    let graph = graph();
    let deep = START.map(|[x, y, z]| [x, y, z - 0.08]);
    let heights = [0.0, 0.0, 0.03, 0.0];
    let rows = heights.map(|up| deep.map(|[x, y, z]| [x, y, z + up])).concat();
    let actions = trajectories(&rows);
    let lifted = |own: Option<Plane>| {
        let start = start(&deep);
        let mut controls = rows.clone();
        actions.stop(&mut controls, &mut [], &Floor { own, ..floor(&graph, &start) });
        let hand = controls.iter().skip(2).step_by(3).zip(deep[2..].iter().cycle());
        hand.map(|(x, began)| x[2] - began[2]).collect::<Vec<_>>()
    };
    // It begins 80 mm deep and rises by 30; then it does not sink again.
    let found = lifted(None);
    assert!(found.iter().zip([0.0, 0.0, 0.03, 0.03]).all(|(a, b)| close(*a, b)), "{found:?}");
    // At rest it is 100 mm below the ground of the twin.
    let own = Plane { offset_m: 0.2, ..TABLE };
    assert!(lifted(Some(own)).iter().zip(heights).all(|(a, b)| close(*a, b)));
}

/// A path of two grippers that turn, above the table and below.
fn path() -> impl Strategy<Value = Vec<[f32; 7]>> {
    let pose = (prop::array::uniform3(-0.2f32..0.2), prop::array::uniform4(-1.0f32..1.0));
    let pose = pose.prop_map(|([x, y, z], [a, b, c, w])| [x, y, z + 0.1, a, b, c, w.abs() + 0.2]);
    prop::collection::vec(pose, 18)
}

proptest! {
    /// Frames that are executed in any parts stop where those of one rollout do, bit for bit.
    #[test]
    fn a_stop_is_the_same_in_parts(path in path(), cuts in prop::collection::btree_set(1usize..8, 0..4)) {
        let (graph, begin) = (graph(), start(&START));
        let run = |rows: &[[f32; 7]], start: &Start| {
            let actions = poses(rows);
            let mut controls = actions.controls(0, start.commanded());
            let commanded = controls.clone();
            let mut bodies = actions.bodies(0);
            let floor = Floor { middles: vec![(1, MIDDLE)], ..floor(&graph, start) };
            actions.stop(&mut controls, &mut bodies, &floor);
            (controls, commanded, bodies)
        };
        let (whole, _, bodies) = run(&path, &begin);
        let mut from = 0;
        let mut now = begin;
        for to in cuts.into_iter().chain([8]) {
            let (controls, commanded, own) = run(&path[2 * from..2 * (to + 1)], &now);
            prop_assert_eq!(&controls[..], &whole[3 * from..3 * (to + 1)]);
            prop_assert_eq!(&own[..], &bodies[2 * from..2 * (to + 1)]);
            let (last, end) = (controls.len() - 3, commanded.len() - 3);
            let commanded = Some(Arc::new(commanded[end..].to_vec()));
            now = Start { commanded, ..start(&controls[last..]) };
            from = to;
        }
        // All points of a gripper are where they may be.
        for (controls, bodies) in whole.chunks(3).zip(bodies.chunks(2)).skip(1) {
            let pinned = controls[0][2] - 0.01;
            let middle = bodies[1][2];
            let middle: f32 = (0..3).map(|j| middle[j] * MIDDLE[j]).sum::<f32>() + middle[3];
            let lowest = controls.iter().map(|x| x[2]).fold(pinned.min(middle), f32::min);
            prop_assert!(lowest > 0.1 - ALLOWED_M - 2e-6, "{}", lowest);
        }
    }
}

fn weight(i: usize) -> f32 {
    (1.7 * i as f32).sin()
}

fn weighted(points: &[Point]) -> f64 {
    let entries = points.as_flattened().iter().enumerate();
    entries.map(|(i, x)| f64::from(*x) * f64::from(weight(i))).sum()
}

fn weights(points: usize) -> Vec<Point> {
    (0..points).map(|i| std::array::from_fn(|c| weight(3 * i + c))).collect()
}

fn agrees(found: f32, expected: f64) -> bool {
    (f64::from(found) - expected).abs() < 5e-3 * (1.0 + expected.abs())
}

#[test]
fn gradients_through_a_stop_agree_with_differences() {
    let graph = graph();
    // The two control points of hand 0 would hold it back by the same depth; hand 1 begins deep.
    let mut begun = START;
    begun[2][2] -= 0.02;
    let start = start(&begun);
    let mut rows = lowered(0.02).controls(0, &START);
    rows.iter_mut().skip(1).step_by(3).for_each(|x| x[2] += 0.004);
    (rows[2][2], rows[5][2]) = (0.08, 0.085);
    let value = |rows: &[Point]| -> f64 {
        let actions = trajectories(rows);
        let mut controls = actions.controls(0, &begun);
        actions.stop(&mut controls, &mut [], &floor(&graph, &start));
        weighted(&controls)
    };
    let actions = trajectories(&rows);
    let mut controls = rows.clone();
    let stops = actions.stop(&mut controls, &mut [], &floor(&graph, &start));
    assert!(stops.most().shift_m > 0.02 && stops.shifts.iter().any(|shift| shift.follows));
    let mut by = Gradient { controls: weights(controls.len()), ..Gradient::default() };
    stops.back(&actions, &mut by);
    for (i, found) in by.controls.as_flattened().iter().enumerate().skip(9) {
        let moved = |by: f32| {
            let mut rows = rows.clone();
            rows[i / 3][i % 3] += by;
            value(&rows)
        };
        let expected = (moved(2e-3) - moved(-2e-3)) / 4e-3;
        assert!(agrees(*found, expected), "{i}: {found} {expected}");
    }
}

#[test]
fn gradients_by_poses_through_a_stop_agree_with_differences() {
    let (graph, start) = (graph(), start(&START));
    let pose = |f: usize| {
        let (t, z) = (0.1 * f as f32, 0.15 - 0.03 * f as f32);
        [[0.0, 0.0, z, 0.2 + t, 0.1, 0.0, 1.0], [0.28, 0.0, z, 0.0, -0.1, t, 1.0f32]]
    };
    let rows: Vec<[f32; 7]> = (0..=FRAMES).flat_map(pose).collect();
    let floor = || Floor { middles: vec![(1, [0.01, 0.0, -0.08])], ..floor(&graph, &start) };
    let flat = |bodies: &[Pose]| -> Vec<Point> {
        let rows = bodies.as_flattened().iter();
        rows.flat_map(|[a, b, c, d]| [[*a, *b, *c], [*d, 0.0, 0.0]]).collect()
    };
    let value = |rows: &[[f32; 7]]| -> f64 {
        let actions = poses(rows);
        let (mut controls, mut bodies) = (actions.controls(0, &START), actions.bodies(0));
        actions.stop(&mut controls, &mut bodies, &floor());
        weighted(&controls) + weighted(&flat(&bodies))
    };
    let actions = poses(&rows);
    let (mut controls, mut bodies) = (actions.controls(0, &START), actions.bodies(0));
    let stops = actions.stop(&mut controls, &mut bodies, &floor());
    let stopped_by = |hand: usize| {
        let row = &stops.shifts[2 * FRAMES..];
        stops.probes[row[hand].probe].place
    };
    assert!(matches!(stopped_by(0), Place::Control(..)));
    assert!(matches!(stopped_by(1), Place::Gripper(_)));
    let entries = weights(2 * 3 * bodies.len());
    let by_bodies = entries.as_chunks::<6>().0.iter();
    let by_bodies = by_bodies.map(|rows| {
        std::array::from_fn(|i| {
            let [[a, b, c], [d, ..]] = [rows[2 * i], rows[2 * i + 1]];
            [a, b, c, d]
        })
    });
    let mut by = Gradient {
        controls: weights(controls.len()),
        poses: by_bodies.collect(),
        ..Gradient::default()
    };
    stops.back(&actions, &mut by);
    let found = actions.gradient(0, &START, &by);
    for (i, found) in found.iter().enumerate() {
        let moved = |by: f32| {
            let mut rows = rows.clone();
            rows[i / 7][i % 7] += by;
            value(&rows)
        };
        let expected = (moved(1e-3) - moved(-1e-3)) / 2e-3;
        // Gradients by quaternions are those along the unit sphere, as is what differences find.
        assert!(agrees(*found, expected), "{i}: {found} {expected}");
    }
}
