//! Blocks of elements in structure-of-arrays form. Elements are read from and
//! added to the nodes one by one in a fixed order (so results repeat bit for
//! bit), the arithmetic between runs on whole lanes and is auto-vectorised.

use super::real::{Quad, Real};

/// Elements a block: two AVX2 registers of `f32`.
pub(crate) const LANES: usize = 16;

/// One number of each element of a block.
pub(crate) type Lane<T> = [T; LANES];

/// One vector of each element of a block, by coordinate.
pub(crate) type Lane3<T> = [Lane<T>; 3];

/// Endpoint of each element of a block.
pub(crate) type Index = [u32; LANES];

/// Position and velocity of an endpoint.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(C, align(32))]
pub(crate) struct Node<T> {
    /// Position [m].
    pub(crate) x: Quad<T>,
    /// Velocity [m/s].
    pub(crate) v: Quad<T>,
}

#[inline(always)]
pub(crate) fn zero3<T: Real>() -> Lane3<T> {
    [[T::ZERO; LANES]; 3]
}

/// Positions and velocities of `b` relative to `a`.
#[inline(always)]
pub(crate) fn relative<T: Real>(nodes: &[Node<T>], a: &Index, b: &Index) -> (Lane3<T>, Lane3<T>) {
    let (mut x, mut v) = (zero3(), zero3());
    for l in 0..LANES {
        let (a, b) = (&nodes[a[l] as usize], &nodes[b[l] as usize]);
        for c in 0..3 {
            x[c][l] = b.x[c] - a.x[c];
            v[c][l] = b.v[c] - a.v[c];
        }
    }
    (x, v)
}

/// Values of `b` relative to `a`.
#[inline(always)]
pub(crate) fn difference<T: Real>(values: &[Quad<T>], a: &Index, b: &Index) -> Lane3<T> {
    let mut d = zero3();
    for l in 0..LANES {
        let (a, b) = (&values[a[l] as usize], &values[b[l] as usize]);
        for c in 0..3 {
            d[c][l] = b[c] - a[c];
        }
    }
    d
}

#[inline(always)]
pub(crate) fn at<T: Real>(a: &Lane3<T>, l: usize) -> [T; 3] {
    [a[0][l], a[1][l], a[2][l]]
}

/// Three-vectors of one lane, kept apart from [`Quad`] so that no padding is computed.
pub(crate) mod v3 {
    use super::Real;

    #[inline(always)]
    pub(crate) fn dot<T: Real>(a: [T; 3], b: [T; 3]) -> T {
        a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
    }
    #[inline(always)]
    pub(crate) fn cross<T: Real>(a: [T; 3], b: [T; 3]) -> [T; 3] {
        [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
    }
    #[inline(always)]
    pub(crate) fn add<T: Real>(a: [T; 3], b: [T; 3]) -> [T; 3] {
        [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
    }
    #[inline(always)]
    pub(crate) fn scale<T: Real>(a: [T; 3], s: T) -> [T; 3] {
        [a[0] * s, a[1] * s, a[2] * s]
    }
    /// a + s b.
    #[inline(always)]
    pub(crate) fn add_scaled<T: Real>(a: [T; 3], s: T, b: [T; 3]) -> [T; 3] {
        [a[0] + s * b[0], a[1] + s * b[1], a[2] + s * b[2]]
    }
}
