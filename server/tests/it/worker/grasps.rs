//! Grasps of the fake device, which are spheres around the gripper.

use bendtwin_proto::v1::{Plausibility, roll_out_response::Implausible};

/// Farthest place along x at which a gripper holds something [m].
const REACH_M: f64 = 0.5;

/// Force of a grasp that begins at x, least at 0.3 m [N]; none where it holds nothing.
pub(crate) fn force_n(x: f64) -> Option<f64> {
    (x <= REACH_M).then_some(0.1 + 10.0 * (x - 0.3).abs())
}

/// Grasp 0 of each instance beyond the limit, by the poses of the first gripper; instances have `width`
/// numbers.
pub(super) fn beyond(
    limits: Option<Plausibility>,
    poses: &[f32],
    width: usize,
) -> Vec<Implausible> {
    let Some(limit) = limits.and_then(|limits| limits.grasp_force_n) else { return Vec::new() };
    let found = (0..).zip(poses.chunks(width)).map(|(i, row)| (i, force_n(f64::from(row[0]))));
    let beyond = |(instance, found): (u32, Option<f64>)| {
        let found = found.filter(|found| *found > limit)?;
        let (reason, frame, grasp) = ("GRASP_FORCE".to_owned(), 1, Some(0));
        Some(Implausible { instance, reason, found, limit, frame, grasp })
    };
    found.filter_map(beyond).collect()
}
