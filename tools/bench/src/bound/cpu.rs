//! CPUs with AVX2: instructions of the units that do floating-point arithmetic, on 8 lanes. Loads,
//! stores and shuffles have other units and are not counted, so no real kernel reaches this bound.

use std::{hint::black_box, thread, time::Instant};

use pulp::{Arch, Simd, WithSimd};

use super::{Instructions, IssueBound};

/// Elements that a count below is of.
const LANES: usize = 8;

/// Eight springs, each once. A square root takes as long as 12 other instructions, a division as
/// 10.
///
/// 8 differences of (position, velocity), 3 for the squared length, 12 for its root, 10 for the
/// inverse, 4 comparisons and masks, 3 for the elastic force, 3 for w . r, 2 for the dashpot, 1
/// times the inverse, 3 products, 16 sums into the two ends: 65.
const SPRING: f64 = 65.0;

/// Eight springs of the adjoint.
///
/// 16 differences, length again 29, stretch 2, direction 3, p 3, q 3, force 2, damped 1, along 4,
/// r_bar 12, w_bar 3, 15 and 6 for the three parameter gradients, 16 sums into the two ends: 115.
const SPRING_ADJOINT: f64 = 115.0;

/// Eight triplets, each once.
///
/// 16 differences, 6 for the squares, 4 comparisons, 20 for their inverses, 6 for u x w, 3 for its
/// square, 3 for the cosine, 3 to detect collinear ones, 12 for the root, 18 for the two scaled
/// crosses, 10 for 1/m, 30 for the angle, 6 for the rate, 12 for the collinear case, 6 for the
/// magnitude, 6 products, 27 sums: 188.
const TRIPLET: f64 = 188.0;

/// Eight nodes, each in one 128-bit instruction per line: force into velocity, drag, height above
/// ground, whether it is reached, step.
const NODE: f64 = 8.0 * 8.0;

/// Eight nodes of the adjoint: each of those lines backward.
const NODE_ADJOINT: f64 = 8.0 * 10.0;

/// The bound of this machine with the given number of working threads; `None` without 8 lanes.
pub(super) fn bound(threads: usize) -> Option<IssueBound> {
    let per_second = rate(threads.max(1))?;
    let instructions = |spring, node| Instructions { spring, triplet: TRIPLET, node };
    Some(IssueBound {
        forward: instructions(SPRING, NODE),
        gradient: instructions(SPRING + SPRING_ADJOINT, NODE + NODE_ADJOINT),
        both_ends: false,
        lanes: LANES as f64,
        per_second,
        how: format!(
            "{threads} threads issue {per_second:.2e} fused multiply-adds on {LANES} lanes a second together, measured in this run; \
             every spring evaluated once, {SPRING} arithmetic instructions per {LANES} springs (a root counts \
             as 12, a division as 10), {TRIPLET} per {LANES} triplets, {NODE} per {LANES} nodes, loads, stores and \
             shuffles not counted; gradient: {SPRING_ADJOINT} more per {LANES} springs and {NODE_ADJOINT} per {LANES} \
             nodes, triplets not counted; every batch against the whole device"
        ),
    })
}

/// Arithmetic instructions on 8 lanes a second, on all threads together.
fn rate(threads: usize) -> Option<f64> {
    let measure = || Arch::new().dispatch(MultiplyAdds);
    thread::scope(|scope| {
        let running: Vec<_> = (0..threads).map(|_| scope.spawn(measure)).collect();
        running.into_iter().map(|t| t.join().ok().flatten()).sum()
    })
}

/// Runs independent multiply-adds and returns the number of instructions a second.
struct MultiplyAdds;

impl WithSimd for MultiplyAdds {
    type Output = Option<f64>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Option<f64> {
        /// Enough to cover the latency of two units.
        const CHAINS: usize = 12;
        const ROUNDS: usize = 4_000_000;
        if size_of::<S::f32s>() != LANES * size_of::<f32>() {
            return None;
        }
        let (a, b) = (simd.splat_f32s(black_box(0.999)), simd.splat_f32s(black_box(1e-3)));
        let mut sums = [simd.splat_f32s(1.0); CHAINS];
        let mut best = f64::INFINITY;
        for _ in 0..3 {
            let began = Instant::now();
            for _ in 0..ROUNDS {
                for s in &mut sums {
                    *s = simd.mul_add_e_f32s(*s, a, b);
                }
            }
            best = best.min(began.elapsed().as_secs_f64());
        }
        let total = sums.into_iter().fold(simd.splat_f32s(0.0), |t, s| simd.add_f32s(t, s));
        black_box(simd.reduce_sum_f32s(total));
        Some((CHAINS * ROUNDS) as f64 / best)
    }
}
