//! Points in cells of space, to find those near a place where points keep apart from each other. A cell may
//! hold any number of others: those are for [`bendtwin_near::PointTree`].

use std::collections::HashMap;

use bendtwin_core::Point;

/// Points by cubic cells of one size.
pub(crate) struct Grid {
    cell_m: f64,
    cells: HashMap<[i64; 3], Vec<(usize, Point)>>,
}

impl Grid {
    pub(crate) fn new(cell_m: f64) -> Self {
        Self { cell_m: cell_m.max(1e-6), cells: HashMap::new() }
    }

    pub(crate) fn of(points: impl IntoIterator<Item = Point>, cell_m: f64) -> Self {
        let mut grid = Self::new(cell_m);
        points.into_iter().enumerate().for_each(|(i, p)| grid.insert(i, p));
        grid
    }

    pub(crate) fn insert(&mut self, index: usize, point: Point) {
        self.cells.entry(self.cell(point)).or_default().push((index, point));
    }

    /// Squared distance and index of the points within `radius_m`, which is at most a few cells.
    pub(crate) fn within(&self, at: Point, radius_m: f64) -> impl Iterator<Item = (f64, usize)> {
        let reach = (radius_m / self.cell_m).ceil() as i64;
        // Places far beyond any recording share the outermost cells.
        let [x, y, z] = self.cell(at).map(|c| c.saturating_sub(reach)..=c.saturating_add(reach));
        let cells = x.flat_map(move |i| {
            let z = z.clone();
            y.clone().flat_map(move |j| z.clone().map(move |k| [i, j, k]))
        });
        let near = cells.flat_map(|cell| self.cells.get(&cell).into_iter().flatten());
        let measured = near.map(move |(index, p)| (square(at, *p), *index));
        measured.filter(move |(square, _)| *square <= radius_m * radius_m)
    }

    /// The nearest of those; the first of equals.
    pub(crate) fn closest(&self, at: Point, radius_m: f64) -> Option<usize> {
        let near = self.within(at, radius_m);
        near.min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1))).map(|(_, i)| i)
    }

    /// True if a point is within `radius_m`.
    pub(crate) fn any_within(&self, at: Point, radius_m: f64) -> bool {
        self.within(at, radius_m).next().is_some()
    }

    fn cell(&self, p: Point) -> [i64; 3] {
        p.map(|x| (f64::from(x) / self.cell_m).floor() as i64)
    }
}

fn square(a: Point, b: Point) -> f64 {
    a.iter().zip(b).map(|(a, b)| f64::from(a - b).powi(2)).sum()
}
