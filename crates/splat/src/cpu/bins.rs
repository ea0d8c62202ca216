//! Projected Gaussians in the order of their depths, and the list of those that touch each tile.

use std::ops::Range;

use pulp::{Arch, Simd, WithSimd};
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
    /// First intersection of the tile, and of the next tile.
    pub(super) first: u32,
    pub(super) end: u32,
}

/// Gaussians as a camera sees them. S is the number of Gaussians in view, K that of intersections:
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
        let arch = Arch::new();
        let pieces = |count: usize| {
            let starts = (0..count.div_ceil(PIECE)).into_par_iter();
            starts.map(move |k| k * PIECE..count.min((k + 1) * PIECE))
        };
        let found: Vec<Vec<(u32, Splat)>> = pieces(gaussians.len())
            .map(|piece| arch.dispatch(ProjectPiece { gaussians, camera, piece }))
            .collect();
        let found = found.concat();
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
        let of_piece = |piece: Range<usize>| FindSpans { grid: &grid, splats: &splats[piece] };
        let spans: Vec<Spans> =
            pieces(splats.len()).map(|piece| arch.dispatch(of_piece(piece))).collect();
        let count: usize = spans.iter().map(|s| s.tiles).sum();
        if count > MOST_INTERSECTIONS {
            let what = "intersections of Gaussians and tiles";
            return Err(Error::TooMany { what, count, most: MOST_INTERSECTIONS });
        }
        let mut bins = Self { splats, indices, ..Self::default() };
        bins.fill(&grid, &spans, count);
        Ok(bins)
    }

    /// Sorts intersections by tiles, by counting.
    fn fill(&mut self, grid: &Grid, spans: &[Spans], count: usize) {
        let mut next = vec![0_u32; grid.columns as usize * grid.rows as usize];
        for span in spans.iter().flat_map(|s| &s.spans) {
            next[span.tiles(grid)].iter_mut().for_each(|n| *n += 1);
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
        self.starts = Vec::with_capacity(self.splats.len() + 1);
        self.starts.push(0);
        let mut splat = 0;
        for piece in spans {
            let mut rest = piece.spans.as_slice();
            for &rows in &piece.rows {
                let (own, after) = rest.split_at(rows as usize);
                rest = after;
                for n in own.iter().flat_map(|span| span.tiles(grid)) {
                    let place = &mut next[n];
                    self.entries[*place as usize] = splat;
                    self.places.push(*place);
                    *place += 1;
                }
                self.starts.push(self.places.len() as u32);
                splat += 1;
            }
        }
    }

    /// Intersections of a projected Gaussian, in the order of tiles.
    pub(super) fn places_of(&self, splat: usize) -> &[u32] {
        &self.places[self.starts[splat] as usize..self.starts[splat + 1] as usize]
    }
}

/// Projects a piece of the Gaussians, compiled for the instructions of the processor.
struct ProjectPiece<'a> {
    gaussians: &'a Gaussians,
    camera: &'a Camera,
    piece: Range<usize>,
}

impl WithSimd for ProjectPiece<'_> {
    type Output = Vec<(u32, Splat)>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> Self::Output {
        let mut found = Vec::with_capacity(self.piece.len());
        for i in self.piece {
            if let Some(splat) = project(self.gaussians, i, self.camera) {
                found.push((i as u32, splat));
            }
        }
        found
    }
}

/// Tiles of a row that a Gaussian touches.
#[derive(Clone, Copy)]
struct Span {
    row: u32,
    /// First column, and the one after the last.
    first: u32,
    end: u32,
}

impl Span {
    fn tiles(&self, grid: &Grid) -> Range<usize> {
        let tile = |column: u32| (self.row * grid.columns + column) as usize;
        tile(self.first)..tile(self.end)
    }
}

/// Tiles that a piece of the projected Gaussians touches.
#[derive(Default)]
struct Spans {
    spans: Vec<Span>,
    /// Spans of each Gaussian.
    rows: Vec<u32>,
    /// Number of tiles of all spans.
    tiles: usize,
}

/// Finds the spans, compiled for the instructions of the processor.
struct FindSpans<'a> {
    grid: &'a Grid,
    splats: &'a [Splat],
}

impl WithSimd for FindSpans<'_> {
    type Output = Spans;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> Spans {
        let mut found = Spans::default();
        for splat in self.splats {
            let before = found.spans.len();
            self.grid.find(splat, &mut found);
            found.rows.push((found.spans.len() - before) as u32);
        }
        found
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

    /// Adds the tiles that an ellipse touches, row by row.
    #[inline(always)]
    fn find(&self, splat: &Splat, found: &mut Spans) {
        let [u, v] = splat.center;
        let Some([top, bottom]) = whole(v - splat.reach, v + splat.reach, self.last[1]) else {
            return;
        };
        for row in top / TILE_PX..bottom / TILE_PX + 1 {
            // Rows of the strip, from the centre.
            let from = top.max(row * TILE_PX) as f32 - v;
            let to = bottom.min(row * TILE_PX + TILE_PX - 1) as f32 - v;
            // An edge of an ellipse has its maximum at `lean`, or where the strip is nearest to it.
            let edge = |side: f32| {
                let dy = (side * splat.lean).max(from).min(to);
                let share = dy / splat.reach;
                let half = splat.half_width * (1.0 - share * share).max(0.0).sqrt();
                splat.slope * dy + side * half
            };
            if let Some([left, right]) = whole(u + edge(-1.0), u + edge(1.0), self.last[0]) {
                let (first, end) = (left / TILE_PX, right / TILE_PX + 1);
                found.spans.push(Span { row, first, end });
                found.tiles += (end - first) as usize;
            }
        }
    }
}

/// First and last whole number of an interval within 0 and `last`, if there is one.
#[inline(always)]
fn whole(from: f32, to: f32, last: f32) -> Option<[u32; 2]> {
    let (from, to) = (from.ceil().max(0.0), to.floor().min(last));
    (from <= to).then_some([from as u32, to as u32])
}
