//! A box of space, cut into cubic cells.

use bendtwin_core::Point;

/// Space around what was seen of the object: sides that no camera sees, and what a hand hides [m].
const MARGIN_M: f64 = 0.06;
/// About the most cells; they are larger where there would be more.
const MAX_CELLS: f64 = 1_000_000.0;

/// Cells, in order of x, y, z.
pub(super) struct Volume {
    low: [f64; 3],
    pub(super) cell_m: f64,
    size: [usize; 3],
}

impl Volume {
    /// The box around points with a margin; `None` if there is no point, or no finite box.
    pub(super) fn around(points: &[Point], cell_m: f64) -> Option<Self> {
        let first = *points.first()?;
        let [low, high] = points.iter().fold([first; 2], |[low, high], p| {
            [std::array::from_fn(|a| low[a].min(p[a])), std::array::from_fn(|a| high[a].max(p[a]))]
        });
        let low = low.map(|x| f64::from(x) - MARGIN_M);
        let extent: [f64; 3] = std::array::from_fn(|a| f64::from(high[a]) + MARGIN_M - low[a]);
        let mut cell_m = cell_m.max((extent.iter().product::<f64>() / MAX_CELLS).cbrt());
        if extent.iter().any(|e| !e.is_finite()) || !cell_m.is_finite() || cell_m <= 0.0 {
            return None;
        }
        let counts = |cell_m: f64| extent.map(|e| (e / cell_m).ceil().max(1.0));
        // A box may be thinner than such a cell.
        while counts(cell_m).iter().product::<f64>() > 2.0 * MAX_CELLS {
            cell_m *= 1.5;
        }
        Some(Self { low, cell_m, size: counts(cell_m).map(|n| n as usize) })
    }

    pub(super) fn count(&self) -> usize {
        self.size.iter().product()
    }

    /// Middle of a cell [m].
    pub(super) fn centre(&self, cell: usize) -> Point {
        let at = self.place(cell);
        std::array::from_fn(|a| (self.low[a] + (at[a] as f64 + 0.5) * self.cell_m) as f32)
    }

    /// The cell of a point, if it lies in the box.
    pub(super) fn cell(&self, point: Point) -> Option<usize> {
        let at: [f64; 3] =
            std::array::from_fn(|a| ((f64::from(point[a]) - self.low[a]) / self.cell_m).floor());
        let inside = (0..3).all(|a| at[a] >= 0.0 && at[a] < self.size[a] as f64);
        inside.then(|| self.index(at.map(|x| x as usize)))
    }

    /// The six cells that share a face with one; `None` beyond the box.
    pub(super) fn faces(&self, cell: usize) -> [Option<usize>; 6] {
        let steps = [[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]];
        steps.map(|step| self.step(cell, step))
    }

    /// The up to 26 cells around one, and how far their middles are [m].
    pub(super) fn around_cell(&self, cell: usize) -> Vec<(usize, f64)> {
        let mut around = Vec::with_capacity(26);
        for x in -1..=1 {
            for y in -1..=1 {
                for z in -1..=1 {
                    let square = x * x + y * y + z * z;
                    if square > 0
                        && let Some(other) = self.step(cell, [x, y, z])
                    {
                        around.push((other, self.cell_m * f64::from(square as i32).sqrt()));
                    }
                }
            }
        }
        around
    }

    fn step(&self, cell: usize, by: [isize; 3]) -> Option<usize> {
        let at = self.place(cell);
        let mut to = [0; 3];
        for a in 0..3 {
            to[a] = at[a].checked_add_signed(by[a]).filter(|x| *x < self.size[a])?;
        }
        Some(self.index(to))
    }

    fn place(&self, cell: usize) -> [usize; 3] {
        let [_, ny, nz] = self.size;
        [cell / (ny * nz), cell / nz % ny, cell % nz]
    }

    fn index(&self, [x, y, z]: [usize; 3]) -> usize {
        (x * self.size[1] + y) * self.size[2] + z
    }
}

#[cfg(test)]
mod tests;
