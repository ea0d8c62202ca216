use bendtwin_core::{NodeKind, Pin};
use bendtwin_engine::backend::Gradient;
use bendtwin_proto::v1::{GripperPoses, Tensor, roll_out_request::Actions as Wire};

use super::*;
use crate::request::actions::{Actions, Horizon};

/// A bent cable of five nodes with a clamp at each end.
const NODES: [Point; 5] =
    [[0.0, 0.0, 0.5], [0.1, 0.0, 0.5], [0.2, 0.05, 0.5], [0.25, 0.12, 0.55], [0.25, 0.2, 0.6]];
/// Control points stand for nodes 0, 1, 3 and 4.
const HELD: [usize; 4] = [0, 1, 3, 4];

fn cable() -> Graph {
    let pins = HELD.iter().zip(0..);
    Graph {
        rest_positions: NODES.to_vec(),
        kinds: vec![NodeKind::Observed; 5],
        control_rest: HELD.map(|i| NODES[i]).to_vec(),
        pins: pins
            .map(|(node, control)| Pin { node: *node as u32, control, offset_m: [0.0; 3] })
            .collect(),
        rods: vec![(0..5).collect()],
        ..Graph::default()
    }
}

/// Two grippers, one at each end, with poses at every frame.
fn actions(poses: &[[f32; 7]]) -> Actions {
    let knots = poses.len() / 2;
    let wire = GripperPoses {
        poses: Some(Tensor::pack(&[1, knots, 2, 7], poses.as_flattened())),
        gripper_of_control: Some(Tensor::pack(&[4], &[0u32, 0, 1, 1])),
        interpolation: 0,
    };
    let horizon = Horizon { frames: knots - 1, fps: 30.0, times: None };
    Actions::read(Some(Wire::Poses(wire)), 4, horizon).unwrap().with_clamps(&cable())
}

fn turned(axis: [f32; 3], angle: f32, at: Point) -> [f32; 7] {
    let (sine, cosine) = (angle / 2.0).sin_cos();
    [at[0], at[1], at[2], axis[0] * sine, axis[1] * sine, axis[2] * sine, cosine]
}

/// Turn of the near end against the far one.
fn rolled(actions: &Actions) -> (Vec<Point>, Vec<f32>) {
    let controls = actions.controls(0, &cable().control_rest);
    let rolls = actions.rolls(0, &controls, 1, false);
    (controls, rolls.as_chunks::<2>().0.iter().map(|[near, far]| near - far).collect())
}

#[test]
fn a_gripper_that_turns_about_the_cable_rolls_its_end() {
    let still = turned([0.0, 0.0, 1.0], 0.0, NODES[4]);
    // Three turns about x, along which the near clamp lies: the far end stands still.
    let poses: Vec<_> = (0..=60)
        .flat_map(|f| {
            [turned([1.0, 0.0, 0.0], 0.1 * std::f32::consts::PI * f as f32, NODES[0]), still]
        })
        .collect();
    let (_, rolls) = rolled(&actions(&poses));
    for (frame, roll) in rolls.iter().enumerate() {
        let expected = 0.1 * std::f32::consts::PI * frame as f32;
        assert!((roll - expected).abs() < 1e-4, "{frame}: {roll}, not {expected}");
    }
    // Without turns there are no rolls.
    let (_, rolls) = rolled(&actions(&[still, still].repeat(5)));
    assert!(rolls.is_empty());
}

/// Change of the part of the twist that follows from nodes (docs/formats/twin.md), for nodes that move
/// from one place to another, half way between them.
fn geometric(from: &[Vector], to: &[Vector]) -> f64 {
    let sub = |a: Vector, b: Vector| -> Vector { std::array::from_fn(|i| a[i] - b[i]) };
    let middle: Vec<Vector> =
        from.iter().zip(to).map(|(a, b)| std::array::from_fn(|i| 0.5 * (a[i] + b[i]))).collect();
    let moved: Vec<Vector> = from.iter().zip(to).map(|(a, b)| sub(*b, *a)).collect();
    let inner = 1..from.len() - 1;
    inner
        .map(|j| {
            let (e, g) = (sub(middle[j], middle[j - 1]), sub(middle[j + 1], middle[j]));
            let (le, lg) = (dot(e, e).sqrt(), dot(g, g).sqrt());
            let scale = 2.0 / (le * lg + dot(e, g));
            let kb = cross(e, g).map(|x| scale * x);
            dot(kb, sub(moved[j - 1], moved[j])) / (2.0 * le)
                - dot(kb, sub(moved[j + 1], moved[j])) / (2.0 * lg)
        })
        .sum()
}

/// If grippers turn the whole cable as one body, it is not twisted: the rolls cancel the twist that
/// the nodes alone suggest.
#[test]
fn turning_all_of_a_bent_cable_does_not_twist_it() {
    let frames = 400;
    let axis = [0.48, 0.6, 0.64f32];
    let angle = |frame: usize| 2.0 * frame as f32 / frames as f32;
    let poses: Vec<_> = (0..=frames).flat_map(|f| [turned(axis, angle(f), [0.0; 3]); 2]).collect();
    let (_, rolls) = rolled(&actions(&poses));
    let at = |frame: usize| -> Vec<Vector> {
        let [_, _, _, x, y, z, w] = turned(axis, angle(frame), [0.0; 3]);
        let q = Quaternion::of([x, y, z, w]);
        NODES.iter().map(|p| q.rotate(p.map(f64::from))).collect()
    };
    let nodes: f64 = (0..frames).map(|f| geometric(&at(f), &at(f + 1))).sum();
    let roll = f64::from(rolls[frames]);
    assert!(roll.abs() > 0.1, "{roll}");
    assert!((roll + nodes).abs() < 2e-3, "{roll} by clamps, {nodes} by nodes");
}

#[test]
fn gradients_by_rolls_agree_with_differences() {
    let turn = |seed: f32| -> Vec<[f32; 7]> {
        let pose = |k: usize| {
            let s = |i: f32| (1.3 * k as f32 + seed * i).sin();
            [0.1 * s(1.0), 0.1 * s(2.0), 0.5, 0.5 * s(3.0), 0.4 * s(4.0), 0.5 * s(5.0), 1.1]
        };
        (0..8).map(pose).collect()
    };
    let poses = turn(0.9);
    let by =
        Gradient { rolls: vec![0.3, 0.1, -0.2, 0.4, 0.9, -0.6, 0.4, 0.2], ..Gradient::default() };
    let value = |poses: &[[f32; 7]]| -> f64 {
        let actions = actions(poses);
        let controls = actions.controls(0, &cable().control_rest);
        let rolls = actions.rolls(0, &controls, 1, true);
        rolls.iter().zip(&by.rolls).map(|(x, g)| f64::from(*x) * f64::from(*g)).sum()
    };
    let found = actions(&poses).gradient(0, &cable().control_rest, &by);
    assert!(found.iter().any(|g| g.abs() > 0.1), "{found:?}");
    for (i, found) in found.iter().enumerate() {
        let moved = |by: f32| {
            let mut poses = poses.clone();
            poses[i / 7][i % 7] += by;
            value(&poses)
        };
        let expected = (moved(5e-3) - moved(-5e-3)) / 1e-2;
        let error = (f64::from(*found) - expected).abs();
        assert!(error < 5e-3 * (1.0 + expected.abs()), "{i}: {found} {expected}");
    }
}
