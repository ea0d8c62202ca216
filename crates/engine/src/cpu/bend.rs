//! Bending triplets (i, j, k) about the centre j, and the adjoint of their forces.
//!
//! With u = xi - xj, w = xk - xj, n = u x w, m = |n|: `theta = atan2(m, u.w)`, its gradient is
//! `g_i = u x n / (|u|² m)`, `g_k = n x w / (|w|² m)`, `g_j = -(g_i + g_k)`, and the force on a is
//! `-[k (theta - theta0) + c thetadot] g_a`. This is the usual form with (ŵ - cos û)/(sin |u|),
//! written with cross products because these do not cancel when the triplet is nearly straight.
//!
//! **Nearly collinear** (sin theta below [`MIN_SINE`]): the bending plane is undefined. A triplet
//! whose rest angle is pi still has a smooth elastic force, (theta - pi)/m -> -1/|u.w|, and keeps
//! it (without damping, which has a direction only); any other is skipped for the substep.

use super::{
    lanes::{self, Index, LANES, Lane, Node, v3},
    real::{Quad, Real},
};

/// Sine below which a triplet counts as collinear.
pub(crate) const MIN_SINE: f64 = 1e-4;
/// Arms shorter than this [m] have no direction: the triplet is skipped.
const MIN_ARM_M: f64 = 1e-6;
/// Rest angles nearer to pi than this [rad] are pi (an `f32` pi is not quite).
pub(crate) const STRAIGHT_RAD: f64 = 1e-6;

/// [`LANES`] triplets; one that only fills up the last block has no stiffness and no arms.
#[derive(Clone, Debug)]
pub(crate) struct TripletBlock<T> {
    pub(crate) i: Index,
    pub(crate) j: Index,
    pub(crate) k: Index,
    /// Bending stiffness [N m/rad].
    pub(crate) stiffness: Lane<T>,
    /// Bending damping [N m s/rad].
    pub(crate) damping: Lane<T>,
    /// pi - theta0 [rad]; exactly zero for straight rest angles.
    pub(crate) rest_bend: Lane<T>,
}

impl<T: Real> TripletBlock<T> {
    pub(crate) const EMPTY: Self = Self {
        i: [0; LANES],
        j: [0; LANES],
        k: [0; LANES],
        stiffness: [T::ZERO; LANES],
        damping: [T::ZERO; LANES],
        rest_bend: [T::ZERO; LANES],
    };
}

/// d loss / d (stiffness, damping, rest angle) of a block.
#[derive(Clone, Debug)]
pub(crate) struct TripletGradient<T> {
    pub(crate) stiffness: Lane<T>,
    pub(crate) damping: Lane<T>,
    pub(crate) rest: Lane<T>,
}

impl<T: Real> TripletGradient<T> {
    pub(crate) const ZERO: Self =
        Self { stiffness: [T::ZERO; LANES], damping: [T::ZERO; LANES], rest: [T::ZERO; LANES] };
}

/// pi - theta0, exactly zero where theta0 is pi.
pub(crate) fn rest_bend<T: Real>(rest_angle_rad: T) -> T {
    let bend = std::f64::consts::PI - rest_angle_rad.to_f64();
    T::from_f64(if bend.abs() < STRAIGHT_RAD { 0.0 } else { bend })
}

/// What force and adjoint share. `a_u = m g_i` and `a_w = m g_k` are smooth everywhere.
struct Bent<T> {
    a_u: [T; 3],
    a_w: [T; 3],
    n: [T; 3],
    inverse_u2: T,
    inverse_w2: T,
    /// 1/m; 1 where collinear.
    inverse_m: T,
    /// u . w; -1 where it could divide by zero.
    cosine: T,
    /// theta - theta0 = rest_bend - (pi - theta).
    deviation: T,
    /// Not collinear: the general formula holds.
    regular: bool,
    /// Collinear, but with a smooth elastic force.
    straight: bool,
}

#[inline(always)]
fn bent<T: Real>(u: [T; 3], w: [T; 3], rest_bend: T) -> Bent<T> {
    let least = T::from_f64(MIN_ARM_M * MIN_ARM_M);
    let (u2, w2) = (v3::dot(u, u), v3::dot(w, w));
    let armed = (u2 > least) & (w2 > least);
    let inverse_u2 = (T::ONE / u2.at_least(least)).only_if(armed);
    let inverse_w2 = (T::ONE / w2.at_least(least)).only_if(armed);
    let n = v3::cross(u, w);
    let m2 = v3::dot(n, n);
    let cosine = v3::dot(u, w);
    let regular = armed & (m2 * inverse_u2 * inverse_w2 >= T::from_f64(MIN_SINE * MIN_SINE));
    let straight = armed & !regular & (rest_bend == T::ZERO) & (cosine < T::ZERO);
    let m = m2.sqrt();
    Bent {
        a_u: v3::scale(v3::cross(u, n), inverse_u2),
        a_w: v3::scale(v3::cross(n, w), inverse_w2),
        n,
        inverse_u2,
        inverse_w2,
        inverse_m: T::ONE / if regular { m } else { T::ONE },
        cosine: if straight { cosine } else { -T::ONE },
        deviation: rest_bend - T::angle(m, -cosine),
        regular,
        straight,
    }
}

/// Adds every triplet's forces to its endpoints.
#[inline(always)]
pub(crate) fn bend_forces<T: Real>(
    blocks: &[TripletBlock<T>],
    nodes: &[Node<T>],
    forces: &mut [Quad<T>],
) {
    for b in blocks {
        let (u, u_dot) = lanes::relative(nodes, &b.j, &b.i);
        let (w, w_dot) = lanes::relative(nodes, &b.j, &b.k);
        let (mut f_i, mut f_k) = (lanes::zero3(), lanes::zero3());
        for l in 0..LANES {
            let t = bent(lanes::at(&u, l), lanes::at(&w, l), b.rest_bend[l]);
            let rate = v3::dot(t.a_u, lanes::at(&u_dot, l)) + v3::dot(t.a_w, lanes::at(&w_dot, l));
            let elastic = if t.straight { T::ONE / t.cosine } else { t.deviation * t.inverse_m };
            let damping = (b.damping[l] * rate * t.inverse_m * t.inverse_m).only_if(t.regular);
            let magnitude = -(b.stiffness[l] * elastic.only_if(t.regular | t.straight) + damping);
            for c in 0..3 {
                f_i[c][l] = magnitude * t.a_u[c];
                f_k[c][l] = magnitude * t.a_w[c];
            }
        }
        for l in 0..LANES {
            let (i, j, k) = (b.i[l] as usize, b.j[l] as usize, b.k[l] as usize);
            for c in 0..3 {
                forces[i][c] += f_i[c][l];
            }
            for c in 0..3 {
                forces[j][c] -= f_i[c][l] + f_k[c][l];
            }
            for c in 0..3 {
                forces[k][c] += f_k[c][l];
            }
        }
    }
}

/// Adjoint of [`bend_forces`]: given d loss / d force in `lambda`, adds d loss / d (position, velocity) to
/// `adjoint` and d loss / d parameters to `gradients`.
///
/// With kappa the bracket of the force and rho = g . lambda: `v_bar = -rho c g`,
/// `x_bar = -rho k g - H (rho c v + kappa lambda)` where H is the Hessian of theta, whose product
/// with a vector is the derivative of g along it.
#[inline(always)]
pub(crate) fn bend_adjoint<T: Real>(
    blocks: &[TripletBlock<T>],
    nodes: &[Node<T>],
    lambda: &[Quad<T>],
    adjoint: &mut [Node<T>],
    gradients: &mut [TripletGradient<T>],
) {
    for (b, grad) in blocks.iter().zip(gradients) {
        let (u, u_dot) = lanes::relative(nodes, &b.j, &b.i);
        let (w, w_dot) = lanes::relative(nodes, &b.j, &b.k);
        let pull_u = lanes::difference(lambda, &b.j, &b.i);
        let pull_w = lanes::difference(lambda, &b.j, &b.k);
        let (mut x_i, mut x_k) = (lanes::zero3(), lanes::zero3());
        let (mut v_i, mut v_k) = (lanes::zero3(), lanes::zero3());
        for l in 0..LANES {
            let (u, w) = (lanes::at(&u, l), lanes::at(&w, l));
            let (u_dot, w_dot) = (lanes::at(&u_dot, l), lanes::at(&w_dot, l));
            let (pull_u, pull_w) = (lanes::at(&pull_u, l), lanes::at(&pull_w, l));
            let (stiffness, damping) = (b.stiffness[l], b.damping[l]);
            let t = bent(u, w, b.rest_bend[l]);
            let g_u = v3::scale(t.a_u, t.inverse_m);
            let g_w = v3::scale(t.a_w, t.inverse_m);
            let rate = v3::dot(g_u, u_dot) + v3::dot(g_w, w_dot);
            let rho = v3::dot(g_u, pull_u) + v3::dot(g_w, pull_w);
            let kappa = stiffness * t.deviation + damping * rate;
            let y_u = v3::add_scaled(v3::scale(pull_u, kappa), rho * damping, u_dot);
            let y_w = v3::add_scaled(v3::scale(pull_w, kappa), rho * damping, w_dot);
            let (h_u, h_w) = hessian_product(&t, (u, w), (g_u, g_w), (y_u, y_w));
            let (s_u, s_w, s_k) = straight_adjoint(&t, stiffness, (u, w), (pull_u, pull_w));
            for c in 0..3 {
                let x_u = -(rho * stiffness * g_u[c] + h_u[c]);
                let x_w = -(rho * stiffness * g_w[c] + h_w[c]);
                x_i[c][l] = x_u.only_if(t.regular) + s_u[c];
                x_k[c][l] = x_w.only_if(t.regular) + s_w[c];
                v_i[c][l] = -(rho * damping * g_u[c]).only_if(t.regular);
                v_k[c][l] = -(rho * damping * g_w[c]).only_if(t.regular);
            }
            grad.stiffness[l] += s_k - (rho * t.deviation).only_if(t.regular);
            grad.damping[l] -= (rho * rate).only_if(t.regular);
            grad.rest[l] += (rho * stiffness).only_if(t.regular);
        }
        for l in 0..LANES {
            let (i, j, k) = (b.i[l] as usize, b.j[l] as usize, b.k[l] as usize);
            for c in 0..3 {
                adjoint[i].x[c] += x_i[c][l];
                adjoint[i].v[c] += v_i[c][l];
            }
            for c in 0..3 {
                adjoint[j].x[c] -= x_i[c][l] + x_k[c][l];
                adjoint[j].v[c] -= v_i[c][l] + v_k[c][l];
            }
            for c in 0..3 {
                adjoint[k].x[c] += x_k[c][l];
                adjoint[k].v[c] += v_k[c][l];
            }
        }
    }
}

/// A vector for each of the two arms.
type Arms<T> = ([T; 3], [T; 3]);

/// Derivative of (g_i, g_k) along `y`.
#[inline(always)]
fn hessian_product<T: Real>(t: &Bent<T>, (u, w): Arms<T>, g: Arms<T>, y: Arms<T>) -> Arms<T> {
    let n_dot = v3::add(v3::cross(y.0, w), v3::cross(u, y.1));
    let m_rate = v3::dot(t.n, n_dot) * t.inverse_m * t.inverse_m;
    let two = T::ONE + T::ONE;
    let u_part = v3::add(v3::cross(y.0, t.n), v3::cross(u, n_dot));
    let w_part = v3::add(v3::cross(n_dot, w), v3::cross(t.n, y.1));
    let u_decay = two * v3::dot(u, y.0) * t.inverse_u2 + m_rate;
    let w_decay = two * v3::dot(w, y.1) * t.inverse_w2 + m_rate;
    (
        v3::add_scaled(v3::scale(u_part, t.inverse_u2 * t.inverse_m), -u_decay, g.0),
        v3::add_scaled(v3::scale(w_part, t.inverse_w2 * t.inverse_m), -w_decay, g.1),
    )
}

/// Adjoint of the straight limit `f_i = -k / (u.w) a_u`, `f_k = -k / (u.w) a_w`: position adjoints of the
/// arms and d loss / d stiffness; zero where the triplet is not in that limit.
#[inline(always)]
fn straight_adjoint<T: Real>(
    t: &Bent<T>,
    stiffness: T,
    (u, w): Arms<T>,
    (pull_u, pull_w): Arms<T>,
) -> ([T; 3], [T; 3], T) {
    let r = (-T::ONE / t.cosine).only_if(t.straight);
    let d = t.cosine;
    let (p, q) = (v3::dot(u, pull_u) * t.inverse_u2, v3::dot(w, pull_w) * t.inverse_w2);
    let work = v3::dot(t.a_u, pull_u) + v3::dot(t.a_w, pull_w);
    let two = T::ONE + T::ONE;
    // S = k r(u.w) (a_u . pull_u + a_w . pull_w), a_u . pull_u = (u.w) p - w . pull_u.
    let along = p + q + r * work;
    let mut s_u = v3::scale(w, along);
    let mut s_w = v3::scale(u, along);
    for c in 0..3 {
        s_u[c] += d * t.inverse_u2 * (pull_u[c] - two * p * u[c]) - pull_w[c];
        s_w[c] += d * t.inverse_w2 * (pull_w[c] - two * q * w[c]) - pull_u[c];
    }
    (v3::scale(s_u, stiffness * r), v3::scale(s_w, stiffness * r), r * work)
}

/// theta - theta0 of one triplet; zero where an arm is missing.
pub(crate) fn deviation<T: Real>(u: [T; 3], w: [T; 3], rest_bend: T) -> T {
    let t = bent(u, w, rest_bend);
    t.deviation.only_if(t.inverse_u2 > T::ZERO)
}

#[cfg(test)]
mod tests;
