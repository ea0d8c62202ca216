//! The way of a gripper or collider to its target, within a speed that springs can follow.

use crate::rows::Pose;

/// Fastest motion of grippers and colliders [m/s].
pub(crate) const SPEED_LIMIT_M_S: f64 = 3.0;
/// Fastest rotation [rad/s].
const TURN_LIMIT_RAD_S: f64 = 12.0;

/// A pose moved to a place.
pub(super) fn at(pose: Pose, [x, y, z]: [f32; 3]) -> Pose {
    let [_, _, _, a, b, c, d] = pose;
    [x, y, z, a, b, c, d]
}

/// Pose of a body after a frame on its way from a pose to a target.
pub(super) fn toward(now: Pose, target: Pose, frame_s: f64) -> Pose {
    let way: [f64; 3] = std::array::from_fn(|i| f64::from(target[i]) - f64::from(now[i]));
    let length = way.iter().map(|x| x * x).sum::<f64>().sqrt();
    let most = SPEED_LIMIT_M_S * frame_s;
    let position: [f32; 3] = if length <= most {
        [target[0], target[1], target[2]]
    } else {
        std::array::from_fn(|i| (f64::from(now[i]) + way[i] * most / length) as f32)
    };
    let rotation = turned(quaternion(now), quaternion(target), TURN_LIMIT_RAD_S * frame_s);
    let [x, y, z] = position;
    let [a, b, c, d] = rotation;
    [x, y, z, a, b, c, d]
}

fn quaternion([_, _, _, a, b, c, d]: Pose) -> [f32; 4] {
    [a, b, c, d]
}

/// A rotation on the arc to another, by at most `most` [rad].
fn turned(from: [f32; 4], to: [f32; 4], most: f64) -> [f32; 4] {
    if from == to {
        return to;
    }
    let unit = |q: [f32; 4]| {
        let q = q.map(f64::from);
        let length = q.iter().map(|x| x * x).sum::<f64>().sqrt();
        q.map(|x| x / length)
    };
    let (a, mut b) = (unit(from), unit(to));
    let mut cosine: f64 = a.iter().zip(b).map(|(x, y)| x * y).sum();
    if cosine < 0.0 {
        (b, cosine) = (b.map(|x| -x), -cosine);
    }
    let half = cosine.min(1.0).acos();
    if 2.0 * half <= most {
        return b.map(|x| x as f32);
    }
    let share = most / (2.0 * half);
    let weights = [((1.0 - share) * half).sin(), (share * half).sin()].map(|w| w / half.sin());
    std::array::from_fn(|i| (weights[0] * a[i] + weights[1] * b[i]) as f32)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bodies_go_to_their_targets_within_the_limits() {
        let start = [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0];
        let target = [1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0];
        let (mut pose, frame_s) = (start, 1.0 / 30.0);
        let mut frames = 0;
        while pose != target && frames < 100 {
            let next = toward(pose, target, frame_s);
            let way = (next[0] - pose[0]).abs();
            assert!(f64::from(way) <= SPEED_LIMIT_M_S * frame_s + 1e-6, "{way}");
            let length: f32 = next[3..].iter().map(|x| x * x).sum();
            assert!((length - 1.0).abs() < 1e-5, "{next:?}");
            (pose, frames) = (next, frames + 1);
        }
        // 1 m at 3 m/s takes longer than half a turn at 12 rad/s.
        assert_eq!((pose, frames), (target, 10));
        assert_eq!(toward(target, target, frame_s), target, "bits stay where nothing moves");
    }
}
