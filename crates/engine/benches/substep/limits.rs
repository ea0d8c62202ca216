//! Limits of one core, measured in the same run: fused multiply-adds a second
//! in single precision, and bytes a second read and written by a triad.

use std::hint::black_box;

use pulp::{Arch, Simd, WithSimd};

use super::clock::best_of;

/// Floating-point operations a second; a fused multiply-add counts as two.
pub(crate) fn fused_flops_per_s() -> f64 {
    let mut operations = 0.0;
    let seconds = best_of(3, || operations = Arch::new().dispatch(Fused));
    operations / seconds
}

/// Runs multiply-adds and returns the number of operations.
struct Fused;

impl WithSimd for Fused {
    type Output = f64;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> f64 {
        const CHAINS: usize = 12;
        const ROUNDS: usize = 40_000_000;
        let (a, b) = (simd.splat_f32s(black_box(0.999)), simd.splat_f32s(black_box(1e-3)));
        let mut sums = [simd.splat_f32s(1.0); CHAINS];
        for _ in 0..ROUNDS {
            for s in &mut sums {
                *s = simd.mul_add_e_f32s(*s, a, b);
            }
        }
        let lanes = size_of::<S::f32s>() / size_of::<f32>();
        let total = sums.into_iter().fold(simd.splat_f32s(0.0), |t, s| simd.add_f32s(t, s));
        black_box(simd.reduce_sum_f32s(total));
        (2 * lanes * CHAINS * ROUNDS) as f64
    }
}

/// Bandwidth of `a = b + s c` over arrays of `bytes` in total [bytes/s].
pub(crate) fn bytes_per_s(bytes: usize) -> f64 {
    let n = bytes / 12;
    let (mut a, b, c) = (vec![0.0_f32; n], vec![1.0_f32; n], vec![2.0_f32; n]);
    let repeats = (1 << 33) / bytes;
    let best = best_of(3, || {
        for _ in 0..repeats {
            Arch::new().dispatch(Triad { a: &mut a, b: &b, c: &c });
            black_box(&mut a);
        }
    });
    (repeats * n * 12) as f64 / best
}

struct Triad<'a> {
    a: &'a mut [f32],
    b: &'a [f32],
    c: &'a [f32],
}

impl WithSimd for Triad<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        for ((a, b), c) in self.a.iter_mut().zip(self.b).zip(self.c) {
            *a = b + 0.5 * c;
        }
    }
}
