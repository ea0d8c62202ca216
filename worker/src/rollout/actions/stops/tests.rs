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

fn floor(graph: &Graph) -> Floor<'_> {
    Floor { plane: TABLE, allowed_m: ALLOWED_M, graph, start: &START }
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
    let stops = actions.stop(&mut controls, &floor(&graph));
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
    let stops = actions.stop(&mut gently, &floor(&graph));
    assert_eq!((stops.most(), gently), (Stopped::default(), lowered(0.001).controls(0, &START)));
}

#[test]
fn grippers_do_not_stop() {
    let graph = graph();
    let down = |f: usize| [0.0, 0.0, 0.2 - 0.06 * f as f32, 0.0, 0.0, 0.0, 1.0f32];
    let rows: Vec<[f32; 7]> = (0..=FRAMES).map(down).collect();
    let poses = Some(Tensor::pack(&[1, FRAMES + 1, 1, 7], rows.as_flattened()));
    let wire = GripperPoses { poses, gripper_of_control: None, interpolation: 0 };
    let actions = Actions::read(Some(Wire::Poses(wire)), 3, horizon()).unwrap();
    let mut controls = actions.controls(0, &START);
    assert_eq!(actions.stop(&mut controls, &floor(&graph)).most(), Stopped::default());
    assert_eq!(controls, actions.controls(0, &START));
}

/// Frames that are executed one after the other stop where those of one rollout do.
#[test]
fn a_stop_is_the_same_frame_by_frame() {
    let graph = graph();
    let actions = lowered(0.02);
    let asked = actions.controls(0, &START);
    let mut whole = asked.clone();
    actions.stop(&mut whole, &floor(&graph));
    for frame in 1..FRAMES {
        let here = &whole[3 * frame..3 * frame + 3];
        let start = Floor { start: here, ..floor(&graph) };
        let mut rest = asked.clone();
        actions.stop(&mut rest, &start);
        assert_eq!(rest[3 * frame + 3..3 * frame + 6], whole[3 * frame + 3..3 * frame + 6]);
    }
}

#[test]
fn gradients_through_a_stop_agree_with_differences() {
    let graph = graph();
    let weight = |i: usize| (1.7 * i as f32).sin();
    // The two control points of hand 0 would hold it back by the same depth.
    let mut rows = lowered(0.02).controls(0, &START);
    rows.iter_mut().skip(1).step_by(3).for_each(|x| x[2] += 0.004);
    let positions = Some(Tensor::pack_points(&[1, FRAMES + 1, 3], &rows));
    let wire = Wire::Trajectories(ControlTrajectories { positions, interpolation: 0 });
    let actions = Actions::read(Some(wire), 3, horizon()).unwrap().with_hands(&HANDS);
    let value = |rows: &[Point]| -> f64 {
        let positions = Some(Tensor::pack_points(&[1, FRAMES + 1, 3], rows));
        let wire = Wire::Trajectories(ControlTrajectories { positions, interpolation: 0 });
        let actions = Actions::read(Some(wire), 3, horizon()).unwrap().with_hands(&HANDS);
        let mut controls = actions.controls(0, &START);
        actions.stop(&mut controls, &floor(&graph));
        let entries = controls.as_flattened().iter().enumerate();
        entries.map(|(i, x)| f64::from(*x) * f64::from(weight(i))).sum()
    };
    let mut controls = rows.clone();
    let stops = actions.stop(&mut controls, &floor(&graph));
    assert!(stops.most().shift_m > 0.02);
    let point = |i: usize| -> Point { std::array::from_fn(|c| weight(3 * i + c)) };
    let mut by =
        Gradient { controls: (0..controls.len()).map(point).collect(), ..Gradient::default() };
    stops.back(&actions, &mut by);
    for (i, found) in by.controls.as_flattened().iter().enumerate().skip(9) {
        let moved = |by: f32| {
            let mut rows = rows.clone();
            rows[i / 3][i % 3] += by;
            value(&rows)
        };
        let expected = (moved(2e-3) - moved(-2e-3)) / 4e-3;
        let error = (f64::from(*found) - expected).abs();
        assert!(error < 5e-3 * (1.0 + expected.abs()), "{i}: {found} {expected}");
    }
}
