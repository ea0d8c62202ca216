//! Shapes of colliders: signed distance and outward normal of a point in the coordinates of the body,
//! and how the normal turns with the point.

use super::impulse::Law;
use crate::{
    cpu::arithmetic::{Quad, Real, add_scaled, dot, quad, scale, sub},
    world::{self, Shape},
};

/// Distance from a capsule's axis [m] below which there is no direction away from it.
const MIN_RADIUS_M: f64 = 1e-9;

/// A shape in the simulation's scalar.
#[derive(Clone, Debug)]
enum Form<T> {
    Capsule {
        from: Quad<T>,
        axis: Quad<T>,
        radius: T,
    },
    /// Normals and offsets of faces.
    Convex(Vec<(Quad<T>, T)>),
}

/// A collider in the simulation's scalar.
#[derive(Clone, Debug)]
pub(crate) struct Collider<T> {
    pub(crate) body: Option<usize>,
    form: Form<T>,
    pub(crate) law: Law<T>,
}

impl<T: Real> Collider<T> {
    pub(crate) fn new(collider: &world::Collider) -> Self {
        let form = match &collider.shape {
            Shape::Capsule { from, to, radius_m } => {
                let from = quad(*from);
                let (axis, radius) = (sub(quad(*to), from), T::from_f32(*radius_m));
                Form::Capsule { from, axis, radius }
            }
            Shape::Convex(faces) => {
                let face = |f: &world::Face| (quad(f.normal), T::from_f32(f.offset_m));
                Form::Convex(faces.iter().map(face).collect())
            }
        };
        let law = Law {
            restitution: T::from_f32(collider.restitution),
            friction: T::from_f32(collider.friction),
        };
        Self { body: collider.body.map(|b| b as usize), form, law }
    }

    /// Signed distance and outward unit normal. Capsule: distance to the segment minus the radius
    /// (on the axis the normal is z); convex: that of the face whose plane is farthest, the first
    /// of several.
    #[inline(always)]
    pub(crate) fn distance(&self, q: Quad<T>) -> (T, Quad<T>) {
        match &self.form {
            Form::Capsule { from, axis, radius } => {
                let r = sub(sub(q, *from), scale(*axis, share(*from, *axis, q)));
                let length = dot(r, r).sqrt();
                if length > T::from_f64(MIN_RADIUS_M) {
                    (length - *radius, scale(r, T::ONE / length))
                } else {
                    (length - *radius, [T::ZERO, T::ZERO, T::ONE, T::ZERO])
                }
            }
            Form::Convex(faces) => {
                let mut best = (T::from_f64(-f64::MAX), [T::ZERO; 4]);
                for &(normal, offset) in faces {
                    let d = dot(normal, q) - offset;
                    if d > best.0 {
                        best = (d, normal);
                    }
                }
                best
            }
        }
    }

    /// The derivative of the normal by the point, a symmetric matrix, times a vector: a capsule's is
    /// that across normal and axis by the distance from the axis, across the normal at its ends.
    #[inline(always)]
    pub(crate) fn curvature(&self, q: Quad<T>, by: Quad<T>) -> Quad<T> {
        let Form::Capsule { from, axis, .. } = &self.form else { return [T::ZERO; 4] };
        let s = share(*from, *axis, q);
        let r = sub(sub(q, *from), scale(*axis, s));
        let square = dot(r, r);
        let length = square.sqrt();
        // Also where it is no number.
        let is_outside = length > T::from_f64(MIN_RADIUS_M);
        if !is_outside {
            return [T::ZERO; 4];
        }
        let mut across = add_scaled(by, -(dot(r, by) / square), r);
        if s > T::ZERO && s < T::ONE {
            across = add_scaled(across, -(dot(*axis, by) / dot(*axis, *axis)), *axis);
        }
        scale(across, T::ONE / length)
    }
}

/// Fraction of a segment's length at which it is nearest to a point.
#[inline(always)]
fn share<T: Real>(from: Quad<T>, axis: Quad<T>, q: Quad<T>) -> T {
    let square = dot(axis, axis);
    if square > T::ZERO {
        (dot(sub(q, from), axis) / square).at_least(T::ZERO).at_most(T::ONE)
    } else {
        T::ZERO
    }
}
