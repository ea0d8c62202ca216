//! The hand: an ellipsoid around the grasp with a forearm behind it. Its surface
//! points are the capture's control points, and it hides what is behind it.

use bendtwin_core::Point;

use super::pose::{Pose, add, scale, segment_distance, unit};

/// A hand at rest, before it moves.
#[derive(Clone, Debug)]
pub(super) struct Hand {
    /// Centre of the grasp, the pivot of its rotations [m].
    pub(super) grasp: Point,
    /// Semi-axes [m].
    pub(super) size: Point,
    /// Direction of the forearm [unit vector].
    pub(super) forearm: Point,
}

/// Thickness of hand and forearm where they hide things [m].
pub(super) const THICKNESS_M: f32 = 0.026;
/// Length of the forearm in view [m].
pub(super) const FOREARM_M: f32 = 0.25;

impl Hand {
    /// `true` if a point of the body is held.
    pub(super) fn holds(&self, p: Point) -> bool {
        (0..3).map(|a| ((p[a] - self.grasp[a]) / self.size[a]).powi(2)).sum::<f32>() <= 1.0
    }

    /// Points spread over its surface, shape [count, 3].
    pub(super) fn points(&self, count: usize) -> Vec<Point> {
        let golden = std::f32::consts::PI * (3.0 - 5.0_f32.sqrt());
        (0..count)
            .map(|i| {
                let z = 1.0 - (2.0 * i as f32 + 1.0) / count as f32;
                let (s, c) = (golden * i as f32).sin_cos();
                let r = (1.0 - z * z).sqrt();
                let on_sphere = [r * c, r * s, z];
                std::array::from_fn(|a| self.grasp[a] + self.size[a] * on_sphere[a])
            })
            .collect()
    }

    /// `true` if the hand at `pose` is between a camera and a point.
    pub(super) fn hides(&self, pose: &Pose, camera: Point, p: Point) -> bool {
        let wrist = pose.carry(self.grasp, self.grasp);
        let end = add(self.grasp, scale(unit(self.forearm), FOREARM_M));
        let elbow = pose.carry(self.grasp, end);
        // Samples along the line of sight, denser than the hand is thick.
        let steps = 60;
        (0..steps).any(|s| {
            let t = s as f32 / steps as f32;
            let q = std::array::from_fn(|a| p[a] + t * (camera[a] - p[a]));
            segment_distance(q, wrist, elbow) < THICKNESS_M
        })
    }
}
