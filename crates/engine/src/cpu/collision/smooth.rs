//! Contact with ground and colliders as a smooth force, for gradients that say where finite steps
//! lead: at a distance the derivative of an impact does not know whether it happens.
//!
//! A node at the distance h of a surface, with velocity u relative to it, normal n and
//! `u_n = u . n`, is in a layer of width s, in which it counts as `delta` deep:
//!
//! ```text
//! t = clamp(1/2 - h/s, 0, 1)      share = t² (3 - 2t)      delta = s (t³ - t⁴/2), below: -h
//! k = STIFFNESS / s               c = 2 (1 - e) sqrt(k)
//! b = k delta                     gamma = (c + dt k) share             P = 1 + dt gamma
//! y = b - gamma u_n               j = dt/2 (y + sqrt(y² + P b²)) / P
//! A = mu j                        S = sqrt(|u_t|² + A² + (RATE s)²)
//! v' = v + j n - (A / S) u_t
//! ```
//!
//! j is what a spring of delta with a dashpot would give per unit mass, bounded smoothly by zero,
//! so that nothing sticks, and solved for the velocity after the substep: it is the root u' = u_n + j
//! of `u' = u_n + dt/2 (y' + sqrt(y'² + b²))`, `y' = b - gamma u'`, and thereby stable at any
//! substep. With e the restitution of the impact it is critically damped at e = 0 and elastic at 1.
//! Friction takes less than all of u_t, and tends to Coulomb's mu j. Under standard gravity a node
//! rests s/2 deep. A node meets the ground and then the colliders, as by impacts; the substep ends
//! at `x + dt v'`.

use super::impulse::{ContactAdjoint, Law};
use crate::{
    constants::{SMOOTH_RATE_1_S, SMOOTH_STIFFNESS_M_S2},
    cpu::arithmetic::{Quad, Real, add, add_scaled, dot, scale},
};

/// The layer of a rollout.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Layer<T> {
    width: T,
    /// k [1/s²].
    stiffness: T,
    /// Tangential speed squared below which friction is viscous [m²/s²].
    slow2: T,
    dt: T,
}

/// Response of the layer to a distance and a normal velocity.
struct Normal<T> {
    /// d share / d h.
    share_slope: T,
    share: T,
    damping: T,
    gamma: T,
    p: T,
    b: T,
    y: T,
    root: T,
    j: T,
}

impl<T: Real> Layer<T> {
    pub(crate) fn new(width: T, dt: T) -> Self {
        let slow = width * T::from_f64(SMOOTH_RATE_1_S);
        let stiffness = T::from_f64(SMOOTH_STIFFNESS_M_S2) / width;
        Self { width, stiffness, slow2: slow * slow, dt }
    }

    /// True if a node at this distance feels the surface.
    #[inline(always)]
    pub(crate) fn reaches(&self, distance: T) -> bool {
        distance + distance < self.width
    }

    #[inline(always)]
    fn normal(&self, law: Law<T>, h: T, u_n: T) -> Normal<T> {
        let (half, two) = (T::from_f64(0.5), T::from_f64(2.0));
        let t = (half - h / self.width).at_least(T::ZERO).at_most(T::ONE);
        let share = t * t * (T::from_f64(3.0) - two * t);
        let below = t >= T::ONE;
        let depth = if below { -h } else { self.width * t * t * t * (T::ONE - half * t) };
        let share_slope = -(T::from_f64(6.0) * t * (T::ONE - t)) / self.width;
        let damping = two * (T::ONE - law.restitution) * self.stiffness.sqrt();
        let gamma = (damping + self.dt * self.stiffness) * share;
        let p = T::ONE + self.dt * gamma;
        let b = self.stiffness * depth;
        let y = b - gamma * u_n;
        let root = (y * y + p * b * b).sqrt();
        let j = half * self.dt * (y + root) / p;
        Normal { share_slope, share, damping, gamma, p, b, y, root, j }
    }

    /// Change of velocity.
    #[inline(always)]
    pub(crate) fn change(&self, law: Law<T>, h: T, u: Quad<T>, n: Quad<T>) -> Quad<T> {
        let u_n = dot(u, n);
        let u_t = add_scaled(u, -u_n, n);
        let j = self.normal(law, h, u_n).j;
        let most = law.friction * j;
        let speed = (dot(u_t, u_t) + most * most + self.slow2).sqrt();
        add_scaled(scale(n, j), -(most / speed), u_t)
    }

    /// Adjoint of [`Self::change`] for d loss / d change = `bar`.
    #[inline(always)]
    pub(crate) fn change_adjoint(
        &self,
        law: Law<T>,
        h: T,
        u: Quad<T>,
        n: Quad<T>,
        bar: Quad<T>,
    ) -> ContactAdjoint<T> {
        let u_n = dot(u, n);
        let u_t = add_scaled(u, -u_n, n);
        let at = self.normal(law, h, u_n);
        let most = law.friction * at.j;
        let speed = (dot(u_t, u_t) + most * most + self.slow2).sqrt();
        let inverse = T::ONE / speed;
        let brake = most * inverse;
        let brake_bar = -dot(u_t, bar);
        // brake = most / speed, by most and by u_t.
        let most_bar = brake_bar * inverse * (T::ONE - brake * brake);
        let u_t_bar = add_scaled(scale(bar, -brake), -(brake_bar * brake * inverse * inverse), u_t);
        let j_bar = dot(n, bar) + law.friction * most_bar;
        // j = dt/2 (y + root) / p.
        let q = T::from_f64(0.5) * self.dt / at.p;
        let root_inverse = if at.root > T::ZERO { T::ONE / at.root } else { T::ZERO };
        let y_bar = j_bar * q * (T::ONE + at.y * root_inverse);
        let b_bar = y_bar + j_bar * q * at.p * at.b * root_inverse;
        let p_bar = j_bar * (q * T::from_f64(0.5) * at.b * at.b * root_inverse - at.j / at.p);
        let gamma_bar = self.dt * p_bar - u_n * y_bar;
        let share_bar = gamma_bar * (at.damping + self.dt * self.stiffness);
        let h_bar = share_bar * at.share_slope - b_bar * self.stiffness * at.share;
        let u_n_bar = -(at.gamma * y_bar) - dot(n, u_t_bar);
        let normal = add_scaled(scale(bar, at.j), u_n_bar, u);
        let two = T::from_f64(2.0);
        ContactAdjoint {
            start: [T::ZERO; 4],
            v: add_scaled(u_t_bar, u_n_bar, n),
            normal: add(normal, scale(u_t_bar, -u_n)),
            distance: h_bar,
            restitution: -(two * gamma_bar * at.share * self.stiffness.sqrt()),
            friction: most_bar * at.j,
        }
    }
}

#[cfg(test)]
mod tests;
