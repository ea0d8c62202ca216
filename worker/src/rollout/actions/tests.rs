use bendtwin_core::Problem as _;
use bendtwin_proto::{
    rollout::{Limits, TwinShape, check_for},
    v1::{GripperPoses, Interpolation, RollOutRequest, Tensor},
};
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

/// The actions and the horizon of a request to a twin with so many control points, if it is sound.
fn read(wire: Option<Wire>, controls: usize, frames: u32) -> Result<(Actions, usize), Error> {
    let controls_only = TwinShape { controls: controls as u64, ..TwinShape::default() };
    let request = RollOutRequest { actions: wire, frames, ..RollOutRequest::default() };
    let limits = Limits { instances: 100, ..Limits::default() };
    let batch = check_for(&request, &controls_only, &limits, 0)?;
    Ok((Actions::read(request.actions, controls)?, batch.frames as usize))
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
    assert_eq!(actions.controls(1, 3, &[]), points[12..]);
}

#[test]
fn knots_are_spread_over_the_horizon() {
    let points = [[0.0; 3], [1.0, 2.0, 3.0]];
    let (actions, _) = read(trajectories([1, 2, 1], &points), 1, 4).unwrap();
    let controls = actions.controls(0, 4, &[]);
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
    let controls = actions.controls(0, 4, &[[0.1, 0.0, 0.0], [0.0, 0.1, 0.0]]);
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
    // A tensor with a zero in its shape has no bytes, whatever else it claims.
    let tensor = Tensor { dtype: 1, shape: vec![1 << 60, 2, 0, 3], ..Tensor::default() };
    let wire = ControlTrajectories { positions: Some(tensor), interpolation: 0 };
    let error = read(Some(Wire::Trajectories(wire)), 0, 0).err().unwrap();
    assert_eq!(error.reason(), "ROLLOUT_TOO_LARGE");
}

proptest! {
    /// Whatever bytes and shapes arrive: an answer or a refusal, never a panic.
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
            let rows = actions.controls(0, frames, &start);
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
        let controls = actions.controls(0, 10, &[point]);
        for axis in 0..3 {
            prop_assert!((controls[10][axis] - point[axis] - shift[axis]).abs() < 1e-5);
        }
    }
}
