//! What one core can do, measured in the same run: fused multiply-adds a second
//! in single precision, and bytes a second read and written by a triad.

use std::{hint::black_box, time::Instant};

use pulp::{Arch, Simd, WithSimd};

/// Floating-point operations a second; a fused multiply-add counts as two.
pub(crate) fn fused_flops_per_s() -> f64 {
    (0..5).map(|_| Arch::new().dispatch(Fused)).fold(0.0, f64::max)
}

struct Fused;

impl WithSimd for Fused {
    type Output = f64;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> f64 {
        const CHAINS: usize = 12;
        const ROUNDS: usize = 2_000_000;
        let (a, b) = (simd.splat_f32s(black_box(0.999)), simd.splat_f32s(black_box(1e-3)));
        let mut sums = [simd.splat_f32s(1.0); CHAINS];
        let start = Instant::now();
        for _ in 0..ROUNDS {
            for s in &mut sums {
                *s = simd.mul_add_e_f32s(*s, a, b);
            }
        }
        let seconds = start.elapsed().as_secs_f64();
        let lanes = size_of::<S::f32s>() / size_of::<f32>();
        let total = sums.into_iter().fold(simd.splat_f32s(0.0), |t, s| simd.add_f32s(t, s));
        black_box(simd.reduce_sum_f32s(total));
        (2 * lanes * CHAINS * ROUNDS) as f64 / seconds
    }
}

/// Bytes a second of `a = b + s c` over arrays of so many bytes together.
pub(crate) fn bytes_per_s(bytes: usize) -> f64 {
    let n = bytes / 12;
    let (mut a, b, c) = (vec![0.0_f32; n], vec![1.0_f32; n], vec![2.0_f32; n]);
    let repeats = (1 << 28) / bytes;
    let mut best = f64::INFINITY;
    for _ in 0..5 {
        let start = Instant::now();
        for _ in 0..repeats {
            Arch::new().dispatch(Triad { a: &mut a, b: &b, c: &c });
            black_box(&mut a);
        }
        best = best.min(start.elapsed().as_secs_f64());
    }
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
