//! A convex solid: the distance of a point from its surface, the ways out of it, and whether a step
//! meets it. Distances are those of the engine: of a convex shape that of the face whose plane is
//! farthest.

use bendtwin_core::{
    Plane,
    geometry::{point, vector3},
};
use bendtwin_engine::world::Shape;
use nalgebra::Vector3;

use super::CLEARANCE_M;
use crate::Obstacle;

/// Distance from an axis below which there is no direction away from it [m].
const LEAST_RADIUS_M: f64 = 1e-9;

/// A solid.
#[derive(Debug)]
pub(super) struct Solid {
    form: Form,
    /// The obstacle that moves; `None` is the ground.
    obstacle: Option<Obstacle>,
}

#[derive(Debug)]
enum Form {
    Capsule {
        from: Vector3<f64>,
        axis: Vector3<f64>,
        radius: f64,
    },
    /// Normals and offsets of faces.
    Convex(Vec<(Vector3<f64>, f64)>),
}

impl Solid {
    /// The half-space below a plane.
    pub(super) fn ground(plane: Plane) -> Self {
        let form = Form::Convex(vec![(vector3(plane.normal), f64::from(plane.offset_m))]);
        Self { form, obstacle: None }
    }

    pub(super) fn new(obstacle: &Obstacle) -> Self {
        let form = match &obstacle.collider.shape {
            Shape::Capsule { from, to, radius_m } => {
                let from = vector3(*from);
                Form::Capsule { from, axis: vector3(*to) - from, radius: f64::from(*radius_m) }
            }
            Shape::Convex(faces) => {
                let faces = faces.iter().map(|f| (vector3(f.normal), f64::from(f.offset_m)));
                Form::Convex(faces.collect())
            }
        };
        Self { form, obstacle: Some(obstacle.clone()) }
    }

    /// Signed distance of a point and the outward normal there.
    pub(super) fn surface(&self, x: Vector3<f64>) -> (f64, Vector3<f64>) {
        match &self.form {
            Form::Capsule { from, axis, radius } => {
                let away = x - (from + axis * share(*from, *axis, x));
                let length = away.norm();
                let normal =
                    if length > LEAST_RADIUS_M { away / length } else { any_across(*axis) };
                (length - radius, normal)
            }
            Form::Convex(faces) => {
                let mut best = (f64::NEG_INFINITY, Vector3::z());
                for (normal, offset) in faces {
                    let distance = normal.dot(&x) - offset;
                    if distance > best.0 {
                        best = (distance, *normal);
                    }
                }
                best
            }
        }
    }

    /// The plane that a point outside is beyond and the solid below, with the distance that nodes keep.
    pub(super) fn plane(&self, x: Vector3<f64>) -> (Vector3<f64>, f64) {
        let (distance, normal) = self.surface(x);
        (normal, normal.dot(&x) - distance + CLEARANCE_M)
    }

    /// Places on the surface that lie along a normal from a point inside.
    pub(super) fn exits(&self, x: Vector3<f64>) -> Vec<Vector3<f64>> {
        match &self.form {
            Form::Capsule { .. } => {
                let (distance, normal) = self.surface(x);
                vec![x + normal * (CLEARANCE_M - distance)]
            }
            Form::Convex(faces) => {
                let exit =
                    |(n, offset): &(Vector3<f64>, f64)| x + n * (offset + CLEARANCE_M - n.dot(&x));
                faces.iter().map(exit).collect()
            }
        }
    }

    /// Distance by which a point inside has to rise to be outside, 0 for one that is [m].
    pub(super) fn rise(&self, x: Vector3<f64>, up: Vector3<f64>) -> f64 {
        if self.surface(x).0 >= CLEARANCE_M {
            return 0.0;
        }
        match &self.form {
            Form::Convex(faces) => {
                let rise = |(n, offset): &(Vector3<f64>, f64)| {
                    let along = n.dot(&up);
                    (along > 1e-6).then(|| (offset + CLEARANCE_M - n.dot(&x)) / along)
                };
                faces.iter().filter_map(rise).fold(f64::INFINITY, f64::min).max(0.0)
            }
            Form::Capsule { axis, radius, .. } => {
                let (mut low, mut high) = (0.0, axis.norm() + 2.0 * radius + CLEARANCE_M);
                for _ in 0..50 {
                    let middle = 0.5 * (low + high);
                    let is_out = self.surface(x + up * middle).0 >= CLEARANCE_M;
                    (low, high) = if is_out { (low, middle) } else { (middle, high) };
                }
                high
            }
        }
    }

    /// True if the way from one point to another comes nearer than half of what nodes keep.
    pub(super) fn is_hit(&self, a: Vector3<f64>, b: Vector3<f64>) -> bool {
        let slack = 0.5 * CLEARANCE_M;
        match &self.form {
            Form::Capsule { from, axis, radius } => {
                segments_apart(a, b - a, *from, *axis) < radius + slack
            }
            Form::Convex(faces) => {
                let (mut enters, mut leaves) = (0.0f64, 1.0f64);
                for (normal, offset) in faces {
                    let [at_a, at_b] = [a, b].map(|x| normal.dot(&x) - offset - slack);
                    if at_a >= 0.0 && at_b >= 0.0 {
                        return false;
                    }
                    if at_a < 0.0 && at_b < 0.0 {
                        continue;
                    }
                    let t = at_a / (at_a - at_b);
                    if at_a >= 0.0 { enters = enters.max(t) } else { leaves = leaves.min(t) }
                }
                enters < leaves
            }
        }
    }

    /// Velocity of its point at `x` [m/s].
    pub(super) fn velocity(&self, x: Vector3<f64>) -> Vector3<f64> {
        self.obstacle.as_ref().map_or(Vector3::zeros(), |o| vector3(o.velocity(point(x))))
    }
}

/// Fraction of a segment's length at which it is nearest to a point.
fn share(from: Vector3<f64>, axis: Vector3<f64>, x: Vector3<f64>) -> f64 {
    let square = axis.norm_squared();
    if square > 0.0 { ((x - from).dot(&axis) / square).clamp(0.0, 1.0) } else { 0.0 }
}

/// A direction away from an axis, upwards if that is one.
fn any_across(axis: Vector3<f64>) -> Vector3<f64> {
    let across = |d: Vector3<f64>| d - axis * (axis.dot(&d) / axis.norm_squared().max(1e-30));
    let up = across(Vector3::z());
    if up.norm() > 0.1 { up.normalize() } else { across(Vector3::x()).normalize() }
}

/// Least distance between the segments from `p` along `d` and from `q` along `e` (Ericson, "Real-Time
/// Collision Detection", 5.1.9).
fn segments_apart(p: Vector3<f64>, d: Vector3<f64>, q: Vector3<f64>, e: Vector3<f64>) -> f64 {
    let r = p - q;
    let (dd, de, ee) = (d.dot(&d), d.dot(&e), e.dot(&e));
    let (dr, er) = (d.dot(&r), e.dot(&r));
    let at = |s: f64| {
        let s = s.clamp(0.0, 1.0);
        // The place on the other that is nearest to this one, and then the other way round.
        let t = share(q, e, p + d * s);
        let s = share(p, d, q + e * t);
        (p + d * s - q - e * t).norm()
    };
    let determinant = dd * ee - de * de;
    let inner = if determinant > 1e-12 * dd * ee { (de * er - dr * ee) / determinant } else { 0.0 };
    [inner, 0.0, 1.0].into_iter().map(at).fold(f64::INFINITY, f64::min)
}
