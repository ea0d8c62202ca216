//! A tile of the image, front to back.

use super::{
    bins::{Bins, Tile},
    pixels::{CHUNKS, LANES, Plane, ROW, SIDE, Window, any_above, limited, opacities},
};
use crate::{
    Camera,
    constants::{LEAST_ALPHA, LEAST_TRANSMITTANCE},
};

/// Intersections between two checks for transparent pixels.
const LOOK_EVERY: usize = 16;

/// A tile of an image.
#[derive(Clone, Debug)]
pub(super) struct TileImage {
    /// Red, green, blue.
    pub(super) color: [Plane; 3],
    pub(super) alpha: Plane,
    pub(super) depth_m: Plane,
}

/// Transmittance of each pixel for the next Gaussian; zero once a pixel takes no more.
pub(super) struct Transmittance {
    pub(super) plane: Plane,
    /// Chunks with a pixel that takes more, as bits.
    open: u32,
}

impl Transmittance {
    /// Ones inside the image; a tile at its border extends beyond it.
    pub(super) fn of(tile: &Tile, camera: &Camera) -> Self {
        let mut plane = [[0.0; LANES]; CHUNKS];
        let columns = (camera.width - tile.origin[0]).min(SIDE as u32) as usize;
        let rows = (camera.height - tile.origin[1]).min(SIDE as u32) as usize;
        for row in 0..rows {
            for column in 0..columns {
                plane[row * ROW + column / LANES][column % LANES] = 1.0;
            }
        }
        let mut this = Self { plane, open: u32::MAX };
        this.look();
        this
    }

    /// Finds the chunks that take more.
    #[inline(always)]
    fn look(&mut self) {
        for (k, chunk) in self.plane.iter().enumerate() {
            if self.open & 1 << k != 0 && !any_above(chunk, 0.0) {
                self.open &= !(1 << k);
            }
        }
    }

    /// Looks from time to time; true if no pixel takes more.
    #[inline(always)]
    pub(super) fn is_closed(&mut self, intersections: usize) -> bool {
        if intersections.is_multiple_of(LOOK_EVERY) && intersections > 0 {
            self.look();
        }
        self.open == 0
    }

    #[inline(always)]
    pub(super) fn is_open(&self, chunk: usize) -> bool {
        self.open & 1 << chunk != 0
    }
}

/// Renders a tile.
#[inline(always)]
pub(super) fn render_tile(bins: &Bins, tile: &Tile, camera: &Camera) -> TileImage {
    let zero = [[0.0; LANES]; CHUNKS];
    let mut image = TileImage { color: [zero; 3], alpha: zero, depth_m: zero };
    let mut transmittance = Transmittance::of(tile, camera);
    let origin = tile.origin.map(|x| x as f32);
    for (count, &entry) in bins.entries[tile.first as usize..tile.end as usize].iter().enumerate() {
        if transmittance.is_closed(count) {
            break;
        }
        let splat = &bins.splats[entry as usize];
        let window = Window::of(splat, origin);
        for row in window.rows.clone() {
            let (from, end) = window.chunks(row);
            for half in from..end {
                let k = row * ROW + half;
                if !transmittance.is_open(k) {
                    continue;
                }
                let (dx, dy) = window.distances(row, half);
                let alphas = opacities(splat, &dx, dy);
                let left = &mut transmittance.plane[k];
                let mut weights = [0.0; LANES];
                for l in 0..LANES {
                    let alpha = limited(alphas[l]);
                    let next = left[l] * (1.0 - alpha);
                    let is_seen = alpha >= LEAST_ALPHA;
                    let continues = next >= LEAST_TRANSMITTANCE;
                    weights[l] = if is_seen & continues { alpha * left[l] } else { 0.0 };
                    let after = if continues { next } else { 0.0 };
                    left[l] = if is_seen { after } else { left[l] };
                }
                for l in 0..LANES {
                    image.color[0][k][l] += weights[l] * splat.color[0];
                    image.color[1][k][l] += weights[l] * splat.color[1];
                    image.color[2][k][l] += weights[l] * splat.color[2];
                    image.alpha[k][l] += weights[l];
                    image.depth_m[k][l] += weights[l] * splat.depth_m;
                }
            }
        }
    }
    image
}
