//! Arms of rods that end in a branch: the branch's direction holds the frame there, as a clamp
//! would.

use super::{Edges, Triple};
use crate::{
    constants::MIN_SINE_SQUARED,
    cpu::arithmetic::{Machine, Pack, Pack3, Real, v3},
};

/// A branch as seen from the rod's end.
///
/// With e the rod's last edge, g the branch's first, n = e x g: when g turns about e by an angle
/// and e by none, the rod is twisted by minus that angle, and when e turns, g is compared with what
/// parallel transport makes of it. So the derivative of the twist by the node before is
/// `a = -(e.g) n / (|e||n|²)`, by the branch's `c = -|e| n / |n|²`, and by the node where they meet
/// minus their sum.
#[derive(Clone, Copy)]
pub(super) struct Arm<P: Pack> {
    e: Pack3<P>,
    g: Pack3<P>,
    n: Pack3<P>,
    /// |e| and its inverse, e.g, 1/|n|²; inverses are zero where degenerate.
    length: P,
    inverse_length: P,
    overlap: P,
    inverse_square: P,
    pub(super) a: Pack3<P>,
    pub(super) c: Pack3<P>,
}

impl<P: Pack> Arm<P> {
    #[inline(always)]
    pub(super) fn new<T: Real, M: Machine<T, Pack = P>>(m: M, x: &Triple<P>) -> Self {
        let Edges { e, g, lengths: [e_length, g_length], is_armed } = Edges::new(m, x);
        let both = e_length * g_length;
        let n = v3::cross(e, g);
        let square = v3::dot(n, n);
        let least_square = both * both * m.splat(T::from_f64(MIN_SINE_SQUARED));
        let is_regular = is_armed & square.above(least_square);
        let one = m.splat(T::ONE);
        let inverse_square = (one / square.at_least(least_square)).only_if(is_regular);
        let inverse_length = (one / e_length).only_if(is_regular);
        let overlap = v3::dot(e, g);
        Self {
            a: v3::scale(n, -(overlap * inverse_length * inverse_square)),
            c: v3::scale(n, -(e_length * inverse_square)),
            e,
            g,
            n,
            length: e_length,
            inverse_length,
            overlap,
            inverse_square,
        }
    }

    /// Adjoint of (a, c): what it makes of the positions of the nodes before and after.
    #[inline(always)]
    pub(super) fn back(&self, bar: &Triple<P>) -> Triple<P> {
        // a = p n, c = q n with p = -(e.g) / (|e||n|²), q = -|e| / |n|²
        let (p_bar, q_bar) = (v3::dot(self.n, bar.before), v3::dot(self.n, bar.after));
        let by_length = self.inverse_length * self.inverse_square;
        let p = -(self.overlap * by_length);
        let q = -(self.length * self.inverse_square);
        let overlap_bar = -(p_bar * by_length);
        // By |e|, over |e|.
        let stretch = -((p_bar * p * self.inverse_length + q_bar * self.inverse_square)
            * self.inverse_length);
        let twice_square_bar = -(p_bar * p + q_bar * q) * self.inverse_square;
        let n_bar = v3::add_scaled(
            v3::add_scaled(v3::scale(bar.before, p), q, bar.after),
            twice_square_bar + twice_square_bar,
            self.n,
        );
        let e_bar = v3::add_scaled(
            v3::add_scaled(v3::cross(self.g, n_bar), overlap_bar, self.g),
            stretch,
            self.e,
        );
        let g_bar = v3::add_scaled(v3::cross(n_bar, self.e), overlap_bar, self.e);
        Triple { before: v3::neg(e_bar), after: g_bar }
    }
}
