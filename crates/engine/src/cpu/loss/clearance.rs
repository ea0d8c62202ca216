//! Distances to a collider below a margin.

use super::{Moment, mean_over};
use crate::cpu::{
    arithmetic::{Node, Real, add, scale},
    collision::collider::Collider,
    surroundings::body::{BodyFrame, Pose, into_body, into_body_adjoint},
};

/// The collider and its pose at the frame's end.
fn placed<'a, T: Real>(at: &Moment<'a, T>, collider: usize) -> Option<(&'a Collider<T>, Pose<T>)> {
    let around = at.around?;
    let collider = around.colliders.get(collider)?;
    let pose = match collider.body {
        Some(body) => around.poses[at.frame * around.bodies + body],
        None => BodyFrame::world().from,
    };
    Some((collider, pose))
}

/// Mean over nodes of the squared lack of clearance.
pub(super) fn value<T: Real>(at: Moment<'_, T>, collider: usize, margin_m: f32) -> f64 {
    let Some((collider, pose)) = placed(&at, collider) else { return 0.0 };
    let lacks = at.now.iter().map(|n| {
        let distance = collider.distance(into_body(&pose, n.x)).0.to_f64();
        (f64::from(margin_m) - distance).max(0.0).powi(2)
    });
    lacks.sum::<f64>() * mean_over(at.now.len())
}

/// Adds the gradient of [`value`] by nodes and by the pose.
pub(super) fn add_gradient<T: Real>(
    at: Moment<'_, T>,
    collider: usize,
    margin_m: f32,
    weight: f64,
    bar: &mut [Node<T>],
    poses: &mut [Pose<T>],
) {
    let Some((collider, pose)) = placed(&at, collider) else { return };
    let weight = T::from_f64(-2.0 * weight * mean_over(at.now.len()));
    let margin = T::from_f32(margin_m);
    let mut fixed = Pose::default();
    let pose_bar = match collider.body {
        Some(body) => &mut poses[body],
        None => &mut fixed,
    };
    for (node, bar) in at.now.iter().zip(bar) {
        let (distance, normal) = collider.distance(into_body(&pose, node.x));
        if distance < margin {
            let q_bar = scale(normal, weight * (margin - distance));
            bar.x = add(bar.x, into_body_adjoint(&pose, node.x, q_bar, pose_bar));
        }
    }
}
