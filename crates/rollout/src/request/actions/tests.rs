use bendtwin_contract::rollout::{Limits, TwinShape, check_for};
use bendtwin_core::Problem as _;
use bendtwin_proto::v1::{GripperPoses, Interpolation, RollOutRequest, Tensor, knot_times::Times};
use proptest::prelude::*;

use super::*;

fn trajectories(shape: [usize; 3], points: &[Point]) -> Option<Wire> {
    Some(Wire::Trajectories(ControlTrajectories {
        positions: Some(Tensor::pack_points(&shape, points)),
        interpolation: Interpolation::Linear.into(),
    }))
}

fn poses(shape: [usize; 3], values: &[f32]) -> GripperPoses {
    let [b, k, g] = shape;
    GripperPoses {
        poses: Some(Tensor::pack(&[b, k, g, 7], values)),
        gripper_of_control: None,
        interpolation: Interpolation::Unspecified.into(),
    }
}

/// The actions and the horizon of a request to a twin with `controls` control points, if it is
/// valid.
fn read(wire: Option<Wire>, controls: usize, frames: u32) -> Result<(Actions, usize), Error> {
    let controls_only = TwinShape { controls: controls as u64, ..TwinShape::default() };
    let request = RollOutRequest { actions: wire, frames, ..RollOutRequest::default() };
    let limits = Limits { instances: 100, ..Limits::default() };
    let batch = check_for(&request, &controls_only, &limits, 0)?;
    let frames = batch.frames as usize;
    let horizon = Horizon { frames, fps: 30.0, times: None };
    Ok((Actions::read(request.actions, controls, horizon)?, frames))
}

fn message(actions: Result<(Actions, usize), Error>) -> String {
    let error = actions.err().expect("must be refused");
    assert_eq!(error.category(), bendtwin_core::Category::InvalidArgument);
    error.to_string()
}

#[test]
fn dense_trajectories_pass_through_unchanged() {
    let points: Vec<Point> = (0..2 * 4 * 3).map(|i| [i as f32, 0.5, -1.0]).collect();
    let (actions, frames) = read(trajectories([2, 4, 3], &points), 3, 0).unwrap();
    assert_eq!(frames, 3);
    assert_eq!(actions.controls(1, &[]), points[12..]);
}

#[test]
fn knots_are_spread_over_the_horizon() {
    let points = [[0.0; 3], [1.0, 2.0, 3.0]];
    let (actions, _) = read(trajectories([1, 2, 1], &points), 1, 4).unwrap();
    let controls = actions.controls(0, &[]);
    assert_eq!(controls.len(), 5);
    assert_eq!(controls[1], [0.25, 0.5, 0.75]);
    assert_eq!(controls[4], [1.0, 2.0, 3.0]);
}

#[test]
fn a_gripper_carries_its_points_rigidly() {
    // From the origin to (1, 0, 0) with a half turn about z on the way.
    let half = std::f32::consts::FRAC_1_SQRT_2;
    let values = [
        [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 2.0],
        [0.5, 0.0, 0.0, 0.0, 0.0, half, half],
        [1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0],
    ];
    let wire = Some(Wire::Poses(poses([1, 3, 1], values.as_flattened())));
    let (actions, _) = read(wire, 2, 4).unwrap();
    let controls = actions.controls(0, &[[0.1, 0.0, 0.0], [0.0, 0.1, 0.0]]);
    let close = |a: Point, b: Point| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-5);
    assert!(close(controls[0], [0.1, 0.0, 0.0]));
    assert!(close(controls[4], [0.5, 0.1, 0.0]), "{:?}", controls[4]);
    assert!(close(controls[8], [0.9, 0.0, 0.0]), "{:?}", controls[8]);
    assert!(close(controls[9], [1.0, -0.1, 0.0]), "{:?}", controls[9]);
    let eighth = 0.1 * half;
    assert!(close(controls[2], [0.25 + eighth, eighth, 0.0]), "{:?}", controls[2]);
}

#[test]
fn refusals_name_the_field_and_the_fix() {
    assert!(message(read(None, 1, 0)).contains("trajectories"));
    let wrong_controls = trajectories([1, 2, 2], &[[0.0; 3]; 4]);
    assert!(message(read(wrong_controls, 3, 0)).contains("the twin has 3"));
    let one_knot = trajectories([1, 1, 1], &[[0.0; 3]]);
    assert!(message(read(one_knot, 1, 0)).contains("2 knots"));
    let nan = trajectories([1, 2, 1], &[[0.0; 3], [0.0, f32::NAN, 0.0]]);
    assert!(message(read(nan, 1, 0)).contains("value 4"));
    let zero = Some(Wire::Poses(poses([1, 2, 1], &[0.0; 14])));
    assert!(message(read(zero, 1, 0)).contains("length zero"));
    let mut stranger = poses([1, 2, 1], &[0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0].repeat(2));
    stranger.gripper_of_control = Some(Tensor::pack(&[1], &[4u32]));
    assert!(message(read(Some(Wire::Poses(stranger)), 1, 0)).contains("gripper 4"));
}

#[test]
fn too_many_instances_are_refused_before_they_are_counted_out() {
    // A tensor with a zero in its shape has no bytes, with any other dimensions.
    let tensor = Tensor { dtype: 1, shape: vec![1 << 60, 2, 0, 3], ..Tensor::default() };
    let wire = ControlTrajectories { positions: Some(tensor), interpolation: 0 };
    let error = read(Some(Wire::Trajectories(wire)), 0, 0).err().unwrap();
    assert_eq!(error.reason(), "ROLLOUT_TOO_LARGE");
}

/// Poses of two grippers in `knots` knots, far from one another's rotation and not normalised.
fn wild(knots: usize, seed: u32) -> Vec<f32> {
    let mut state = seed.wrapping_mul(2_654_435_761).wrapping_add(1);
    let mut next = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 8) as f32 / 8_388_608.0 - 1.0
    };
    let pose = |_| {
        let position = [next(), next(), next()].map(|x| 0.3 * x);
        let turn = [next(), next(), next()].map(|x| 0.8 * x);
        [position[0], position[1], position[2], turn[0], turn[1], turn[2], 1.3]
    };
    (0..2 * knots).map(pose).collect::<Vec<_>>().concat()
}

fn of_poses(values: &[f32], interpolation: Interpolation, horizon: Horizon) -> Actions {
    let wire = GripperPoses {
        gripper_of_control: Some(Tensor::pack(&[3], &[1u32, 0, 1])),
        interpolation: interpolation.into(),
        ..poses([1, values.len() / 14, 2], values)
    };
    Actions::read(Some(Wire::Poses(wire)), 3, horizon).unwrap()
}

fn timed(frames: usize, at: &[f32]) -> Horizon {
    let times = Some(KnotTimes { times: Some(Times::AtS(Tensor::pack(&[at.len()], at))) });
    Horizon { frames, fps: 10.0, times }
}

const START: [Point; 3] = [[0.1, 0.2, 0.3], [-0.2, 0.1, 0.4], [0.3, -0.1, 0.2]];

#[test]
fn carrying_on_from_any_frame_gives_the_same_bits() {
    let values = wild(30, 7);
    let dense = |values: &[f32]| {
        let frames = values.len() / 14 - 1;
        of_poses(values, Interpolation::Linear, Horizon { frames, fps: 30.0, times: None })
    };
    let whole = dense(&values).controls(0, &START);
    for split in [1, 11, 28] {
        let rest = dense(&values[14 * split..]).controls(0, &whole[3 * split..3 * split + 3]);
        assert_eq!(rest, whole[3 * split..], "split at {split}");
    }
    // Nothing moves while the gripper rests, however often that is computed.
    let still = dense(&values[..14].repeat(50)).controls(0, &START);
    assert_eq!(still, START.repeat(50));
}

/// A made gradient by control points and by poses of both bodies.
fn gradient(rows: usize) -> Gradient {
    let wave = |i: usize| (0.7 * i as f32 + 0.3).sin();
    Gradient {
        controls: (0..3 * rows).map(|i| [wave(i), wave(i + 5), wave(i + 9)]).collect(),
        poses: (0..2 * rows)
            .map(|i| std::array::from_fn(|r| std::array::from_fn(|c| wave(i + 13 * r + 29 * c))))
            .collect(),
        ..Gradient::default()
    }
}

/// The function whose gradient it is: linear in control points and matrices.
fn measured(actions: &Actions, by: &Gradient) -> f64 {
    let (controls, bodies) = (actions.controls(0, &START), actions.bodies(0));
    let controls = controls.as_flattened().iter().zip(by.controls.as_flattened());
    let bodies = bodies.iter().zip(&by.poses).flat_map(|(pose, g)| {
        let pairs = pose.as_flattened().iter().zip(g.as_flattened());
        pairs.collect::<Vec<_>>()
    });
    controls.chain(bodies).map(|(x, g)| f64::from(*x) * f64::from(*g)).sum()
}

#[test]
fn gradients_by_poses_agree_with_differences() {
    for interpolation in [Interpolation::Linear, Interpolation::Cubic, Interpolation::Zero] {
        let at = [0.0, 0.35, 0.9, 1.4];
        let read = |values: &[f32]| of_poses(values, interpolation, timed(13, &at));
        let (values, by) = (wild(4, 3), gradient(14));
        let found = read(&values).gradient(0, &START, &by);
        assert_eq!(found.len(), values.len());
        for i in 0..values.len() {
            let moved = |by_how_much: f32| {
                let mut values = values.clone();
                values[i] += by_how_much;
                (f64::from(values[i]), measured(&read(&values), &by))
            };
            let ((high, above), (low, below)) = (moved(2e-3), moved(-2e-3));
            let expected = (above - below) / (high - low);
            let error = (f64::from(found[i]) - expected).abs();
            assert!(error < 3e-3 * (1.0 + expected.abs()), "{i}: {} {expected}", found[i]);
        }
        // Along the sphere of quaternions: lengths do not count.
        for (pose, g) in values.as_chunks::<7>().0.iter().zip(found.as_chunks::<7>().0) {
            let along: f32 = (3..7).map(|i| pose[i] * g[i]).sum();
            assert!(along.abs() < 1e-4, "{along}");
        }
    }
}

#[test]
fn gradients_by_knots_agree_with_differences() {
    for interpolation in [Interpolation::Linear, Interpolation::Cubic, Interpolation::Zero] {
        let points: Vec<Point> = (0..4 * 3).map(|i| [i as f32, 0.5, -0.1 * i as f32]).collect();
        let read = |points: &[Point]| {
            let wire = Wire::Trajectories(ControlTrajectories {
                positions: Some(Tensor::pack_points(&[1, 4, 3], points)),
                interpolation: interpolation.into(),
            });
            Actions::read(Some(wire), 3, timed(13, &[0.0, 0.35, 0.9, 1.2])).unwrap()
        };
        let by = Gradient { poses: Vec::new(), ..gradient(14) };
        let found = read(&points).gradient(0, &START, &by);
        for i in 0..points.len() {
            for axis in 0..3 {
                let mut moved = points.clone();
                moved[i][axis] += 0.5;
                let change = measured(&read(&moved), &by) - measured(&read(&points), &by);
                let found = f64::from(found[3 * i + axis]);
                assert!((found - 2.0 * change).abs() < 1e-4, "{i}: {found} {}", 2.0 * change);
            }
        }
    }
}

#[test]
fn a_body_is_where_its_gripper_is() {
    let actions =
        of_poses(&wild(6, 5), Interpolation::Linear, timed(4, &[0.0, 0.1, 0.2, 0.3, 0.4, 0.5]));
    let (controls, bodies) = (actions.controls(0, &START), actions.bodies(0));
    assert_eq!(bodies.len(), 5 * 2);
    // The control points keep their places on it.
    for (c, gripper) in [1, 0, 1].into_iter().enumerate() {
        let local = |frame: usize| -> Point {
            let (pose, x) = (bodies[2 * frame + gripper], controls[3 * frame + c]);
            std::array::from_fn(|i| (0..3).map(|j| pose[j][i] * (x[j] - pose[j][3])).sum())
        };
        for frame in 1..5 {
            let (a, b) = (local(0), local(frame));
            assert!(a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-6), "{a:?} {b:?}");
        }
    }
}

proptest! {
    /// Any bytes and shapes: an answer or a refusal, never a panic.
    #[test]
    fn no_tensor_panics(
        dtype in -1i32..8,
        shape in prop::collection::vec(prop_oneof![0u64..4, Just(u64::MAX), Just(1 << 40)], 0..6),
        data in prop::collection::vec(any::<u8>(), 0..200),
        interpolation in -1i32..5,
        controls in 0usize..3,
        frames in 0u32..20,
        as_poses in any::<bool>(),
    ) {
        let tensor = Tensor { dtype, shape, data: data.into(), ..Tensor::default() };
        let wire = if as_poses {
            Wire::Poses(GripperPoses {
                poses: Some(tensor.clone()), gripper_of_control: Some(tensor), interpolation,
            })
        } else {
            Wire::Trajectories(ControlTrajectories { positions: Some(tensor), interpolation })
        };
        if let Ok((actions, frames)) = read(Some(wire), controls, frames) {
            let start = vec![[0.0; 3]; controls];
            let rows = actions.controls(0, &start);
            prop_assert_eq!(rows.len(), (frames + 1) * controls);
            prop_assert!(rows.as_flattened().iter().all(|x| !x.is_nan()));
        }
    }

    /// Poses that do not rotate move every point by the gripper's own displacement.
    #[test]
    fn translation_is_exact(shift in prop::array::uniform3(-1.0f32..1.0), point in prop::array::uniform3(-1.0f32..1.0)) {
        let row = |p: Point| [p[0], p[1], p[2], 0.0, 0.0, 0.0, 1.0];
        let values = [row([0.0; 3]), row(shift)];
        let wire = Some(Wire::Poses(poses([1, 2, 1], values.as_flattened())));
        let (actions, _) = read(wire, 1, 10).unwrap();
        let controls = actions.controls(0, &[point]);
        for axis in 0..3 {
            prop_assert!((controls[10][axis] - point[axis] - shift[axis]).abs() < 1e-5);
        }
    }
}
