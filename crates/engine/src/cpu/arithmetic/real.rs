//! The scalar of a simulation: `f32` runs, `f64` is the reference. Also the
//! three-vectors (padded to four for alignment) that the scalar code paths use.

use std::{
    fmt::Debug,
    marker::PhantomData,
    ops::{Add, AddAssign, Div, Mul, Neg, Sub, SubAssign},
};

use pulp::{Arch, Simd, WithSimd};

#[cfg(target_arch = "x86_64")]
use super::machine::Avx2;
use super::machine::{Machine, Pack, Portable, Work};

/// A vector x, y, z and an unused fourth lane that stays zero.
pub(crate) type Quad<T> = [T; 4];

/// Floating-point scalar. Everything is always inlined, so that code built on
/// it is vectorised for the instruction set of the function it ends up in.
pub(crate) trait Real:
    Copy
    + Debug
    + Default
    + PartialOrd
    + Send
    + Sync
    + 'static
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + AddAssign
    + SubAssign
{
    /// 0.
    const ZERO: Self;
    /// 1.
    const ONE: Self;

    /// Nearest value.
    fn from_f64(x: f64) -> Self;
    /// Exact for both scalars.
    fn to_f64(self) -> f64;
    /// Square root.
    fn sqrt(self) -> Self;
    /// Magnitude.
    fn abs(self) -> Self;
    /// atan2(y, x) for y >= 0, a lane each: the angle in [0, pi] between the positive x axis
    /// and (x, y). Zero at the origin.
    fn angle<M: Machine<Self>>(m: M, y: M::Pack, x: M::Pack) -> M::Pack;
    /// Runs a piece of work on the best machine that this processor is.
    fn dispatch<W: Work<Self>>(work: W) -> W::Output;
    /// Neither infinite nor NaN.
    fn is_finite(self) -> bool;

    /// Nearest value.
    #[inline(always)]
    fn from_f32(x: f32) -> Self {
        Self::from_f64(f64::from(x))
    }
    /// The larger one; `other` if `self` is NaN.
    #[inline(always)]
    fn at_least(self, other: Self) -> Self {
        if self > other { self } else { other }
    }
    /// The smaller one; `other` if `self` is NaN.
    #[inline(always)]
    fn at_most(self, other: Self) -> Self {
        if self < other { self } else { other }
    }
    /// `self` where the condition holds, else zero.
    #[inline(always)]
    fn only_if(self, condition: bool) -> Self {
        if condition { self } else { Self::ZERO }
    }
}

impl Real for f64 {
    const ZERO: Self = 0.0;
    const ONE: Self = 1.0;

    #[inline(always)]
    fn from_f64(x: f64) -> Self {
        x
    }
    #[inline(always)]
    fn to_f64(self) -> f64 {
        self
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        f64::sqrt(self)
    }
    #[inline(always)]
    fn abs(self) -> Self {
        f64::abs(self)
    }
    #[inline(always)]
    fn angle<M: Machine<Self>>(m: M, y: M::Pack, x: M::Pack) -> M::Pack {
        let (y, x) = (m.store(y), m.store(x));
        m.load(&std::array::from_fn(|l| y[l].atan2(x[l])))
    }
    fn dispatch<W: Work<Self>>(work: W) -> W::Output {
        Arch::new().dispatch(OnPortable(work, PhantomData::<Self>))
    }
    #[inline(always)]
    fn is_finite(self) -> bool {
        f64::is_finite(self)
    }
}

impl Real for f32 {
    const ZERO: Self = 0.0;
    const ONE: Self = 1.0;

    #[inline(always)]
    #[allow(clippy::cast_possible_truncation)]
    fn from_f64(x: f64) -> Self {
        x as f32
    }
    #[inline(always)]
    fn to_f64(self) -> f64 {
        f64::from(self)
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        f32::sqrt(self)
    }
    #[inline(always)]
    fn abs(self) -> Self {
        f32::abs(self)
    }
    /// The ratio is brought into [0, tan(pi/8)] and a polynomial (Cephes' `atanf`) does the
    /// rest; within 3e-7 of the exact angle.
    #[inline(always)]
    fn angle<M: Machine<Self>>(m: M, y: M::Pack, x: M::Pack) -> M::Pack {
        use std::f32::consts::{FRAC_PI_2, FRAC_PI_4, PI};
        const TAN_PI_8: f32 = 0.414_213_57;
        let magnitude = x.abs();
        let low = y.at_most(magnitude);
        let high = y.at_least(magnitude);
        let upper = low.above(m.splat(TAN_PI_8) * high);
        let numerator = (low - high).or(upper, low);
        let denominator = (low + high).or(upper, high);
        let t = numerator / denominator.at_least(m.splat(Self::MIN_POSITIVE));
        let z = t * t;
        let series = m.splat(8.053_744_5e-2).mul_add(z, m.splat(-1.387_768_6e-1));
        let series = series.mul_add(z, m.splat(1.997_771_1e-1));
        let series = series.mul_add(z, m.splat(-3.333_295e-1));
        let angle = (series * z).mul_add(t, t) + m.splat(FRAC_PI_4).only_if(upper);
        let angle = (m.splat(FRAC_PI_2) - angle).or(y.above(magnitude), angle);
        (m.splat(PI) - angle).or(m.splat(0.0).above(x), angle)
    }
    fn dispatch<W: Work<Self>>(work: W) -> W::Output {
        // Not pulp's dispatch on x86-64: it would compile the portable code for AVX2 too, which a
        // processor with AVX2 never runs here.
        #[cfg(target_arch = "x86_64")]
        match pulp::x86::V3::try_new() {
            Some(v3) => Simd::vectorize(v3, OnAvx2(work, Avx2::new(v3))),
            None => work.run(Portable),
        }
        #[cfg(not(target_arch = "x86_64"))]
        Arch::new().dispatch(OnPortable(work, PhantomData::<Self>))
    }
    #[inline(always)]
    fn is_finite(self) -> bool {
        f32::is_finite(self)
    }
}

/// Work compiled for the instructions of the processor, in plain loops.
struct OnPortable<W, T>(W, PhantomData<T>);

impl<T: Real, W: Work<T>> WithSimd for OnPortable<W, T> {
    type Output = W::Output;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> W::Output {
        self.0.run(Portable)
    }
}

/// Work compiled for AVX2.
#[cfg(target_arch = "x86_64")]
struct OnAvx2<W>(W, Avx2);

#[cfg(target_arch = "x86_64")]
impl<W: Work<f32>> WithSimd for OnAvx2<W> {
    type Output = W::Output;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> W::Output {
        self.0.run(self.1)
    }
}

/// A client's point in the simulation's scalar.
#[inline(always)]
pub(crate) fn quad<T: Real>(p: [f32; 3]) -> Quad<T> {
    [T::from_f32(p[0]), T::from_f32(p[1]), T::from_f32(p[2]), T::ZERO]
}

#[inline(always)]
pub(crate) fn dot<T: Real>(a: Quad<T>, b: Quad<T>) -> T {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Coordinate by coordinate.
#[inline(always)]
pub(crate) fn product<T: Real>(a: Quad<T>, b: Quad<T>) -> Quad<T> {
    [a[0] * b[0], a[1] * b[1], a[2] * b[2], a[3] * b[3]]
}

#[inline(always)]
pub(crate) fn add<T: Real>(a: Quad<T>, b: Quad<T>) -> Quad<T> {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2], a[3] + b[3]]
}

#[inline(always)]
pub(crate) fn sub<T: Real>(a: Quad<T>, b: Quad<T>) -> Quad<T> {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2], a[3] - b[3]]
}

#[inline(always)]
pub(crate) fn scale<T: Real>(a: Quad<T>, s: T) -> Quad<T> {
    [a[0] * s, a[1] * s, a[2] * s, a[3] * s]
}

/// a + s b.
#[inline(always)]
pub(crate) fn add_scaled<T: Real>(a: Quad<T>, s: T, b: Quad<T>) -> Quad<T> {
    add(a, scale(b, s))
}
