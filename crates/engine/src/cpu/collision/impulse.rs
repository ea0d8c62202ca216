//! The velocity change of a frictional impact and of a push out of a surface, and its adjoint. The
//! ground, colliders and contact between nodes are this one formula with different partners.
//!
//! For the velocity v of the second body relative to the first just before contact, s the same at
//! the start of the substep, and the unit normal n, with v_n = v . n < 0 and v_t = v - v_n n:
//!
//! ```text
//! r = e clamp(-s . n, 0, -v_n)                  speed of the rebound
//! J = -v_n + r                                  impulse by mass
//! change = J n - min(1, mu J / |v_t|) v_t
//! ```
//!
//! Restitution acts on the approach that the substep itself does not explain: v differs from s by
//! what forces added within the substep, and that part is stopped without a bounce. A node that a
//! force presses on a surface has s . n = 0 and stays, however large the force is; one that flies
//! into it rebounds with e times the speed of its flight, so that bounces die away. Guendelman,
//! Bridson and Fedkiw (Nonconvex Rigid Bodies with Stacking, 2003) separate collisions, which bounce
//! with the velocities before forces act, from contacts, which do not, in the same way.

use crate::{
    constants::{MAX_PUSH_M, PUSH_S},
    cpu::arithmetic::{Quad, Real, add_scaled, dot, scale, sub},
};

/// Restitution and Coulomb friction.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Law<T> {
    pub(crate) restitution: T,
    pub(crate) friction: T,
}

impl<T: Real> Law<T> {
    /// Adds the gradients in a contact's adjoint.
    #[inline(always)]
    pub(crate) fn add(&mut self, by: &ContactAdjoint<T>) {
        self.restitution += by.restitution;
        self.friction += by.friction;
    }
}

/// Relative velocity of two bodies [m/s].
#[derive(Clone, Copy, Debug)]
pub(crate) struct Approach<T> {
    /// Relative velocity at the start of the substep.
    pub(crate) start: Quad<T>,
    /// Just before contact.
    pub(crate) now: Quad<T>,
}

/// d loss / d (approach, normal, distance, restitution, friction).
pub(crate) struct ContactAdjoint<T> {
    pub(crate) start: Quad<T>,
    pub(crate) v: Quad<T>,
    pub(crate) normal: Quad<T>,
    pub(crate) distance: T,
    pub(crate) restitution: T,
    pub(crate) friction: T,
}

impl<T: Real> ContactAdjoint<T> {
    pub(crate) const ZERO: Self = Self {
        start: [T::ZERO; 4],
        v: [T::ZERO; 4],
        normal: [T::ZERO; 4],
        distance: T::ZERO,
        restitution: T::ZERO,
        friction: T::ZERO,
    };
}

/// Parts of an impact that value and adjoint share.
struct Impact<T> {
    v_n: T,
    v_t: Quad<T>,
    /// Approach that the substep does not explain [m/s].
    unexplained: T,
    /// J.
    impulse: T,
    /// |v_t|.
    speed: T,
    /// Friction is too weak to stop the sliding.
    slips: bool,
}

#[inline(always)]
fn resolve<T: Real>(law: Law<T>, u: Approach<T>, n: Quad<T>) -> Impact<T> {
    let v_n = dot(u.now, n);
    let v_t = add_scaled(u.now, -v_n, n);
    let unexplained = (-dot(u.start, n)).at_most(-v_n).at_least(T::ZERO);
    let impulse = law.restitution * unexplained - v_n;
    let speed = dot(v_t, v_t).sqrt();
    Impact { v_n, v_t, unexplained, impulse, speed, slips: law.friction * impulse < speed }
}

/// Change of relative velocity by an impact.
#[inline(always)]
pub(crate) fn impact<T: Real>(law: Law<T>, u: Approach<T>, n: Quad<T>) -> Quad<T> {
    let Impact { v_t, impulse, speed, slips, .. } = resolve(law, u, n);
    let brake = if slips { -(law.friction * impulse) / speed } else { -T::ONE };
    add_scaled(scale(n, impulse), brake, v_t)
}

/// Adjoint of [`impact`] for d loss / d change = `b`.
#[inline(always)]
pub(crate) fn impact_adjoint<T: Real>(
    law: Law<T>,
    u: Approach<T>,
    n: Quad<T>,
    b: Quad<T>,
) -> ContactAdjoint<T> {
    let at = resolve(law, u, n);
    let (mut v, mut normal, friction, impulse_bar);
    if at.slips {
        // change = J (n - mu t), t = v_t / |v_t|.
        let t = scale(at.v_t, T::ONE / at.speed);
        impulse_bar = dot(n, b) - law.friction * dot(t, b);
        let t_bar = scale(b, -(law.friction * at.impulse));
        v = scale(add_scaled(t_bar, -dot(t, t_bar), t), T::ONE / at.speed);
        let v_n_bar = -impulse_bar - dot(n, v);
        normal = add_scaled(add_scaled(scale(b, at.impulse), -at.v_n, v), v_n_bar, u.now);
        v = add_scaled(v, v_n_bar, n);
        friction = -(at.impulse * dot(t, b));
    } else {
        // change = r n - v.
        impulse_bar = dot(n, b);
        v = scale(b, -T::ONE);
        normal = scale(b, law.restitution * at.unexplained);
        friction = T::ZERO;
    }
    // r = e clamp(-s . n, 0, -v_n).
    let speed_bar = law.restitution * impulse_bar;
    let mut start = [T::ZERO; 4];
    if at.unexplained > T::ZERO {
        if at.unexplained < -at.v_n {
            start = scale(n, -speed_bar);
            normal = add_scaled(normal, -speed_bar, u.start);
        } else {
            v = add_scaled(v, -speed_bar, n);
            normal = add_scaled(normal, -speed_bar, u.now);
        }
    }
    let restitution = at.unexplained * impulse_bar;
    ContactAdjoint { start, v, normal, distance: T::ZERO, restitution, friction }
}

/// Effect of a surface on a relative velocity within a substep: an impact on contact, then a push
/// out of the surface if the node is inside and leaves too slowly.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Contact<T> {
    pub(crate) hits: bool,
    pushes: bool,
    /// Change of velocity by the impact.
    impact: Quad<T>,
    /// Change of velocity.
    pub(crate) change: Quad<T>,
}

impl<T: Real> Contact<T> {
    /// Resolves a contact; `inside` is the signed distance where a surface pushes.
    #[inline(always)]
    pub(crate) fn new(
        law: Law<T>,
        u: Approach<T>,
        n: Quad<T>,
        hits: bool,
        inside: Option<T>,
    ) -> Self {
        let impact = if hits { impact(law, u, n) } else { [T::ZERO; 4] };
        let mut contact = Self { hits, pushes: false, impact, change: impact };
        if let Some(distance) = inside {
            let lack = push(distance).0 - dot(n, add_scaled(u.now, T::ONE, impact));
            contact.pushes = lack > T::ZERO;
            if contact.pushes {
                contact.change = add_scaled(impact, lack, n);
            }
        }
        contact
    }

    /// True if the contact changes a velocity.
    #[inline(always)]
    pub(crate) fn acts(&self) -> bool {
        self.hits | self.pushes
    }

    /// Adjoint of [`Self::new`] for d loss / d change = `b`.
    #[inline(always)]
    pub(crate) fn adjoint(
        &self,
        law: Law<T>,
        u: Approach<T>,
        n: Quad<T>,
        distance: T,
        b: Quad<T>,
    ) -> ContactAdjoint<T> {
        let mut out = ContactAdjoint::ZERO;
        let along = dot(n, b);
        let impact_bar = if self.pushes { add_scaled(b, -along, n) } else { b };
        if self.hits {
            out = impact_adjoint(law, u, n, impact_bar);
        }
        if self.pushes {
            // change = impact + (push - n . leaves) n, leaves = v + impact.
            let (speed, slope) = push(distance);
            let leaves = add_scaled(u.now, T::ONE, self.impact);
            out.v = add_scaled(out.v, -along, n);
            out.normal = add_scaled(out.normal, speed - dot(n, leaves), b);
            out.normal = sub(out.normal, scale(leaves, along));
            out.distance = slope * along;
        }
        out
    }
}

/// Normal velocity with which a body at this signed distance leaves a surface at least, and the
/// derivative by the distance: `min(-d, 5 mm) / 10 ms`.
#[inline(always)]
fn push<T: Real>(distance: T) -> (T, T) {
    let (deepest, rate) = (T::from_f64(MAX_PUSH_M), T::from_f64(1.0 / PUSH_S));
    if -distance < deepest { (-distance * rate, -rate) } else { (deepest * rate, T::ZERO) }
}

#[cfg(test)]
mod tests;
