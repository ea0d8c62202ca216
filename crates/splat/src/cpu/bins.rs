//! Projected Gaussians in the order of their depths, and the list of those that touch each tile.

use rayon::prelude::*;

use super::projection::{Splat, project};
use crate::{
    Camera, Error, Gaussians,
    constants::{MOST_INTERSECTIONS, TILE_PX},
};

/// Gaussians that a thread projects at a time.
const PIECE: usize = 256;

/// A tile that Gaussians touch.
#[derive(Clone, Copy, Debug)]
pub(super) struct Tile {
    /// First column and row [px].
    pub(super) origin: [u32; 2],
    /// Its first intersection, and the first of the next tile.
    pub(super) first: u32,
    pub(super) end: u32,
}

/// What a camera sees of Gaussians. S is the number of Gaussians in view, K that of intersections:
/// pairs of a Gaussian and a tile that it touches.
#[derive(Debug, Default)]
pub(super) struct Bins {
    /// Projected Gaussians, nearest first, ties by index, shape [S].
    pub(super) splats: Vec<Splat>,
    /// Index of each in the set, shape [S].
    pub(super) indices: Vec<u32>,
    /// Tiles with intersections, row-major.
    pub(super) tiles: Vec<Tile>,
    /// Place in `splats` of each intersection, by tiles and then by depth, shape [K].
    pub(super) entries: Vec<u32>,
    /// First of each projected Gaussian's `places`, and the end of the last, shape [S + 1].
    pub(super) starts: Vec<u32>,
    /// Intersections of each projected Gaussian, in the order of tiles, shape [K].
    pub(super) places: Vec<u32>,
}

impl Bins {
    pub(super) fn new(gaussians: &Gaussians, camera: &Camera) -> Result<Self, Error> {
        let found: Vec<(u32, Splat)> = (0..gaussians.len())
            .into_par_iter()
            .with_min_len(PIECE)
            .filter_map(|i| Some((i as u32, project(gaussians, i, camera)?)))
            .collect();
        // Depths are positive, so their bits have their order.
        let mut order: Vec<u64> = found
            .iter()
            .enumerate()
            .map(|(k, (_, splat))| u64::from(splat.depth_m.to_bits()) << 32 | k as u64)
            .collect();
        order.par_sort_unstable();
        let sorted = order.iter().map(|key| &found[(key & 0xffff_ffff) as usize]);
        let (indices, splats): (Vec<u32>, Vec<Splat>) = sorted.copied().unzip();

        let grid = Grid::of(camera);
        let counts: Vec<usize> = splats
            .par_iter()
            .with_min_len(PIECE)
            .map(|s| grid.rows(s).map(|(_, [first, end])| (end - first) as usize).sum())
            .collect();
        let count: usize = counts.iter().sum();
        if count > MOST_INTERSECTIONS {
            let what = "intersections of Gaussians and tiles";
            return Err(Error::TooMany { what, count, most: MOST_INTERSECTIONS });
        }
        let mut bins = Self { splats, indices, ..Self::default() };
        bins.fill(&grid, &counts, count);
        Ok(bins)
    }

    /// Sorts intersections by tiles, by counting.
    fn fill(&mut self, grid: &Grid, counts: &[usize], count: usize) {
        let mut next = vec![0_u32; grid.columns as usize * grid.rows as usize];
        let of_row = |row: u32, [first, end]: [u32; 2]| {
            (row * grid.columns + first) as usize..(row * grid.columns + end) as usize
        };
        for splat in &self.splats {
            for (row, columns) in grid.rows(splat) {
                next[of_row(row, columns)].iter_mut().for_each(|n| *n += 1);
            }
        }
        let mut first = 0;
        for (t, n) in next.iter_mut().enumerate() {
            let end = first + *n;
            if *n > 0 {
                let (row, column) = (t as u32 / grid.columns, t as u32 % grid.columns);
                self.tiles.push(Tile { origin: [column * TILE_PX, row * TILE_PX], first, end });
            }
            *n = first;
            first = end;
        }
        self.entries = vec![0; count];
        self.places = Vec::with_capacity(count);
        self.starts = Vec::with_capacity(counts.len() + 1);
        self.starts.push(0);
        for (s, splat) in self.splats.iter().enumerate() {
            for (row, columns) in grid.rows(splat) {
                for n in &mut next[of_row(row, columns)] {
                    self.entries[*n as usize] = s as u32;
                    self.places.push(*n);
                    *n += 1;
                }
            }
            self.starts.push(self.places.len() as u32);
        }
    }

    /// Intersections of a projected Gaussian, in the order of tiles.
    pub(super) fn places_of(&self, splat: usize) -> &[u32] {
        &self.places[self.starts[splat] as usize..self.starts[splat + 1] as usize]
    }
}

/// The tiles of an image.
struct Grid {
    /// Numbers of tiles.
    columns: u32,
    rows: u32,
    /// Last column and row of the image [px].
    last: [f32; 2],
}

impl Grid {
    fn of(camera: &Camera) -> Self {
        Self {
            columns: camera.width.div_ceil(TILE_PX),
            rows: camera.height.div_ceil(TILE_PX),
            last: [camera.width, camera.height].map(|n| (n - 1) as f32),
        }
    }

    /// Rows of tiles that an ellipse touches, each with its first column of tiles and the one after
    /// the last.
    fn rows(&self, splat: &Splat) -> impl Iterator<Item = (u32, [u32; 2])> + use<> {
        let s = *splat;
        let last = self.last;
        let [u, v] = s.center;
        let pixels = whole(v - s.reach[1], v + s.reach[1], last[1]);
        let tiles = pixels.map_or(0..0, |[a, b]| a / TILE_PX..b / TILE_PX + 1);
        tiles.filter_map(move |row| {
            let [top, bottom] = pixels?;
            // Rows of the strip, from the centre.
            let from = top.max(row * TILE_PX) as f32 - v;
            let to = bottom.min(row * TILE_PX + TILE_PX - 1) as f32 - v;
            // An edge of an ellipse has its maximum at `lean`, or where the strip is nearest to it.
            let edge = |side: f32| {
                let dy = (side * s.lean).max(from).min(to);
                let share = dy / s.reach[1];
                s.slope * dy + side * s.half_width * (1.0 - share * share).max(0.0).sqrt()
            };
            let [left, right] = whole(u + edge(-1.0), u + edge(1.0), last[0])?;
            Some((row, [left / TILE_PX, right / TILE_PX + 1]))
        })
    }
}

/// First and last whole number of an interval within 0 and `last`, if there is one.
fn whole(from: f32, to: f32, last: f32) -> Option<[u32; 2]> {
    let (from, to) = (from.ceil().max(0.0), to.floor().min(last));
    (from <= to).then_some([from as u32, to as u32])
}
