//! Rigid poses and the few vector operations that scenes need.

use bendtwin_core::Point;
pub(super) use bendtwin_core::geometry::{add, dot, length as norm, scaled as scale, sub};

/// A rotation about the origin, then a shift.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pose {
    rotation: [[f32; 3]; 3],
    shift: Point,
}

impl Pose {
    /// Turned by yaw about z after pitch about y (positive lifts +x) [rad], then shifted [m].
    pub(super) fn new(yaw: f32, pitch: f32, shift: Point) -> Self {
        let ((sy, cy), (sp, cp)) = (yaw.sin_cos(), pitch.sin_cos());
        let rotation = [[cy * cp, -sy, -cy * sp], [sy * cp, cy, -sy * sp], [sp, 0.0, cp]];
        Self { rotation, shift }
    }

    /// Moves a point that was recorded relative to `pivot`; the pivot itself is only shifted.
    pub(super) fn carry(&self, pivot: Point, p: Point) -> Point {
        let local = sub(p, pivot);
        let turned = self.rotation.map(|row| dot(row, local));
        add(add(turned, pivot), self.shift)
    }
}

/// The unit vector; zero stays zero.
pub(super) fn unit(a: Point) -> Point {
    let n = norm(a);
    if n > 0.0 { scale(a, 1.0 / n) } else { a }
}

/// Distance from `p` to the segment from `a` to `b`.
pub(super) fn segment_distance(p: Point, a: Point, b: Point) -> f32 {
    let (ab, ap) = (sub(b, a), sub(p, a));
    let t = (dot(ap, ab) / dot(ab, ab).max(f32::MIN_POSITIVE)).clamp(0.0, 1.0);
    norm(sub(ap, scale(ab, t)))
}

/// 0 before 0, 1 after 1, smooth between.
pub(super) fn smoothstep(x: f32) -> f32 {
    let x = x.clamp(0.0, 1.0);
    x * x * (3.0 - 2.0 * x)
}
