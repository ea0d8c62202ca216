//! Axial springs with dashpots, and the adjoint of their forces.
//!
//! With r = xj - xi, l = |r|, d = r / l and q = (vj - vi) . d:
//! `f_i = [k (l/l0 - 1) + gamma q] d`, `f_j = -f_i`.

use super::{
    lanes::{Index, LANES, Lane, Node},
    machine::{Machine, Pack, Pack3, v3},
    real::{Quad, Real},
    strips::{Strip, Strips},
};

/// Below this length [m] a spring has no direction and exerts no force.
const MIN_LENGTH_M: f64 = 1e-12;

/// One spring of each owner of a strip; a lane without one joins its owner with itself and has no
/// stiffness.
#[derive(Clone, Debug)]
pub(crate) struct SpringBlock<T> {
    /// The end that does not own the spring.
    pub(crate) other: Index,
    /// k / l0 [N/m]; zero where l0 is zero: strain is undefined there, the dashpot remains.
    pub(crate) rate: Lane<T>,
    /// l0 [m].
    pub(crate) rest: Lane<T>,
    /// gamma [N s/m].
    pub(crate) dashpot: Lane<T>,
}

/// All springs.
#[derive(Debug)]
pub(crate) struct Springs<T> {
    pub(crate) strips: Vec<Strip>,
    pub(crate) blocks: Vec<SpringBlock<T>>,
}

/// A spring's parameters as the forces want them.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Spring<T> {
    pub(crate) ends: [u32; 2],
    pub(crate) stiffness: T,
    pub(crate) rest: T,
    pub(crate) dashpot: T,
}

impl<T: Real> Springs<T> {
    /// Springs by their number in the graph, in the order of `strips`.
    pub(crate) fn new(strips: &Strips, spring: impl Fn(usize) -> Spring<T>) -> Self {
        let none = [T::ZERO; LANES];
        let mut blocks = Vec::with_capacity(strips.blocks());
        for strip in &strips.strips {
            for b in strip.blocks() {
                let mut block =
                    SpringBlock { other: strip.owners, rate: none, rest: none, dashpot: none };
                for l in 0..LANES {
                    let Some(s) = strips.at(b, l) else { continue };
                    let Spring { ends: [i, j], stiffness, rest, dashpot } = spring(s);
                    let rate = stiffness / rest;
                    block.other[l] = if strip.owners[l] == i { j } else { i };
                    block.rate[l] = rate.only_if(rest > T::ZERO && rate.is_finite());
                    block.rest[l] = rest;
                    block.dashpot[l] = dashpot;
                }
                blocks.push(block);
            }
        }
        Self { strips: strips.strips.clone(), blocks }
    }
}

/// Sums over substeps and lanes' springs that d loss / d (k, gamma, l0) are made of; p and q as in
/// [`spring_adjoint`], s = l - l0.
#[derive(Clone, Debug)]
pub(crate) struct SpringGradient<T> {
    /// p
    pull: Lane<T>,
    /// p s
    stretch: Lane<T>,
    /// p q
    dashpot: Lane<T>,
}

impl<T: Real> SpringGradient<T> {
    pub(crate) const ZERO: Self =
        Self { pull: [T::ZERO; LANES], stretch: [T::ZERO; LANES], dashpot: [T::ZERO; LANES] };

    /// d loss / d (k, gamma, l0) of a lane's spring.
    pub(crate) fn of(&self, block: &SpringBlock<T>, l: usize) -> [T; 3] {
        let (rate, rest) = (block.rate[l], block.rest[l]);
        if rest > T::ZERO {
            // f = k (l/l0 - 1), so df/dk = s/l0 and df/dl0 = -k l/l0^2, where l = s + l0.
            let stretch = self.stretch[l] / rest;
            [stretch, self.dashpot[l], -(rate * (stretch + self.pull[l]))]
        } else {
            [T::ZERO, self.dashpot[l], T::ZERO]
        }
    }
}

/// Length and its inverse; the inverse of (almost) nothing is zero.
#[inline(always)]
fn length<T: Real, M: Machine<T>>(m: M, r: Pack3<M::Pack>) -> (M::Pack, M::Pack) {
    let least = m.splat(T::from_f64(MIN_LENGTH_M * MIN_LENGTH_M));
    let square = v3::dot(r, r);
    let length = square.at_least(least).sqrt();
    (length, (m.splat(T::ONE) / length).only_if(square.above(least)))
}

/// Adds every spring's force to both of its endpoints.
#[inline(always)]
pub(crate) fn spring_forces<T: Real, M: Machine<T>>(
    m: M,
    springs: &Springs<T>,
    nodes: &[Node<T>],
    forces: &mut [Quad<T>],
) {
    for strip in &springs.strips {
        let (x, v) = m.gather(nodes, &strip.owners);
        let mut sum = [m.splat(T::ZERO); 3];
        for b in &springs.blocks[strip.blocks()] {
            let (x_other, v_other) = m.gather(nodes, &b.other);
            // From the other end to the owner.
            let (r, w) = (v3::sub(x, x_other), v3::sub(v, v_other));
            let (length, inverse) = length(m, r);
            let elastic = m.load(&b.rate) * (length - m.load(&b.rest));
            let damping = m.load(&b.dashpot) * v3::dot(w, r);
            let pull = damping.mul_add(inverse, elastic) * inverse;
            sum = v3::sub_scaled(sum, pull, r);
            m.scatter_add(forces, &b.other, v3::scale(r, pull));
        }
        m.scatter_add(forces, &strip.owners, sum);
    }
}

/// Adjoint of [`spring_forces`]: given d loss / d force in `lambda`, adds d loss / d (position,
/// velocity) to `adjoint` and to the sums that d loss / d parameters are made of.
///
/// With p = d . (lambda_i - lambda_j) and F the bracket above: `r_bar = k/l0 p d + gamma p (w - q d)/l
/// + F (lambda - p d)/l`, `w_bar = gamma p d`, both with opposite signs at the two ends. Where a spring
/// has no direction, d and with it everything is zero.
#[inline(always)]
pub(crate) fn spring_adjoint<T: Real, M: Machine<T>>(
    m: M,
    springs: &Springs<T>,
    nodes: &[Node<T>],
    lambda: &[Quad<T>],
    adjoint: &mut [Node<T>],
    gradients: &mut [SpringGradient<T>],
) {
    for strip in &springs.strips {
        let (x, v) = m.gather(nodes, &strip.owners);
        let lambda_owner = m.gather_quads(lambda, &strip.owners);
        let zero = [m.splat(T::ZERO); 3];
        let (mut x_sum, mut v_sum) = (zero, zero);
        let blocks = springs.blocks[strip.blocks()].iter();
        for (b, g) in blocks.zip(&mut gradients[strip.blocks()]) {
            let (x_other, v_other) = m.gather(nodes, &b.other);
            // i is the owner, j the other end.
            let (r, w) = (v3::sub(x_other, x), v3::sub(v_other, v));
            let pull = v3::sub(lambda_owner, m.gather_quads(lambda, &b.other));
            let (length, inverse) = length(m, r);
            let (rate, dashpot) = (m.load(&b.rate), m.load(&b.dashpot));
            let stretch = length - m.load(&b.rest);
            let d = v3::scale(r, inverse);
            let (p, q) = (v3::dot(d, pull), v3::dot(d, w));
            let force = dashpot.mul_add(q, rate * stretch) * inverse;
            let damped = dashpot * p;
            let turned = damped * inverse;
            let along = force.neg_mul_add(p, turned.neg_mul_add(q, rate * p));
            let r_bar = v3::add_scaled(v3::add_scaled(v3::scale(d, along), turned, w), force, pull);
            let w_bar = v3::scale(d, damped);
            g.pull = m.store(m.load(&g.pull) + p);
            g.stretch = m.store(p.mul_add(stretch, m.load(&g.stretch)));
            g.dashpot = m.store(p.mul_add(q, m.load(&g.dashpot)));
            (x_sum, v_sum) = (v3::sub(x_sum, r_bar), v3::sub(v_sum, w_bar));
            m.scatter_add_nodes(adjoint, &b.other, r_bar, w_bar);
        }
        m.scatter_add_nodes(adjoint, &strip.owners, x_sum, v_sum);
    }
}

#[cfg(test)]
mod tests;
