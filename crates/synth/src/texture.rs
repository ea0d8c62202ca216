//! Noise that depends on where one looks and on nothing else: colours that stick to a material, and
//! the randomness of sensors, the same for any order of reading frames.

use bendtwin_core::Point;

/// A number in 0..1 that looks random.
pub(super) fn chance(seed: u64, at: [i64; 4]) -> f32 {
    let mut x = at.iter().fold(seed ^ 0x9E37_79B9_7F4A_7C15, |h, a| {
        (h ^ *a as u64).wrapping_mul(0xBF58_476D_1CE4_E5B9).rotate_left(27)
    });
    x = (x ^ (x >> 31)).wrapping_mul(0x94D0_49BB_1331_11EB);
    ((x >> 40) as f32) / (1_u64 << 24) as f32
}

/// A number with mean 0 and deviation 1, nearly normal.
pub(super) fn normal(seed: u64, at: [i64; 4]) -> f32 {
    let four: f32 = (0..4).map(|k| chance(seed.wrapping_add(k * 7919), at)).sum();
    (four - 2.0) * 3.0_f32.sqrt()
}

/// Smooth noise in 0..1 over space: random values at the corners of cells of a size [m], blended
/// between.
pub(super) fn smooth(seed: u64, p: Point, cell_m: f32) -> f32 {
    let at = p.map(|x| x / cell_m);
    let low = at.map(f32::floor);
    let blend: Point = std::array::from_fn(|a| {
        let t = at[a] - low[a];
        t * t * (3.0 - 2.0 * t)
    });
    let corner = |k: usize| {
        let bit = |a: usize| (k >> a) & 1;
        let cell: [i64; 3] = std::array::from_fn(|a| low[a] as i64 + bit(a) as i64);
        let weight: f32 =
            (0..3).map(|a| if bit(a) == 1 { blend[a] } else { 1.0 - blend[a] }).product();
        weight * chance(seed, [cell[0], cell[1], cell[2], 0])
    };
    (0..8).map(corner).sum()
}

/// The colour of a material at a place of it, 0..=1: patches of a size [m] and finer ones.
pub(super) fn dye(seed: u64, p: Point, cell_m: f32, base: Point, contrast: f32) -> Point {
    std::array::from_fn(|channel| {
        let seed = seed.wrapping_add(channel as u64 * 104_729);
        let patches = 1.6 * smooth(seed, p, cell_m) + 0.8 * smooth(seed + 1, p, cell_m / 2.0) - 1.2;
        (base[channel] + contrast * patches).clamp(0.0, 1.0)
    })
}
