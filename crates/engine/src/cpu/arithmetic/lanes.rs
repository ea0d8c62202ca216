//! Blocks of elements in structure-of-arrays form, and the record of an endpoint.

use super::real::Quad;

/// Elements a block: one AVX2 register of `f32`.
pub(crate) const LANES: usize = 8;

/// A number of each element of a block.
pub(crate) type Lane<T> = [T; LANES];

/// Endpoint of each element of a block.
pub(crate) type Index = [u32; LANES];

/// The first endpoints of a slice.
pub(crate) const FIRST: Index = [0, 1, 2, 3, 4, 5, 6, 7];

/// Position and velocity of an endpoint.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(C, align(32))]
pub(crate) struct Node<T> {
    /// Position [m].
    pub(crate) x: Quad<T>,
    /// Velocity [m/s].
    pub(crate) v: Quad<T>,
}
