//! The scalar of a simulation: `f32` runs, `f64` is the reference. Also the
//! three-vectors (padded to four for alignment) that the scalar code paths use.

use std::{
    fmt::Debug,
    ops::{Add, AddAssign, Div, Mul, Neg, Sub, SubAssign},
};

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
    /// atan2(y, x) for y >= 0: the angle in [0, pi] between the positive x axis
    /// and (x, y). Zero at the origin.
    fn angle(y: Self, x: Self) -> Self;
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
    fn angle(y: Self, x: Self) -> Self {
        y.atan2(x)
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
    /// Branch-free, so that it vectorises: the ratio is brought into
    /// [0, tan(pi/8)] and a polynomial (Cephes' `atanf`) does the rest; within
    /// 3e-7 of the exact angle.
    #[inline(always)]
    fn angle(y: Self, x: Self) -> Self {
        use std::f32::consts::{FRAC_PI_2, FRAC_PI_4, PI};
        const TAN_PI_8: f32 = 0.414_213_57;
        let magnitude = x.abs();
        let low = y.at_most(magnitude);
        let high = y.at_least(magnitude);
        let upper = low > TAN_PI_8 * high;
        let numerator = if upper { low - high } else { low };
        let denominator = if upper { low + high } else { high };
        let safe = if denominator > 0.0 { denominator } else { 1.0 };
        let t = numerator / safe;
        let z = t * t;
        let series =
            ((8.053_744_5e-2 * z - 1.387_768_6e-1) * z + 1.997_771_1e-1) * z - 3.333_295e-1;
        let mut angle = series * z * t + t;
        angle += if upper { FRAC_PI_4 } else { 0.0 };
        angle = if y > magnitude { FRAC_PI_2 - angle } else { angle };
        if x < 0.0 { PI - angle } else { angle }
    }
    #[inline(always)]
    fn is_finite(self) -> bool {
        f32::is_finite(self)
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fast_angle_is_accurate_everywhere() {
        for i in 0..=20_000 {
            let theta = f64::from(i) / 20_000.0 * std::f64::consts::PI;
            for r in [1e-12, 1.0, 1e6] {
                let (y, x) = ((r * theta.sin()).max(0.0) as f32, (r * theta.cos()) as f32);
                let exact = f64::from(y).atan2(f64::from(x));
                assert!((f64::from(f32::angle(y, x)) - exact).abs() < 3e-7, "{theta}");
            }
        }
        assert_eq!(f32::angle(0.0, 0.0), 0.0);
    }
}
