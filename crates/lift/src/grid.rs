//! Points in cells of space, to find those near a place.

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
    pub(crate) fn within(&self, at: Point, radius_m: f64) -> Vec<(f64, usize)> {
        let mut found = Vec::new();
        let reach = (radius_m / self.cell_m).ceil() as i64;
        let [x, y, z] = self.cell(at);
        for i in x - reach..=x + reach {
            for j in y - reach..=y + reach {
                for k in z - reach..=z + reach {
                    for (index, p) in self.cells.get(&[i, j, k]).into_iter().flatten() {
                        let square = square(at, *p);
                        if square <= radius_m * radius_m {
                            found.push((square, *index));
                        }
                    }
                }
            }
        }
        found
    }

    /// The nearest `count` of those, nearest first.
    pub(crate) fn nearest(&self, at: Point, radius_m: f64, count: usize) -> Vec<usize> {
        let mut found = self.within(at, radius_m);
        let order = |a: &(f64, usize), b: &(f64, usize)| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1));
        if found.len() > count {
            found.select_nth_unstable_by(count, order);
            found.truncate(count);
        }
        found.sort_by(order);
        found.into_iter().map(|(_, i)| i).collect()
    }

    /// The nearest of those; the first of equals.
    pub(crate) fn closest(&self, at: Point, radius_m: f64) -> Option<usize> {
        let near = self.within(at, radius_m).into_iter();
        near.min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1))).map(|(_, i)| i)
    }

    /// True if a point is within `radius_m`.
    pub(crate) fn any_within(&self, at: Point, radius_m: f64) -> bool {
        !self.within(at, radius_m).is_empty()
    }

    fn cell(&self, p: Point) -> [i64; 3] {
        p.map(|x| (f64::from(x) / self.cell_m).floor() as i64)
    }
}

fn square(a: Point, b: Point) -> f64 {
    a.iter().zip(b).map(|(a, b)| f64::from(a - b).powi(2)).sum()
}
