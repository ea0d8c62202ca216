//! Arithmetic of the pixels of a tile, in plain loops over chunks of lanes that the compiler makes
//! vector instructions of. Nothing is fused, so every processor gives the same bits.

use std::ops::RangeInclusive;

use super::projection::Splat;
use crate::constants::{MOST_ALPHA, TILE_PX};

/// Pixels of a chunk: neighbours of a row.
pub(super) const LANES: usize = 8;
/// Columns and rows of a tile.
pub(super) const SIDE: usize = TILE_PX as usize;
/// Chunks of a row of a tile.
pub(super) const ROW: usize = SIDE / LANES;
/// Chunks of a tile.
pub(super) const CHUNKS: usize = SIDE * ROW;

/// Values of the pixels of a chunk.
pub(super) type Chunk = [f32; LANES];
/// Values of the pixels of a tile, row by row.
pub(super) type Plane = [Chunk; CHUNKS];

/// exp(-x) for x >= 0, within 3e-7 of it relatively; beyond 87 some number below 1e-37.
///
/// 2^t = 2^n 2^f with n the nearest whole number of t, and a series for 2^f.
#[inline(always)]
pub(super) fn exp_minus(x: f32) -> f32 {
    const MAGIC: f32 = 12_582_912.0; // 1.5 * 2^23: adding it rounds to a whole number.
    let t = x * -std::f32::consts::LOG2_E;
    let t = if t > -125.0 { t } else { -125.0 };
    let shifted = t + MAGIC;
    let f = t - (shifted - MAGIC);
    let p = 1.540_353e-4;
    let p = p * f + 1.333_355_8e-3;
    let p = p * f + 9.618_129e-3;
    let p = p * f + 5.550_411e-2;
    let p = p * f + 2.402_265e-1;
    let p = p * f + std::f32::consts::LN_2;
    let p = p * f + 1.0;
    f32::from_bits(p.to_bits().wrapping_add(shifted.to_bits() << 23))
}

/// The part of a tile that a Gaussian can reach.
pub(super) struct Window {
    pub(super) rows: RangeInclusive<usize>,
    /// Centre from the first pixel of the tile [px].
    center: [f32; 2],
    /// Half the width of its ellipse in the row of the centre, the columns by which its middle
    /// moves from a row to the next, and the inverse of half its height.
    half_width: f32,
    slope: f32,
    inverse_reach: f32,
}

impl Window {
    #[inline(always)]
    pub(super) fn of(splat: &Splat, origin: [f32; 2]) -> Self {
        let last = (SIDE - 1) as f32;
        let center = [splat.center[0] - origin[0], splat.center[1] - origin[1]];
        let from = (center[1] - splat.reach).ceil().clamp(0.0, last) as usize;
        let to = (center[1] + splat.reach).floor().clamp(0.0, last) as usize;
        Self {
            rows: from..=to,
            center,
            half_width: splat.half_width,
            slope: splat.slope,
            inverse_reach: 1.0 / splat.reach,
        }
    }

    /// Chunks of a row that the ellipse reaches: the first, and the one after the last.
    #[inline(always)]
    pub(super) fn chunks(&self, row: usize) -> (usize, usize) {
        let dy = row as f32 - self.center[1];
        let share = dy * self.inverse_reach;
        let square = 1.0 - share * share;
        let half = self.half_width * (if square > 0.0 { square } else { 0.0 }).sqrt();
        let middle = self.center[0] + self.slope * dy;
        // A little more, for the rounding of the inverse.
        let (from, to) = (middle - half - 1e-3, middle + half + 1e-3);
        if to < 0.0 || from > (SIDE - 1) as f32 {
            return (0, 0);
        }
        let from = if from > 0.0 { from as usize / LANES } else { 0 };
        let to = if to < (SIDE - 1) as f32 { to as usize / LANES } else { ROW - 1 };
        (from, to + 1)
    }

    /// Distances of a chunk's pixels from the centre: columns, and rows [px].
    #[inline(always)]
    pub(super) fn distances(&self, row: usize, half: usize) -> (Chunk, f32) {
        let first = (half * LANES) as f32 - self.center[0];
        let dx = [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0].map(|l| first + l);
        (dx, row as f32 - self.center[1])
    }
}

/// Opacities of a Gaussian at the pixels of a chunk, before they are limited.
#[inline(always)]
pub(super) fn opacities(splat: &Splat, dx: &Chunk, dy: f32) -> Chunk {
    let [a, b, c] = splat.conic;
    let (half_a, by_dy, constant) = (0.5 * a, b * dy, 0.5 * c * dy * dy);
    let mut out = [0.0; LANES];
    for l in 0..LANES {
        let power = (half_a * dx[l] + by_dy) * dx[l] + constant;
        // Rounding can make it negative.
        let power = if power > 0.0 { power } else { 0.0 };
        out[l] = splat.opacity * exp_minus(power);
    }
    out
}

/// Opacity after the limit.
#[inline(always)]
pub(super) fn limited(alpha: f32) -> f32 {
    if alpha < MOST_ALPHA { alpha } else { MOST_ALPHA }
}

/// True if a value of the chunk is greater.
#[inline(always)]
pub(super) fn any_above(chunk: &Chunk, least: f32) -> bool {
    let mut most = [0.0_f32; LANES];
    for l in 0..LANES {
        most[l] = if chunk[l] > least { 1.0 } else { 0.0 };
    }
    total(&most) > 0.0
}

/// Sum over the lanes, in a fixed order.
#[inline(always)]
pub(super) fn total(c: &Chunk) -> f32 {
    let four = [c[0] + c[4], c[1] + c[5], c[2] + c[6], c[3] + c[7]];
    (four[0] + four[2]) + (four[1] + four[3])
}

#[cfg(test)]
mod tests;
