//! Axial springs with dashpots, and the adjoint of their forces.
//!
//! With r = xj - xi, l = |r|, d = r / l and q = (vj - vi) . d:
//! `f_i = [k (l/l0 - 1) + gamma q] d`, `f_j = -f_i`.

use super::{
    lanes::{self, Index, LANES, Lane, Node, v3},
    real::{Quad, Real},
};

/// Below this length [m] a spring has no direction and exerts no force.
const MIN_LENGTH_M: f64 = 1e-12;

/// [`LANES`] springs; a spring that only fills up the last block joins an
/// endpoint with itself and has no stiffness.
#[derive(Clone, Debug)]
pub(crate) struct SpringBlock<T> {
    pub(crate) first: Index,
    pub(crate) second: Index,
    /// k / l0 [N/m]; zero where l0 is zero: strain is undefined there, the dashpot remains.
    pub(crate) rate: Lane<T>,
    /// l0 [m].
    pub(crate) rest: Lane<T>,
    /// gamma [N s/m].
    pub(crate) dashpot: Lane<T>,
}

impl<T: Real> SpringBlock<T> {
    pub(crate) const EMPTY: Self = Self {
        first: [0; LANES],
        second: [0; LANES],
        rate: [T::ZERO; LANES],
        rest: [T::ZERO; LANES],
        dashpot: [T::ZERO; LANES],
    };
}

/// d loss / d (k, gamma, l0) of a block.
#[derive(Clone, Debug)]
pub(crate) struct SpringGradient<T> {
    pub(crate) stiffness: Lane<T>,
    pub(crate) dashpot: Lane<T>,
    pub(crate) rest: Lane<T>,
}

impl<T: Real> SpringGradient<T> {
    pub(crate) const ZERO: Self =
        Self { stiffness: [T::ZERO; LANES], dashpot: [T::ZERO; LANES], rest: [T::ZERO; LANES] };
}

/// Length and its inverse; the inverse of (almost) nothing is zero.
#[inline(always)]
fn length<T: Real>(r: [T; 3]) -> (T, T) {
    let square = v3::dot(r, r);
    let valid = square > T::from_f64(MIN_LENGTH_M * MIN_LENGTH_M);
    let length = square.sqrt();
    let inverse = T::ONE / if valid { length } else { T::ONE };
    (length.only_if(valid), inverse.only_if(valid))
}

/// Adds every spring's force to both of its endpoints.
#[inline(always)]
pub(crate) fn spring_forces<T: Real>(
    blocks: &[SpringBlock<T>],
    nodes: &[Node<T>],
    forces: &mut [Quad<T>],
) {
    for b in blocks {
        let (r, w) = lanes::relative(nodes, &b.first, &b.second);
        let mut f = lanes::zero3();
        for l in 0..LANES {
            let (r, w) = (lanes::at(&r, l), lanes::at(&w, l));
            let (length, inverse) = length(r);
            let elastic = b.rate[l] * (length - b.rest[l]).only_if(inverse > T::ZERO);
            let magnitude = (elastic + b.dashpot[l] * v3::dot(w, r) * inverse) * inverse;
            for c in 0..3 {
                f[c][l] = magnitude * r[c];
            }
        }
        for l in 0..LANES {
            let (i, j) = (b.first[l] as usize, b.second[l] as usize);
            for c in 0..3 {
                forces[i][c] += f[c][l];
            }
            for c in 0..3 {
                forces[j][c] -= f[c][l];
            }
        }
    }
}

/// Adjoint of [`spring_forces`]: given d loss / d force in `lambda`, adds d loss / d (position,
/// velocity) to `adjoint` and d loss / d parameters to `gradients`.
///
/// With p = d . (lambda_i - lambda_j) and F the bracket above: `r_bar = k/l0 p d + gamma p (w - q d)/l
/// + F (lambda - p d)/l`, `w_bar = gamma p d`, both with opposite signs at the two ends.
#[inline(always)]
pub(crate) fn spring_adjoint<T: Real>(
    blocks: &[SpringBlock<T>],
    nodes: &[Node<T>],
    lambda: &[Quad<T>],
    adjoint: &mut [Node<T>],
    gradients: &mut [SpringGradient<T>],
) {
    for (b, g) in blocks.iter().zip(gradients) {
        let (r, w) = lanes::relative(nodes, &b.first, &b.second);
        let pull = lanes::difference(lambda, &b.second, &b.first);
        let (mut r_bar, mut w_bar) = (lanes::zero3(), lanes::zero3());
        for l in 0..LANES {
            let (r, w, pull) = (lanes::at(&r, l), lanes::at(&w, l), lanes::at(&pull, l));
            let (length, inverse) = length(r);
            let stretch = (length - b.rest[l]).only_if(inverse > T::ZERO);
            let d = v3::scale(r, inverse);
            let p = v3::dot(d, pull);
            let q = v3::dot(d, w);
            let force = b.rate[l] * stretch + b.dashpot[l] * q;
            let damped = b.dashpot[l] * p;
            let along = b.rate[l] * p - (damped * q + force * p) * inverse;
            for c in 0..3 {
                r_bar[c][l] = along * d[c] + (damped * w[c] + force * pull[c]) * inverse;
                w_bar[c][l] = damped * d[c];
            }
            let rest = b.rest[l];
            let has_rest = rest > T::ZERO;
            let per_rest = (p / if has_rest { rest } else { T::ONE }).only_if(has_rest);
            g.stiffness[l] += stretch * per_rest;
            g.dashpot[l] += q * p;
            g.rest[l] -= b.rate[l] * length * per_rest;
        }
        for l in 0..LANES {
            let (i, j) = (b.first[l] as usize, b.second[l] as usize);
            for c in 0..3 {
                adjoint[i].x[c] -= r_bar[c][l];
                adjoint[i].v[c] -= w_bar[c][l];
            }
            for c in 0..3 {
                adjoint[j].x[c] += r_bar[c][l];
                adjoint[j].v[c] += w_bar[c][l];
            }
        }
    }
}

#[cfg(test)]
mod tests;
