//! A small twin, and requests to it that are sound.

use bendtwin_core::{Graph, NodeKind, Params, Timing, Twin};
use bendtwin_proto::v1::{
    ControlTrajectories, Cost, RollOutRequest, Tensor,
    cost::{Keypoints, Kind},
    roll_out_request::Actions,
};

/// A chain of four nodes that hangs from one control point.
pub fn twin() -> Twin {
    let n = 4;
    let graph = Graph {
        rest_positions: (0..n).map(|i| [0.0, 0.0, 0.5 - 0.1 * i as f32]).collect(),
        kinds: vec![NodeKind::Observed; n],
        masses: vec![1.0; n],
        object_ids: vec![0; n],
        observed_points: (0..n as u32).collect(),
        control_rest: vec![[0.0, 0.0, 0.6]],
        springs: vec![[0, 4], [1, 0], [2, 1], [3, 2]],
        triplets: vec![[0, 1, 2], [1, 2, 3]],
        pins: Vec::new(),
        ..Graph::default()
    };
    let params = Params {
        spring_stiffness: vec![500.0; 4],
        spring_dashpot: vec![1.0; 4],
        rest_lengths_m: vec![0.1; 4],
        bend_stiffness: vec![0.01; 2],
        bend_damping: vec![0.0; 2],
        rest_angles_rad: vec![std::f32::consts::PI; 2],
        drag: 1.0,
        ..Params::default()
    };
    Twin::new(graph, params, Timing { fps: 30.0, substeps: 60 })
}

/// `b` instances whose control point moves to x = 0.02 i over 6 frames.
pub fn request(b: usize) -> RollOutRequest {
    let knots = (0..b).flat_map(|i| [[0.0, 0.0, 0.6], [0.02 * i as f32, 0.0, 0.6]]);
    let positions = Tensor::pack_points(&[b, 2, 1], &knots.collect::<Vec<_>>());
    RollOutRequest {
        actions: Some(Actions::Trajectories(ControlTrajectories {
            positions: Some(positions),
            interpolation: 0,
        })),
        frames: 6,
        costs: vec![keypoint_cost(0.06)],
        ..RollOutRequest::default()
    }
}

/// The distance of the uppermost node from a target at x [m].
pub fn keypoint_cost(x: f32) -> Cost {
    let keypoints = Keypoints {
        nodes: Some(Tensor::pack(&[1], &[0u32])),
        targets: Some(Tensor::pack_points(&[1], &[[x, 0.0, 0.5]])),
        squared: false,
        skin_points: None,
    };
    Cost { weight: Some(1.0), kind: Some(Kind::Keypoints(keypoints)), ..Cost::default() }
}
