//! Moving a node for one substep, with the ground in the way, and the adjoint of it.
//!
//! With height h = n . x - offset: if x + v dt would lie less than 1 µm above the ground and
//! v . n < 0, the node moves with the old velocity until the time of impact tau = h / |v_n| and with
//! the new one after it. tau is differentiated like everything else; whether an impact happens is
//! not (its derivative is zero almost everywhere). A node that is less than 1 µm above the ground
//! already has tau = 0: without this margin the rounding of a position would lift a resting node off
//! the ground in every second substep, and friction would let it creep.

use super::impulse::{Approach, Law, impact, impact_adjoint};
use crate::{
    constants::CONTACT_MARGIN_M,
    cpu::{
        arithmetic::{
            FIRST, LANES, Machine, Node, Pack, Pack3, Quad, Real, add, add_scaled, dot, scale, sub,
            v3,
        },
        system::Ground,
    },
};

#[inline(always)]
fn height<T: Real>(ground: &Ground<T>, x: Quad<T>) -> T {
    dot(ground.normal, x) - ground.offset
}

/// True if a node hits the ground in a substep that would end at `next`.
#[inline(always)]
pub(crate) fn hits<T: Real>(ground: &Ground<T>, v: Quad<T>, next: Quad<T>) -> bool {
    (height(ground, next) < T::from_f64(CONTACT_MARGIN_M)) & (dot(ground.normal, v) < T::ZERO)
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
    let margin = m.splat(T::from_f64(CONTACT_MARGIN_M));
    let below = margin.above(along(m, ground, next) - m.splat(ground.offset));
    m.any(below & m.splat(T::ZERO).above(along(m, ground, v)))
}

/// Component along the normal, rounded as [`dot`] does.
#[inline(always)]
fn along<T: Real, M: Machine<T>>(m: M, ground: &Ground<T>, a: Pack3<M::Pack>) -> M::Pack {
    let n = ground.normal;
    m.splat(n[0]) * a[0] + m.splat(n[1]) * a[1] + m.splat(n[2]) * a[2]
}

/// The node after a substep that it starts as `start`, with velocity `v` after forces acted.
#[inline(always)]
pub(crate) fn advance<T: Real>(
    ground: &Ground<T>,
    law: Law<T>,
    dt: T,
    start: Node<T>,
    v: Quad<T>,
) -> Node<T> {
    let next = add_scaled(start.x, dt, v);
    if !hits(ground, v, next) {
        return Node { x: next, v };
    }
    let after = add(v, impact(law, Approach { start: start.v, now: v }, ground.normal));
    let tau = impact_time(height(ground, start.x), dot(ground.normal, v), dt).0;
    Node { x: add_scaled(add_scaled(start.x, tau, v), dt - tau, after), v: after }
}

/// Time at which a node meets a surface at this distance that it approaches with `along` < 0, within
/// the substep, and whether it depends on both: `clamp(d / -along, 0, dt)`, zero within the margin.
#[inline(always)]
pub(crate) fn impact_time<T: Real>(distance: T, along: T, dt: T) -> (T, bool) {
    let tau = distance / -along;
    if distance <= T::from_f64(CONTACT_MARGIN_M) {
        (T::ZERO, false)
    } else if tau < dt {
        (tau, true)
    } else {
        (dt, false)
    }
}

/// Adjoint of [`advance`]: d loss / d (x, v) from that of the result, d loss / d the velocity at the
/// start, and d loss / d height; adds to `law_bar`.
#[inline(always)]
pub(crate) fn advance_adjoint<T: Real>(
    ground: &Ground<T>,
    law: Law<T>,
    dt: T,
    (start, v): (Node<T>, Quad<T>),
    bar: Node<T>,
    law_bar: &mut Law<T>,
) -> (Node<T>, Quad<T>, T) {
    if !hits(ground, v, add_scaled(start.x, dt, v)) {
        return (Node { x: bar.x, v: add_scaled(bar.v, dt, bar.x) }, [T::ZERO; 4], T::ZERO);
    }
    let n = ground.normal;
    let approach = Approach { start: start.v, now: v };
    let change = impact(law, approach, n);
    let (tau, varies) = impact_time(height(ground, start.x), dot(n, v), dt);
    let after_bar = add_scaled(bar.v, dt - tau, bar.x);
    let by = impact_adjoint(law, approach, n, after_bar);
    law_bar.add(&by);
    let mut out = Node { x: bar.x, v: add(add(by.v, after_bar), scale(bar.x, tau)) };
    let mut height_bar = T::ZERO;
    if varies {
        // x' = x + tau v + (dt - tau) v', so d x'/d tau = v - v' = -change; tau = -h / v_n.
        let tau_bar = -dot(bar.x, change);
        let inverse = T::ONE / dot(n, v);
        height_bar = -(tau_bar * inverse);
        out.x = sub(out.x, scale(n, tau_bar * inverse));
        out.v = add_scaled(out.v, -(tau_bar * tau * inverse), n);
    }
    (out, by.start, height_bar)
}
