//! Moving a node for one substep, with the ground in the way, and the adjoint of it.
//!
//! With height h = n . x - offset: if x + v dt would lie below the ground and v . n < -1e-4 m/s,
//! the node moves with the old velocity until the time of impact tau = h / |v_n| and with the
//! reflected one after it. tau is differentiated like everything else; whether an impact happens is
//! not (its derivative is zero almost everywhere). A node below the ground already has tau = 0.

use super::{
    impulse::{ImpactAdjoint, Law, impact, impact_adjoint},
    lanes::{FIRST, LANES, Node},
    machine::{Machine, Pack, Pack3, v3},
    real::{Quad, Real, add, add_scaled, dot, scale, sub},
    system::Ground,
};
use crate::constants::MIN_APPROACH_M_S;

#[inline(always)]
fn height<T: Real>(ground: &Ground<T>, x: Quad<T>) -> T {
    dot(ground.normal, x) - ground.offset
}

/// True if a node hits the ground in a substep that would end at `next`.
#[inline(always)]
fn hits<T: Real>(ground: &Ground<T>, v: Quad<T>, next: Quad<T>) -> bool {
    (height(ground, next) < T::ZERO) & (dot(ground.normal, v) < -T::from_f64(MIN_APPROACH_M_S))
}

/// True if any of [`LANES`] nodes can hit the ground, so that only few are checked one by one:
/// [`hits`] with the same roundings; `true` for fewer nodes.
#[inline(always)]
pub(crate) fn may_hit<T: Real, M: Machine<T>>(
    m: M,
    ground: &Ground<T>,
    dt: T,
    nodes: &[Node<T>],
    velocities: &[Quad<T>],
) -> bool {
    if nodes.len().min(velocities.len()) < LANES {
        return true;
    }
    let (x, _) = m.gather(nodes, &FIRST);
    let v = m.gather_quads(velocities, &FIRST);
    let next = v3::add(x, v3::scale(v, m.splat(dt)));
    let below = m.splat(T::ZERO).above(along(m, ground, next) - m.splat(ground.offset));
    m.any(below & m.splat(-T::from_f64(MIN_APPROACH_M_S)).above(along(m, ground, v)))
}

/// Component along the normal, rounded as [`dot`] does.
#[inline(always)]
fn along<T: Real, M: Machine<T>>(m: M, ground: &Ground<T>, a: Pack3<M::Pack>) -> M::Pack {
    let n = ground.normal;
    m.splat(n[0]) * a[0] + m.splat(n[1]) * a[1] + m.splat(n[2]) * a[2]
}

/// The node after a substep that it starts at `x` with velocity `v`.
#[inline(always)]
pub(crate) fn advance<T: Real>(
    ground: &Ground<T>,
    law: Law<T>,
    dt: T,
    x: Quad<T>,
    v: Quad<T>,
) -> Node<T> {
    let next = add_scaled(x, dt, v);
    if !hits(ground, v, next) {
        return Node { x: next, v };
    }
    let after = add(v, impact(law, v, ground.normal));
    let tau = impact_time(ground, dt, x, v);
    Node { x: add_scaled(add_scaled(x, tau, v), dt - tau, after), v: after }
}

#[inline(always)]
fn impact_time<T: Real>(ground: &Ground<T>, dt: T, x: Quad<T>, v: Quad<T>) -> T {
    (height(ground, x) / -dot(ground.normal, v)).at_least(T::ZERO).at_most(dt)
}

/// Adjoint of [`advance`]: d loss / d (x, v) from that of the result; adds to `law_bar`.
#[inline(always)]
pub(crate) fn advance_adjoint<T: Real>(
    ground: &Ground<T>,
    law: Law<T>,
    dt: T,
    (x, v): (Quad<T>, Quad<T>),
    bar: Node<T>,
    law_bar: &mut Law<T>,
) -> Node<T> {
    if !hits(ground, v, add_scaled(x, dt, v)) {
        return Node { x: bar.x, v: add_scaled(bar.v, dt, bar.x) };
    }
    let n = ground.normal;
    let change = impact(law, v, n);
    let tau = impact_time(ground, dt, x, v);
    let after_bar = add_scaled(bar.v, dt - tau, bar.x);
    let ImpactAdjoint { v: v_bar, restitution, friction, .. } =
        impact_adjoint(law, v, n, after_bar);
    law_bar.restitution += restitution;
    law_bar.friction += friction;
    let mut out = Node { x: bar.x, v: add(add(v_bar, after_bar), scale(bar.x, tau)) };
    if height(ground, x) > T::ZERO {
        // x' = x + tau v + (dt - tau) v', so d x'/d tau = v - v' = -change; tau = -h / v_n.
        let tau_bar = -dot(bar.x, change);
        let inverse = T::ONE / dot(n, v);
        out.x = sub(out.x, scale(n, tau_bar * inverse));
        out.v = add_scaled(out.v, -(tau_bar * tau * inverse), n);
    }
    out
}
