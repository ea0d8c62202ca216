//! The velocity change of a frictional impact, and its adjoint. Ground contact
//! and contact between nodes are this one formula with different partners.
//!
//! For the velocity v of the second body relative to the first, unit normal n, v_n = v . n < 0, v_t
//! = v - v_n n: `change = -(1 + e) v_n n + (a - 1) v_t`,
//! `a = max(0, 1 - mu (1 + e) |v_n| / |v_t|)`.

use super::real::{Quad, Real, add_scaled, dot, scale, sub};

/// Restitution and Coulomb friction.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Law<T> {
    pub(crate) restitution: T,
    pub(crate) friction: T,
}

/// d loss / d (velocity, normal, restitution, friction).
pub(crate) struct ImpactAdjoint<T> {
    pub(crate) v: Quad<T>,
    pub(crate) normal: Quad<T>,
    pub(crate) restitution: T,
    pub(crate) friction: T,
}

/// Tangential speed and whether friction is too weak to stop it.
#[inline(always)]
fn slip<T: Real>(law: Law<T>, v_n: T, v_t: Quad<T>) -> (T, bool) {
    let speed = dot(v_t, v_t).sqrt();
    (speed, law.friction * (T::ONE + law.restitution) * v_n.abs() < speed)
}

/// Change of relative velocity by an impact.
#[inline(always)]
pub(crate) fn impact<T: Real>(law: Law<T>, v: Quad<T>, n: Quad<T>) -> Quad<T> {
    let v_n = dot(v, n);
    let v_t = add_scaled(v, -v_n, n);
    let (speed, slips) = slip(law, v_n, v_t);
    let bounce = -(T::ONE + law.restitution) * v_n;
    let brake = if slips { -(law.friction * bounce) / speed } else { -T::ONE };
    add_scaled(scale(n, bounce), brake, v_t)
}

/// Adjoint of [`impact`] for d loss / d change = `b`.
#[inline(always)]
pub(crate) fn impact_adjoint<T: Real>(
    law: Law<T>,
    v: Quad<T>,
    n: Quad<T>,
    b: Quad<T>,
) -> ImpactAdjoint<T> {
    let v_n = dot(v, n);
    let v_t = add_scaled(v, -v_n, n);
    let (speed, slips) = slip(law, v_n, v_t);
    let along = dot(n, b);
    let e1 = T::ONE + law.restitution;
    if !slips {
        // change = -(1 + e) v_n n - (v - v_n n) = -e v_n n - v.
        let e = law.restitution;
        return ImpactAdjoint {
            v: sub(scale(n, -(e * along)), b),
            normal: add_scaled(scale(v, -(e * along)), -(e * v_n), b),
            restitution: -(v_n * along),
            friction: T::ZERO,
        };
    }
    // change = (1 + e) v_n (mu t - n), t = v_t / |v_t|.
    let t = scale(v_t, T::ONE / speed);
    let work = law.friction * dot(t, b) - along;
    let t_bar = scale(b, law.friction * e1 * v_n);
    let v_t_bar = scale(add_scaled(t_bar, -dot(t, t_bar), t), T::ONE / speed);
    let v_n_bar = e1 * work - dot(n, v_t_bar);
    let normal = add_scaled(scale(b, -(e1 * v_n)), -v_n, v_t_bar);
    ImpactAdjoint {
        v: add_scaled(v_t_bar, v_n_bar, n),
        normal: add_scaled(normal, v_n_bar, v),
        restitution: v_n * work,
        friction: e1 * v_n * dot(t, b),
    }
}
