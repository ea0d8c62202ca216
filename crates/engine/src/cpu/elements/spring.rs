//! Axial springs with dashpots, and the adjoint of their forces.
//!
//! With r = xj - xi, l = |r|, d = r / l and q = (vj - vi) . d:
//! `f_i = [k (l/l0 - 1) + gamma q] d`, `f_j = -f_i`.

use super::strips::{Strip, Strips};
use crate::{
    constants::MIN_LENGTH_M,
    cpu::arithmetic::{Index, LANES, Lane, Machine, Node, Pack, Pack3, Quad, Real, v3},
};

/// A spring of each owner of a strip; a lane without one joins its owner with itself and has no
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
#[derive(Clone, Debug)]
pub(crate) struct Springs<T> {
    pub(crate) strips: Vec<Strip>,
    pub(crate) blocks: Vec<SpringBlock<T>>,
}

/// A spring's ends and parameters.
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

    /// Makes lanes of springs with such an end lanes without one.
    pub(crate) fn leave_out(&mut self, ends: impl Fn(u32) -> bool) {
        for strip in &self.strips {
            for block in &mut self.blocks[strip.blocks()] {
                for l in 0..LANES {
                    if ends(strip.owners[l]) || ends(block.other[l]) {
                        block.other[l] = strip.owners[l];
                        (block.rate[l], block.dashpot[l]) = (T::ZERO, T::ZERO);
                    }
                }
            }
        }
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

/// Relative positions and velocities of a block's springs, with the root and the division that all
/// else depends on. Computed one block ahead, so that the previous block waits neither for these
/// nor for memory.
#[derive(Clone, Copy)]
struct SpringGeometry<P> {
    /// The other end relative to the owner.
    r: Pack3<P>,
    w: Pack3<P>,
    /// |r|
    length: P,
    /// 1 / |r|²; zero where the spring has no direction.
    inverse2: P,
}

impl<P: Pack> SpringGeometry<P> {
    #[inline(always)]
    fn new<T: Real, M: Machine<T, Pack = P>>(
        m: M,
        owners: (Pack3<P>, Pack3<P>),
        nodes: &[Node<T>],
        others: &Index,
    ) -> Self {
        let (x, v) = m.gather(nodes, others);
        let (r, w) = (v3::sub(x, owners.0), v3::sub(v, owners.1));
        let square = v3::dot(r, r);
        let valid = square.above(m.splat(T::from_f64(MIN_LENGTH_M * MIN_LENGTH_M)));
        let inverse2 = (m.splat(T::ONE) / square).only_if(valid);
        Self { r, w, length: square.sqrt(), inverse2 }
    }
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
        let Some((mut b, later)) = springs.blocks[strip.blocks()].split_first() else { continue };
        let owners = m.gather(nodes, &strip.owners);
        let mut sum = [m.splat(T::ZERO); 3];
        let mut s = SpringGeometry::new(m, owners, nodes, &b.other);
        for next in later {
            let ahead = SpringGeometry::new(m, owners, nodes, &next.other);
            sum = apply_force(m, b, s, sum, forces);
            (b, s) = (next, ahead);
        }
        sum = apply_force(m, b, s, sum, forces);
        m.scatter_add(forces, &strip.owners, sum);
    }
}

/// Adds a block's forces to the other ends, and to the sum of the owners'.
#[inline(always)]
fn apply_force<T: Real, M: Machine<T>>(
    m: M,
    b: &SpringBlock<T>,
    s: SpringGeometry<M::Pack>,
    sum: Pack3<M::Pack>,
    forces: &mut [Quad<T>],
) -> Pack3<M::Pack> {
    // The force on the other end is against r where the spring is stretched.
    let elastic = m.load(&b.rate) * (m.load(&b.rest) - s.length);
    let damping = m.load(&b.dashpot) * v3::dot(s.w, s.r);
    let coefficient = elastic.mul_add(s.length * s.inverse2, -(damping * s.inverse2));
    m.scatter_add(forces, &b.other, v3::scale(s.r, coefficient));
    v3::sub_scaled(sum, coefficient, s.r)
}

/// Adjoint of [`spring_forces`]: given d loss / d force in `lambda`, adds d loss / d (position,
/// velocity) to `adjoint` and to the sums that d loss / d parameters are made of.
///
/// With p = d . (lambda_i - lambda_j) and F the bracket above:
/// `r_bar = k/l0 p d + gamma p (w - q d)/l + F (lambda_i - lambda_j - p d)/l`, `w_bar = gamma p d`,
/// both with opposite signs at the two ends. For a spring without direction, d and with it
/// everything is zero.
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
        let blocks = &springs.blocks[strip.blocks()];
        let Some((mut b, later)) = blocks.split_first() else { continue };
        let Some((mut g, g_later)) = gradients[strip.blocks()].split_first_mut() else { continue };
        let owners = m.gather(nodes, &strip.owners);
        let lambda_owners = m.gather_quads(lambda, &strip.owners);
        let zero = [m.splat(T::ZERO); 3];
        let mut sum = (zero, zero);
        let mut s = SpringGeometry::new(m, owners, nodes, &b.other);
        let mut pull = v3::sub(m.gather_quads(lambda, &b.other), lambda_owners);
        for (next, g_next) in later.iter().zip(g_later) {
            let ahead = SpringGeometry::new(m, owners, nodes, &next.other);
            let pull_ahead = v3::sub(m.gather_quads(lambda, &next.other), lambda_owners);
            sum = apply_force_adjoint(m, b, s, pull, sum, adjoint, g);
            (b, g, s, pull) = (next, g_next, ahead, pull_ahead);
        }
        sum = apply_force_adjoint(m, b, s, pull, sum, adjoint, g);
        m.scatter_add_nodes(adjoint, &strip.owners, sum.0, sum.1);
    }
}

/// The adjoint of [`apply_force`]; i is the owner, j the other end. `pull` is lambda_j - lambda_i.
#[inline(always)]
fn apply_force_adjoint<T: Real, M: Machine<T>>(
    m: M,
    b: &SpringBlock<T>,
    s: SpringGeometry<M::Pack>,
    pull: Pack3<M::Pack>,
    (x_sum, v_sum): (Pack3<M::Pack>, Pack3<M::Pack>),
    adjoint: &mut [Node<T>],
    g: &mut SpringGradient<T>,
) -> (Pack3<M::Pack>, Pack3<M::Pack>) {
    let inverse = s.length * s.inverse2;
    let (rate, dashpot) = (m.load(&b.rate), m.load(&b.dashpot));
    let stretch = s.length - m.load(&b.rest);
    let p = -(v3::dot(s.r, pull) * inverse);
    let q = v3::dot(s.r, s.w) * inverse;
    let force = dashpot.mul_add(q, rate * stretch) * inverse;
    let damped = dashpot * p;
    let turned = damped * inverse;
    let along = force.neg_mul_add(p, turned.neg_mul_add(q, rate * p)) * inverse;
    let x_bar = v3::sub_scaled(v3::add_scaled(v3::scale(s.r, along), turned, s.w), force, pull);
    let v_bar = v3::scale(s.r, turned);
    g.pull = m.store(m.load(&g.pull) + p);
    g.stretch = m.store(p.mul_add(stretch, m.load(&g.stretch)));
    g.dashpot = m.store(p.mul_add(q, m.load(&g.dashpot)));
    m.scatter_add_nodes(adjoint, &b.other, x_bar, v_bar);
    (v3::sub(x_sum, x_bar), v3::sub(v_sum, v_bar))
}

#[cfg(test)]
mod tests;
