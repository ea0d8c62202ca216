//! Interface of the kernels to an instruction set: arithmetic on [`LANES`] numbers per operation,
//! and transposition between endpoints' records in memory and coordinates in lanes. A kernel is
//! written once over this; [`Portable`] runs it in any scalar, [`Avx2`] in `f32` with hand-placed
//! shuffles.

#[cfg(target_arch = "x86_64")]
mod avx2;
mod portable;
#[cfg(test)]
mod tests;

use std::ops::{Add, BitAnd, BitOr, Div, Mul, Neg, Not, Sub};

#[cfg(target_arch = "x86_64")]
pub(crate) use self::avx2::Avx2;
pub(crate) use self::portable::Portable;
use super::{
    lanes::{Index, Lane, Node},
    real::Quad,
};

/// A number per lane.
pub(crate) trait Pack:
    Copy
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
{
    /// A truth value per lane.
    type Mask: Copy
        + BitAnd<Output = Self::Mask>
        + BitOr<Output = Self::Mask>
        + Not<Output = Self::Mask>;

    /// self * b + c, rounded once where the machine can.
    fn mul_add(self, b: Self, c: Self) -> Self;
    /// c - self * b, rounded once where the machine can.
    fn neg_mul_add(self, b: Self, c: Self) -> Self;
    /// Square root.
    fn sqrt(self) -> Self;
    /// Magnitude.
    fn abs(self) -> Self;
    /// The larger one; `other` if `self` is NaN.
    fn at_least(self, other: Self) -> Self;
    /// The smaller one; `other` if `self` is NaN.
    fn at_most(self, other: Self) -> Self;
    /// self > other.
    fn above(self, other: Self) -> Self::Mask;
    /// self >= other.
    fn not_below(self, other: Self) -> Self::Mask;
    /// `self` where the condition holds, else `other`.
    fn or(self, condition: Self::Mask, other: Self) -> Self;
    /// `self` where the condition holds, else zero.
    fn only_if(self, condition: Self::Mask) -> Self;
}

/// A vector per lane, by coordinate.
pub(crate) type Pack3<P> = [P; 3];

/// An instruction set at work in one scalar.
pub(crate) trait Machine<T>: Copy {
    /// Packed numbers.
    type Pack: Pack;

    /// The same number in every lane.
    fn splat(self, x: T) -> Self::Pack;
    /// A lane each from memory.
    fn load(self, from: &Lane<T>) -> Self::Pack;
    /// A lane each to memory.
    fn store(self, pack: Self::Pack) -> Lane<T>;
    /// True if the condition holds in any lane.
    fn any(self, condition: <Self::Pack as Pack>::Mask) -> bool;
    /// Positions and velocities of endpoints.
    fn gather(self, nodes: &[Node<T>], index: &Index) -> (Pack3<Self::Pack>, Pack3<Self::Pack>);
    /// Values at endpoints.
    fn gather_quads(self, quads: &[Quad<T>], index: &Index) -> Pack3<Self::Pack>;
    /// Adds a vector a lane to quads, lane by lane, so that an index may stand there twice.
    fn scatter_add(self, quads: &mut [Quad<T>], index: &Index, by: Pack3<Self::Pack>);
    /// Adds two vectors a lane to nodes, lane by lane.
    fn scatter_add_nodes(
        self,
        nodes: &mut [Node<T>],
        index: &Index,
        x: Pack3<Self::Pack>,
        v: Pack3<Self::Pack>,
    );
}

/// Something to run on a machine.
pub(crate) trait Work<T> {
    /// Result of the work.
    type Output;

    /// Does it; always inlined, so that it is compiled for the machine's instructions.
    fn run<M: Machine<T>>(self, machine: M) -> Self::Output;
}

/// Three-vectors of packs.
pub(crate) mod v3 {
    use super::{Pack, Pack3};

    #[inline(always)]
    pub(crate) fn dot<P: Pack>(a: Pack3<P>, b: Pack3<P>) -> P {
        a[2].mul_add(b[2], a[1].mul_add(b[1], a[0] * b[0]))
    }
    #[inline(always)]
    pub(crate) fn cross<P: Pack>(a: Pack3<P>, b: Pack3<P>) -> Pack3<P> {
        [
            a[2].neg_mul_add(b[1], a[1] * b[2]),
            a[0].neg_mul_add(b[2], a[2] * b[0]),
            a[1].neg_mul_add(b[0], a[0] * b[1]),
        ]
    }
    #[inline(always)]
    pub(crate) fn add<P: Pack>(a: Pack3<P>, b: Pack3<P>) -> Pack3<P> {
        [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
    }
    #[inline(always)]
    pub(crate) fn sub<P: Pack>(a: Pack3<P>, b: Pack3<P>) -> Pack3<P> {
        [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
    }
    #[inline(always)]
    pub(crate) fn neg<P: Pack>(a: Pack3<P>) -> Pack3<P> {
        [-a[0], -a[1], -a[2]]
    }
    #[inline(always)]
    pub(crate) fn scale<P: Pack>(a: Pack3<P>, s: P) -> Pack3<P> {
        [a[0] * s, a[1] * s, a[2] * s]
    }
    /// a + s b.
    #[inline(always)]
    pub(crate) fn add_scaled<P: Pack>(a: Pack3<P>, s: P, b: Pack3<P>) -> Pack3<P> {
        [s.mul_add(b[0], a[0]), s.mul_add(b[1], a[1]), s.mul_add(b[2], a[2])]
    }
    /// a - s b.
    #[inline(always)]
    pub(crate) fn sub_scaled<P: Pack>(a: Pack3<P>, s: P, b: Pack3<P>) -> Pack3<P> {
        [s.neg_mul_add(b[0], a[0]), s.neg_mul_add(b[1], a[1]), s.neg_mul_add(b[2], a[2])]
    }
    #[inline(always)]
    pub(crate) fn only_if<P: Pack>(a: Pack3<P>, condition: P::Mask) -> Pack3<P> {
        [a[0].only_if(condition), a[1].only_if(condition), a[2].only_if(condition)]
    }
}
