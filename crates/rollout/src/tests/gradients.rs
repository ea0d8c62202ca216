//! Gradients by actions, in the shape of the request.

use bendtwin_proto::v1::GripperPoses;

use super::*;

/// A gripper that moves and turns with knots between the frames.
fn poses(values: &[f32]) -> RollOutRequest {
    let poses = Some(Tensor::pack(&[1, values.len() / 7, 1, 7], values));
    let returns = Returns { action_gradients: true, ..Returns::default() };
    RollOutRequest {
        actions: Some(Actions::Poses(GripperPoses { poses, ..GripperPoses::default() })),
        returns: Some(returns),
        ..request(1)
    }
}

const VALUES: [f32; 21] = [
    0.0, 0.1, 0.6, 0.1, 0.0, 0.0, 1.0, //
    0.02, 0.1, 0.61, 0.2, 0.1, 0.0, 1.0, //
    0.03, 0.12, 0.6, 0.2, 0.2, 0.1, 1.0,
];

#[test]
fn gradients_by_poses_agree_with_differences_of_costs() {
    let bench = Bench::new();
    let cost = |values: &[f32]| f64s(&bench.run(poses(values), 0).unwrap()[0].costs)[0];
    let part = bench.run(poses(&VALUES), 0).unwrap().remove(0);
    let (shape, gradient) = part.action_gradients.unwrap().unpack::<f32>("g").unwrap();
    assert_eq!(shape, [1, 3, 1, 7]);
    assert!(part.control_gradients.is_none());
    let scale = gradient.iter().fold(0.0f32, |m, g| m.max(g.abs()));
    for (i, found) in gradient.iter().enumerate() {
        let moved = |by: f32| {
            let mut values = VALUES;
            values[i] += by;
            cost(&values)
        };
        let expected = (moved(1e-3) - moved(-1e-3)) / 2e-3;
        let error = (f64::from(*found) - expected).abs();
        assert!(error < 0.01 * f64::from(scale), "{i}: {found} {expected}");
    }
}

#[test]
fn gradients_by_knots_are_those_by_controls_gathered() {
    let bench = Bench::new();
    let mut request = request(2);
    request.returns =
        Some(Returns { control_gradients: true, action_gradients: true, ..Returns::default() });
    let part = bench.run(request, 0).unwrap().remove(0);
    let (shape, knots) = part.action_gradients.unwrap().unpack_points("g").unwrap();
    assert_eq!(shape, [2, 2, 1]);
    let (_, dense) = part.control_gradients.unwrap().unpack_points("g").unwrap();
    for b in 0..2 {
        // Two knots at the ends of six frames.
        let last: f32 = (0..7).map(|f| dense[7 * b + f][0] * f as f32 / 6.0).sum();
        assert!((knots[2 * b + 1][0] - last).abs() < 1e-5, "{last}");
    }
}
