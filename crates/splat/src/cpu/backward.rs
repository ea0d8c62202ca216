//! Adjoint of a tile, front to back as the image was made, with the same decisions.
//!
//! With q_i = d loss / d w_i, a Gaussian's weight at a pixel, and R_i = Σ_{j > i} w_j q_j, which is
//! the sum over all less what has come so far,
//! d loss / d alpha_i = T_i q_i - R_i / (1 - alpha_i).

use std::hint::black_box;

use super::{
    bins::{Bins, Tile},
    forward::{TileImage, Transmittance},
    pixels::{
        CHUNKS, Chunk, LANES, Plane, ROW, SIDE, Window, any_above, limited, opacities, total,
    },
    projection::{Splat, SplatBar},
};
use crate::{
    Camera, ImageBar,
    constants::{LEAST_ALPHA, LEAST_TRANSMITTANCE, MOST_ALPHA},
};

/// d loss / d pixels of a tile.
struct TileBar {
    color: [Plane; 3],
    alpha: Plane,
    depth_m: Plane,
}

impl TileBar {
    /// Zero beyond the image.
    fn of(tile: &Tile, camera: &Camera, bar: &ImageBar) -> Self {
        let zero = [[0.0; LANES]; CHUNKS];
        let mut own = Self { color: [zero; 3], alpha: zero, depth_m: zero };
        let [left, top] = tile.origin.map(|x| x as usize);
        let [width, height] = [camera.width as usize, camera.height as usize];
        for row in 0..SIDE.min(height - top) {
            for column in 0..SIDE.min(width - left) {
                let pixel = (top + row) * width + left + column;
                let (k, l) = (row * ROW + column / LANES, column % LANES);
                for c in 0..3 {
                    own.color[c][k][l] = bar.color[pixel][c];
                }
                own.alpha[k][l] = bar.alpha[pixel];
                own.depth_m[k][l] = bar.depth_m[pixel];
            }
        }
        own
    }

    /// Σ w q of each pixel over all its Gaussians.
    fn sums(&self, image: &TileImage) -> Plane {
        let mut sums = [[0.0; LANES]; CHUNKS];
        for k in 0..CHUNKS {
            for l in 0..LANES {
                let colors: f32 = (0..3).map(|c| self.color[c][k][l] * image.color[c][k][l]).sum();
                sums[k][l] = colors
                    + self.alpha[k][l] * image.alpha[k][l]
                    + self.depth_m[k][l] * image.depth_m[k][l];
            }
        }
        sums
    }
}

/// Sums over the pixels of a tile for one Gaussian, by lanes. With s = alpha d loss / d alpha:
/// s, s dx, s dy, s dx², s dx dy, s dy²; then weights times d loss / d red, green, blue, depth.
#[derive(Default)]
struct Moments([Chunk; 10]);

impl Moments {
    fn bar(&self, splat: &Splat) -> SplatBar {
        let [s, x, y, xx, xy, yy, red, green, blue, depth_m] = self.0.map(|m| total(&m));
        let [a, b, c] = splat.conic;
        SplatBar {
            center: [a * x + b * y, b * x + c * y],
            conic: [-0.5 * xx, -xy, -0.5 * yy],
            opacity: s / splat.opacity,
            color: [red, green, blue],
            depth_m,
        }
    }
}

/// d loss / d projected Gaussians of a tile, in the order of its intersections.
#[inline(always)]
pub(super) fn back_tile(
    bins: &Bins,
    tile: &Tile,
    camera: &Camera,
    image: &TileImage,
    bar: &ImageBar,
    out: &mut [SplatBar],
) {
    let bar = TileBar::of(tile, camera, bar);
    let mut rest = bar.sums(image);
    let mut transmittance = Transmittance::of(tile, camera);
    let origin = tile.origin.map(|x| x as f32);
    let entries = &bins.entries[tile.first as usize..tile.end as usize];
    for (count, (&entry, out)) in entries.iter().zip(out).enumerate() {
        if transmittance.is_closed(count) {
            break;
        }
        let splat = &bins.splats[entry as usize];
        let window = Window::of(splat, origin);
        let mut moments = Moments::default();
        for row in window.rows.clone() {
            let (from, end) = window.chunks(row);
            for half in from..end {
                let k = row * ROW + half;
                if !transmittance.is_open(k) {
                    continue;
                }
                let (dx, dy) = window.distances(row, half);
                let alphas = opacities(splat, &dx, dy);
                if any_above(&alphas, LEAST_ALPHA * 0.999) {
                    let left = &mut transmittance.plane[k];
                    back_chunk(
                        splat,
                        &alphas,
                        (&dx, dy),
                        left,
                        &mut rest[k],
                        &bar,
                        k,
                        &mut moments,
                    );
                }
            }
        }
        // Kept in memory while the pixels are added: otherwise the compiler takes the lanes apart for
        // the sums over them, at every pixel.
        *out = black_box(&mut moments).bar(splat);
    }
}

/// Adds a chunk of pixels to the moments of a Gaussian, and passes them.
#[inline(always)]
#[allow(clippy::too_many_arguments)] // A loop's body, which is inlined.
fn back_chunk(
    splat: &Splat,
    alphas: &Chunk,
    (dx, dy): (&Chunk, f32),
    left: &mut Chunk,
    rest: &mut Chunk,
    bar: &TileBar,
    k: usize,
    moments: &mut Moments,
) {
    let [red, green, blue] = [&bar.color[0][k], &bar.color[1][k], &bar.color[2][k]];
    let (coverage, depth) = (&bar.alpha[k], &bar.depth_m[k]);
    let m = &mut moments.0;
    for l in 0..LANES {
        let alpha = limited(alphas[l]);
        let clear = 1.0 - alpha;
        let next = left[l] * clear;
        let is_seen = alpha >= LEAST_ALPHA;
        let continues = next >= LEAST_TRANSMITTANCE;
        let weight = if is_seen & continues { alpha * left[l] } else { 0.0 };
        let q = red[l] * splat.color[0]
            + green[l] * splat.color[1]
            + blue[l] * splat.color[2]
            + (coverage[l] + depth[l] * splat.depth_m);
        rest[l] -= weight * q;
        let alpha_bar = left[l] * q - rest[l] / clear;
        let counts = is_seen & continues & (alphas[l] < MOST_ALPHA);
        let s = if counts { alpha_bar * alpha } else { 0.0 };
        let after = if continues { next } else { 0.0 };
        left[l] = if is_seen { after } else { left[l] };
        let (sx, sy) = (s * dx[l], s * dy);
        m[0][l] += s;
        m[1][l] += sx;
        m[2][l] += sy;
        m[3][l] += sx * dx[l];
        m[4][l] += sx * dy;
        m[5][l] += sy * dy;
        m[6][l] += weight * red[l];
        m[7][l] += weight * green[l];
        m[8][l] += weight * blue[l];
        m[9][l] += weight * depth[l];
    }
}
