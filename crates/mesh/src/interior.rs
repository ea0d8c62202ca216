//! Points on a grid inside a mesh.

use std::sync::atomic::{AtomicU64, Ordering};

use bendtwin_core::Point;
use rayon::prelude::*;

use crate::{Error, Mesh, Solid, winding::is_inside};

/// Most cells of a grid.
pub(crate) const MAX_CELLS: f64 = 20_000_000.0;
/// Most parts of the surface that are visited for all cells. Of a body there are some hundred for a cell, but
/// layers of triangles in one place are all visited for each cell between them.
const MAX_VISITS: u64 = 4_000_000_000;

impl Mesh {
    /// Points of a cubic grid inside the mesh, at least half a spacing from its surface, so that
    /// they do not double points on it. Open and self-intersecting meshes are filled where their
    /// winding number says so.
    ///
    /// # Errors
    /// If the spacing is no length, or so fine that memory would not hold the grid, or if the surface has too
    /// many layers.
    pub fn sample_interior(&self, spacing_m: f32) -> Result<Vec<Point>, Error> {
        self.interior_within(spacing_m, MAX_VISITS)
    }

    fn interior_within(&self, spacing_m: f32, most_visits: u64) -> Result<Vec<Point>, Error> {
        let Some(grid) = self.bounds().map(|bounds| Grid::over(bounds, spacing_m)).transpose()?
        else {
            return Ok(Vec::new());
        };
        let solid = Solid::new(self);
        let visits = AtomicU64::new(0);
        let points = grid.select(|p| {
            if visits.load(Ordering::Relaxed) > most_visits {
                return false;
            }
            let off_surface = |c: crate::Closest| c.distance >= f64::from(spacing_m) / 2.0;
            let (winding_number, visited) = solid.counted_winding_number(p);
            visits.fetch_add(visited, Ordering::Relaxed);
            is_inside(winding_number) && solid.surface().closest(p).is_some_and(off_surface)
        });
        if visits.into_inner() > most_visits {
            return Err(Error::Layers { triangles: self.triangles.len() });
        }
        Ok(points)
    }
}

/// A cubic grid over a box, centred in it.
pub(crate) struct Grid {
    low: Point,
    spacing: f32,
    counts: [usize; 3],
}

impl Grid {
    pub(crate) fn over([low, high]: [Point; 2], spacing_m: f32) -> Result<Self, Error> {
        let sizes: [f64; 3] = std::array::from_fn(|a| f64::from(high[a]) - f64::from(low[a]));
        let counts = sizes.map(|s| (s / f64::from(spacing_m)).floor() + 1.0);
        let cells: f64 = counts.iter().product();
        if !(spacing_m > 0.0 && cells <= MAX_CELLS) {
            let samples = cells.max(0.0) as u64;
            return Err(Error::Spacing { spacing_m, samples, limit: MAX_CELLS as u64 });
        }
        let rest = |a: usize| (sizes[a] - (counts[a] - 1.0) * f64::from(spacing_m)) / 2.0;
        Ok(Self {
            low: std::array::from_fn(|a| (f64::from(low[a]) + rest(a)) as f32),
            spacing: spacing_m,
            counts: counts.map(|c| c as usize),
        })
    }

    /// The grid's points that are wanted, in order of x, y, z.
    pub(crate) fn select(&self, wanted: impl Fn(Point) -> bool + Sync) -> Vec<Point> {
        let [nx, ny, nz] = self.counts;
        let columns = (0..nx * ny).into_par_iter().map(|xy| {
            let at = |z: usize| {
                let cell = [xy / ny, xy % ny, z];
                std::array::from_fn(|a| self.low[a] + self.spacing * cell[a] as f32)
            };
            (0..nz).map(at).filter(|p| wanted(*p)).collect::<Vec<Point>>()
        });
        columns.collect::<Vec<_>>().concat()
    }
}

#[cfg(test)]
mod tests;
