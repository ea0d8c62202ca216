//! The order of nodes in memory: along a Morton (Z) curve, so that nodes that
//! are near in space, and therefore joined, are near in memory.

use bendtwin_core::Point;

const BITS: u32 = 21;

/// Indices of `points` in the order of their Morton codes (ties by index).
pub(super) fn along_curve(points: &[Point]) -> Vec<usize> {
    let mut low = [f32::INFINITY; 3];
    let mut high = [f32::NEG_INFINITY; 3];
    for p in points {
        for a in 0..3 {
            low[a] = low[a].min(p[a]);
            high[a] = high[a].max(p[a]);
        }
    }
    // One scale for all axes: cells are cubes.
    let extent = (0..3).map(|a| high[a] - low[a]).fold(0.0_f32, f32::max).max(f32::MIN_POSITIVE);
    let cells = ((1_u32 << BITS) - 1) as f32;
    let code = |p: &Point| {
        (0..3).fold(0_u64, |code, a| {
            let cell = ((p[a] - low[a]) / extent * cells) as u64;
            code | (spaced(cell) << a)
        })
    };
    let mut keyed: Vec<(u64, usize)> = points.iter().map(code).zip(0..).collect();
    keyed.sort_unstable();
    keyed.into_iter().map(|(_, i)| i).collect()
}

/// Puts two zero bits between the lowest 21 bits of `x`.
fn spaced(x: u64) -> u64 {
    let mut x = x & ((1 << BITS) - 1);
    x = (x | (x << 32)) & 0x001f_0000_0000_ffff;
    x = (x | (x << 16)) & 0x001f_0000_ff00_00ff;
    x = (x | (x << 8)) & 0x100f_00f0_0f00_f00f;
    x = (x | (x << 4)) & 0x10c3_0c30_c30c_30c3;
    (x | (x << 2)) & 0x1249_2492_4924_9249
}
