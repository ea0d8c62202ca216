//! Bending triplets (i, j, k) about the centre j, and the adjoint of their forces.
//!
//! With u = xi - xj, w = xk - xj, n = u x w, m = |n|: `theta = atan2(m, u.w)`, its gradient is
//! `g_i = u x n / (|u|² m)`, `g_k = n x w / (|w|² m)`, `g_j = -(g_i + g_k)`. This is the usual form
//! with (ŵ - cos û)/(sin |u|), written with cross products because these do not cancel when the
//! triplet is nearly straight.
//!
//! **Rounded.** `(theta - theta0)²` has an edge where a triplet whose rest angle is not pi passes
//! through straight: its force reverses abruptly there, and an adjoint that meets it grows without
//! bound. So the energy is `k (q - q0)² / 2` with `q = -sqrt(beta² + epsilon²)`, beta = pi - theta,
//! where epsilon is [`ROUNDING`] of the rest angle's beta0: the rest shape is the same, straight
//! rest angles have q = -beta as before, and beta = 0 is smooth. The force on a is
//! `-[k (q - q0) + c qdot] G_a` with G = a g, a = beta / sqrt(beta² + epsilon²). At rest a triplet
//! is stiff by `k / (1 + ROUNDING²)`.
//!
//! **Nearly collinear** (sin theta below [`MIN_SINE`]): the bending plane is undefined. A triplet
//! whose rest angle is pi still has a smooth elastic force, (theta - pi)/m -> -1/|u.w|, and keeps
//! it (without damping, which has a direction only); any other is skipped for the substep.

use super::strips::{Strip, Strips};
use crate::{
    constants::{MIN_ARM_M, MIN_SINE, ROUNDING, STRAIGHT_RAD},
    cpu::arithmetic::{Index, LANES, Lane, Machine, Node, Pack, Pack3, Portable, Quad, Real, v3},
};

/// A triplet of each centre of a strip; a lane without one has no stiffness and no arms.
#[derive(Clone, Debug)]
pub(crate) struct TripletBlock<T> {
    pub(crate) i: Index,
    pub(crate) k: Index,
    /// Bending stiffness [N m/rad].
    pub(crate) stiffness: Lane<T>,
    /// Bending damping [N m s/rad].
    pub(crate) damping: Lane<T>,
    /// pi - theta0 [rad]; exactly zero for straight rest angles.
    pub(crate) rest_bend: Lane<T>,
}

/// All triplets; their centres own them.
#[derive(Clone, Debug)]
pub(crate) struct Triplets<T> {
    pub(crate) strips: Vec<Strip>,
    pub(crate) blocks: Vec<TripletBlock<T>>,
}

/// A triplet's parameters.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Triplet<T> {
    /// i, j, k.
    pub(crate) ends: [u32; 3],
    pub(crate) stiffness: T,
    pub(crate) damping: T,
    pub(crate) rest_angle: T,
}

impl<T: Real> Triplets<T> {
    /// Triplets by their number in the graph, in the order of `strips`.
    pub(crate) fn new(strips: &Strips, triplet: impl Fn(usize) -> Triplet<T>) -> Self {
        let none = [T::ZERO; LANES];
        let mut blocks = Vec::with_capacity(strips.blocks());
        for strip in &strips.strips {
            for b in strip.blocks() {
                let (i, k) = (strip.owners, strip.owners);
                let mut block =
                    TripletBlock { i, k, stiffness: none, damping: none, rest_bend: none };
                for l in 0..LANES {
                    let Some(t) = strips.at(b, l) else { continue };
                    let Triplet { ends: [i, _, k], stiffness, damping, rest_angle } = triplet(t);
                    (block.i[l], block.k[l]) = (i, k);
                    (block.stiffness[l], block.damping[l]) = (stiffness, damping);
                    block.rest_bend[l] = rest_bend(rest_angle);
                }
                blocks.push(block);
            }
        }
        Self { strips: strips.strips.clone(), blocks }
    }

    /// Makes lanes of triplets with such an end lanes without one.
    pub(crate) fn leave_out(&mut self, ends: impl Fn(u32) -> bool) {
        for strip in &self.strips {
            for block in &mut self.blocks[strip.blocks()] {
                for l in 0..LANES {
                    let owner = strip.owners[l];
                    if ends(owner) || ends(block.i[l]) || ends(block.k[l]) {
                        (block.i[l], block.k[l]) = (owner, owner);
                        (block.stiffness[l], block.damping[l]) = (T::ZERO, T::ZERO);
                    }
                }
            }
        }
    }
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

/// Products of the two arms and their normal. Computed one block ahead of [`BendState`], which
/// depends on this root everywhere.
#[derive(Clone, Copy)]
struct BendGeometry<P: Pack> {
    /// u x n and n x w.
    across_u: Pack3<P>,
    across_w: Pack3<P>,
    n: Pack3<P>,
    /// 1/|u|² and 1/|w|²; zero where an arm has no direction.
    inverse_u2: P,
    inverse_w2: P,
    /// |n|
    sine: P,
    /// u . w
    cosine: P,
    /// Both arms have a direction.
    armed: P::Mask,
}

impl<P: Pack> BendGeometry<P> {
    #[inline(always)]
    fn new<T: Real, M: Machine<T, Pack = P>>(m: M, u: Pack3<P>, w: Pack3<P>) -> Self {
        let least = m.splat(T::from_f64(MIN_ARM_M * MIN_ARM_M));
        let (u2, w2) = (v3::dot(u, u), v3::dot(w, w));
        let armed = u2.above(least) & w2.above(least);
        let (u2, w2) = (u2.at_least(least), w2.at_least(least));
        // One division for both; the product is at least 1e-24.
        let inverse_both = (m.splat(T::ONE) / (u2 * w2)).only_if(armed);
        let n = v3::cross(u, w);
        Self {
            across_u: v3::cross(u, n),
            across_w: v3::cross(n, w),
            n,
            inverse_u2: inverse_both * w2,
            inverse_w2: inverse_both * u2,
            sine: v3::dot(n, n).sqrt(),
            cosine: v3::dot(u, w),
            armed,
        }
    }
}

/// Quantities that force and adjoint share; m is [`BendGeometry::sine`].
struct BendState<P: Pack> {
    /// 1/m; 1/(u . w) in the straight limit; 1 where the triplet is skipped.
    inverse: P,
    /// q - q0.
    deviation: P,
    /// sqrt(beta² + epsilon²), never zero.
    rounded: P,
    /// beta / rounded: the share of theta's gradient that q has; 1 where the triplet is collinear.
    ease: P,
    /// Not collinear: the general formula holds.
    regular: P::Mask,
    /// Collinear, but with a smooth elastic force.
    straight: P::Mask,
}

/// `-q0 / beta0`. A root, since the compiler knows its value: `hypot` would be called in every
/// substep.
#[inline(always)]
fn rounded_share() -> f64 {
    (1.0 + ROUNDING * ROUNDING).sqrt()
}

impl<P: Pack> BendState<P> {
    #[inline(always)]
    fn new<T: Real, M: Machine<T, Pack = P>>(m: M, e: &BendGeometry<P>, rest_bend: P) -> Self {
        let (zero, one) = (m.splat(T::ZERO), m.splat(T::ONE));
        let sine2 = (e.sine * e.inverse_u2) * (e.sine * e.inverse_w2);
        let regular = e.armed & sine2.not_below(m.splat(T::from_f64(MIN_SINE * MIN_SINE)));
        let bends = rest_bend.above(zero) | zero.above(rest_bend);
        let straight = e.armed & !(regular | bends) & zero.above(e.cosine);
        let beta = T::angle(m, e.sine, -e.cosine);
        let epsilon = rest_bend * m.splat(T::from_f64(ROUNDING));
        let rounded = beta.mul_add(beta, epsilon * epsilon).sqrt();
        let rest = rest_bend * m.splat(T::from_f64(rounded_share()));
        Self {
            inverse: one / e.sine.or(regular, e.cosine.or(straight, one)),
            deviation: rest - rounded,
            rounded: rounded.or(regular, one),
            ease: (beta / rounded.or(regular, one)).or(regular, one),
            regular,
            straight,
        }
    }
}

/// Geometry and rates of a block, computed one block ahead.
#[derive(Clone, Copy)]
struct BendKinematics<P: Pack> {
    geometry: BendGeometry<P>,
    /// Rates of the arms perpendicular to themselves, |u|² m g_i . u_dot and |w|² m g_k . w_dot.
    swing_u: P,
    swing_w: P,
}

impl<P: Pack> BendKinematics<P> {
    #[inline(always)]
    fn new<T: Real, M: Machine<T, Pack = P>>(
        m: M,
        centre: (Pack3<P>, Pack3<P>),
        nodes: &[Node<T>],
        b: &TripletBlock<T>,
    ) -> Self {
        let ((x_i, v_i), (x_k, v_k)) = (m.gather(nodes, &b.i), m.gather(nodes, &b.k));
        let geometry = BendGeometry::new(m, v3::sub(x_i, centre.0), v3::sub(x_k, centre.0));
        let swing_u = v3::dot(geometry.across_u, v3::sub(v_i, centre.1));
        let swing_w = v3::dot(geometry.across_w, v3::sub(v_k, centre.1));
        Self { geometry, swing_u, swing_w }
    }
}

/// Adds every triplet's forces to its endpoints.
#[inline(always)]
pub(crate) fn bend_forces<T: Real, M: Machine<T>>(
    m: M,
    triplets: &Triplets<T>,
    nodes: &[Node<T>],
    forces: &mut [Quad<T>],
) {
    for strip in &triplets.strips {
        let blocks = &triplets.blocks[strip.blocks()];
        let Some((mut b, later)) = blocks.split_first() else { continue };
        let centre = m.gather(nodes, &strip.owners);
        let mut sum = [m.splat(T::ZERO); 3];
        let mut kinematics = BendKinematics::new(m, centre, nodes, b);
        for next in later {
            let ahead = BendKinematics::new(m, centre, nodes, next);
            sum = apply_force(m, b, &kinematics, sum, forces);
            (b, kinematics) = (next, ahead);
        }
        sum = apply_force(m, b, &kinematics, sum, forces);
        m.scatter_add(forces, &strip.owners, sum);
    }
}

/// Adds a block's forces to the outer ends, and takes them from the sum of the centres'.
#[inline(always)]
fn apply_force<T: Real, M: Machine<T>>(
    m: M,
    b: &TripletBlock<T>,
    kinematics: &BendKinematics<M::Pack>,
    sum: Pack3<M::Pack>,
    forces: &mut [Quad<T>],
) -> Pack3<M::Pack> {
    let e = &kinematics.geometry;
    let t = BendState::new(m, e, m.load(&b.rest_bend));
    let rate = kinematics.swing_u.mul_add(e.inverse_u2, kinematics.swing_w * e.inverse_w2);
    let inverse = t.ease * t.inverse;
    let moment = m.load(&b.stiffness) * t.deviation.or(t.regular, m.splat(T::ONE));
    let damping = (m.load(&b.damping) * rate * inverse).only_if(t.regular);
    let coefficient = -((moment + damping) * inverse).only_if(t.regular | t.straight);
    let f_i = v3::scale(e.across_u, coefficient * e.inverse_u2);
    let f_k = v3::scale(e.across_w, coefficient * e.inverse_w2);
    m.scatter_add(forces, &b.i, f_i);
    m.scatter_add(forces, &b.k, f_k);
    v3::sub(v3::sub(sum, f_i), f_k)
}

/// Adjoint of [`bend_forces`]: given d loss / d force in `lambda`, adds d loss / d (position,
/// velocity) to `adjoint` and d loss / d parameters to `gradients`.
///
/// With kappa the bracket of the force and rho = G . lambda: `v_bar = -rho c G`,
/// `x_bar = -rho k G - H (rho c v + kappa lambda)` where H is the Hessian of q, whose product with
/// a vector is the derivative of G along it: `a` times that of g, less `(1 - a²)/rounded (g . y) g`
/// for what `a` itself does.
#[inline(always)]
pub(crate) fn bend_adjoint<T: Real, M: Machine<T>>(
    m: M,
    triplets: &Triplets<T>,
    nodes: &[Node<T>],
    lambda: &[Quad<T>],
    adjoint: &mut [Node<T>],
    gradients: &mut [TripletGradient<T>],
) {
    for strip in &triplets.strips {
        let (x, v) = m.gather(nodes, &strip.owners);
        let lambda_j = m.gather_quads(lambda, &strip.owners);
        let zero = [m.splat(T::ZERO); 3];
        let (mut x_sum, mut v_sum) = (zero, zero);
        let blocks = triplets.blocks[strip.blocks()].iter();
        for (b, grad) in blocks.zip(&mut gradients[strip.blocks()]) {
            let ((x_i, v_i), (x_k, v_k)) = (m.gather(nodes, &b.i), m.gather(nodes, &b.k));
            let (u, w) = (v3::sub(x_i, x), v3::sub(x_k, x));
            let (u_dot, w_dot) = (v3::sub(v_i, v), v3::sub(v_k, v));
            let pull_u = v3::sub(m.gather_quads(lambda, &b.i), lambda_j);
            let pull_w = v3::sub(m.gather_quads(lambda, &b.k), lambda_j);
            let (stiffness, damping) = (m.load(&b.stiffness), m.load(&b.damping));
            let e = BendGeometry::new(m, u, w);
            let t = BendState::new(m, &e, m.load(&b.rest_bend));
            let g_u = v3::scale(e.across_u, e.inverse_u2 * t.inverse);
            let g_w = v3::scale(e.across_w, e.inverse_w2 * t.inverse);
            let rate = t.ease * (v3::dot(g_u, u_dot) + v3::dot(g_w, w_dot));
            let rho = t.ease * (v3::dot(g_u, pull_u) + v3::dot(g_w, pull_w));
            let kappa = stiffness.mul_add(t.deviation, damping * rate);
            let (stiff, damped) = (rho * stiffness, rho * damping);
            let y_u = v3::add_scaled(v3::scale(pull_u, kappa), damped, u_dot);
            let y_w = v3::add_scaled(v3::scale(pull_w, kappa), damped, w_dot);
            let (h_u, h_w) = hessian_product(m, &e, t.inverse, (u, w), (g_u, g_w), (y_u, y_w));
            let along = v3::dot(g_u, y_u) + v3::dot(g_w, y_w);
            let turn = t.ease.neg_mul_add(t.ease, m.splat(T::ONE)) / t.rounded * along;
            let by_g = stiff.mul_add(t.ease, -turn);
            let x_u = v3::add_scaled(v3::scale(h_u, t.ease), by_g, g_u);
            let x_w = v3::add_scaled(v3::scale(h_w, t.ease), by_g, g_w);
            let x_u = v3::only_if(v3::neg(x_u), t.regular);
            let x_w = v3::only_if(v3::neg(x_w), t.regular);
            let (mut x_bar, mut s_k) = ((x_u, x_w), m.splat(T::ZERO));
            if m.any(t.straight) {
                let (s, work) = straight_adjoint(m, &e, &t, stiffness, (u, w), (pull_u, pull_w));
                x_bar = (v3::add(x_u, s.0), v3::add(x_w, s.1));
                s_k = work;
            }
            let damped = -(damped * t.ease).only_if(t.regular);
            let (v_u, v_w) = (v3::scale(g_u, damped), v3::scale(g_w, damped));
            let rho = rho.only_if(t.regular);
            grad.stiffness = m.store(rho.neg_mul_add(t.deviation, m.load(&grad.stiffness) + s_k));
            grad.damping = m.store(rho.neg_mul_add(rate, m.load(&grad.damping)));
            let by_rest =
                rest_slope(m, &t, stiffness, damping * rate + kappa, m.load(&b.rest_bend));
            grad.rest = m.store(rho.mul_add(by_rest, m.load(&grad.rest)));
            x_sum = v3::sub(x_sum, v3::add(x_bar.0, x_bar.1));
            v_sum = v3::sub(v_sum, v3::add(v_u, v_w));
            m.scatter_add_nodes(adjoint, &b.i, x_bar.0, v_u);
            m.scatter_add_nodes(adjoint, &b.k, x_bar.1, v_w);
        }
        m.scatter_add_nodes(adjoint, &strip.owners, x_sum, v_sum);
    }
}

/// d (force . lambda) / d theta0 per rho: the rest angle moves q0, and the rounding with it.
/// `moments` is the bracket of the force, with its damping twice.
#[inline(always)]
fn rest_slope<T: Real, M: Machine<T>>(
    m: M,
    t: &BendState<M::Pack>,
    stiffness: M::Pack,
    moments: M::Pack,
    rest_bend: M::Pack,
) -> M::Pack {
    let per_rounded = rest_bend * m.splat(T::from_f64(ROUNDING * ROUNDING)) / t.rounded;
    let of_rest = m.splat(T::from_f64(rounded_share())) - per_rounded;
    stiffness * of_rest - moments * (per_rounded / t.rounded)
}

/// A vector for each of the two arms.
type Arms<P> = (Pack3<P>, Pack3<P>);

/// Derivative of (g_i, g_k) along `y`.
#[inline(always)]
fn hessian_product<T: Real, M: Machine<T>>(
    m: M,
    e: &BendGeometry<M::Pack>,
    inverse: M::Pack,
    (u, w): Arms<M::Pack>,
    g: Arms<M::Pack>,
    y: Arms<M::Pack>,
) -> Arms<M::Pack> {
    let two = m.splat(T::ONE + T::ONE);
    let n_dot = v3::add(v3::cross(y.0, w), v3::cross(u, y.1));
    let m_rate = v3::dot(e.n, n_dot) * inverse * inverse;
    let u_part = v3::add(v3::cross(y.0, e.n), v3::cross(u, n_dot));
    let w_part = v3::add(v3::cross(n_dot, w), v3::cross(e.n, y.1));
    let u_decay = (two * v3::dot(u, y.0)).mul_add(e.inverse_u2, m_rate);
    let w_decay = (two * v3::dot(w, y.1)).mul_add(e.inverse_w2, m_rate);
    (
        v3::sub_scaled(v3::scale(u_part, e.inverse_u2 * inverse), u_decay, g.0),
        v3::sub_scaled(v3::scale(w_part, e.inverse_w2 * inverse), w_decay, g.1),
    )
}

/// Adjoint of the straight limit `f_i = -k / (u.w) a_u`, `f_k = -k / (u.w) a_w` with
/// a_u = m g_i and a_w = m g_k: position adjoints of the
/// arms and d loss / d stiffness; zero where the triplet is not in that limit.
#[inline(always)]
fn straight_adjoint<T: Real, M: Machine<T>>(
    m: M,
    e: &BendGeometry<M::Pack>,
    t: &BendState<M::Pack>,
    stiffness: M::Pack,
    (u, w): Arms<M::Pack>,
    (pull_u, pull_w): Arms<M::Pack>,
) -> (Arms<M::Pack>, M::Pack) {
    let two = m.splat(T::ONE + T::ONE);
    let r = -t.inverse.only_if(t.straight);
    let p = v3::dot(u, pull_u) * e.inverse_u2;
    let q = v3::dot(w, pull_w) * e.inverse_w2;
    let work =
        (v3::dot(e.across_u, pull_u) * e.inverse_u2) + v3::dot(e.across_w, pull_w) * e.inverse_w2;
    // S = k r(u.w) (a_u . pull_u + a_w . pull_w), a_u . pull_u = (u.w) p - w . pull_u.
    let along = r.mul_add(work, p + q);
    let flat_u = v3::sub_scaled(pull_u, two * p, u);
    let flat_w = v3::sub_scaled(pull_w, two * q, w);
    let s_u = v3::add_scaled(v3::scale(w, along), e.cosine * e.inverse_u2, flat_u);
    let s_w = v3::add_scaled(v3::scale(u, along), e.cosine * e.inverse_w2, flat_w);
    let by = stiffness * r;
    let arms = (v3::scale(v3::sub(s_u, pull_w), by), v3::scale(v3::sub(s_w, pull_u), by));
    (arms, r * work)
}

/// q - q0 of one triplet; zero where an arm is missing.
pub(crate) fn deviation(u: [f64; 3], w: [f64; 3], rest_bend: f64) -> f64 {
    let m = Portable;
    let e = BendGeometry::new(m, u.map(|c| m.splat(c)), w.map(|c| m.splat(c)));
    let t = BendState::new(m, &e, m.splat(rest_bend));
    m.store(t.deviation.only_if(e.armed))[0]
}

#[cfg(test)]
mod tests;
