//! Nearest nodes through a uniform grid: the same answers as by brute force, in a fraction of the time
//! where nodes and targets are many and near each other.

use crate::cpu::arithmetic::{Node, Quad, Real};

/// Cells around a target's own that are searched in each direction, at most.
const MOST_CELLS: f64 = 4.0;
/// A step of cells' sizes that are tried.
const FINER: f64 = 1.25;
/// Share of the nodes that may be in one cell: with more the grid would not help.
const CROWD: usize = 16;
/// Share of a length that rounding may move a node into the next cell by.
const ROUNDING: f64 = 1e-3;

/// Nodes by cell.
pub(super) struct Grid<T> {
    low: [f64; 3],
    /// Edge of a cell [m].
    size_m: f64,
    /// Number of cells along each axis.
    cells: [usize; 3],
    /// First node of each cell, and the end of the last; z runs fastest.
    starts: Vec<u32>,
    /// Positions of nodes by cell, and which they are, ascending in each.
    nodes: Vec<([T; 3], u32)>,
}

impl<T: Real> Grid<T> {
    /// About as many cells as nodes; `None` where nodes lie so that a grid does not help, or at no
    /// place.
    pub(super) fn new(nodes: &[Node<T>]) -> Option<Self> {
        let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
        for node in nodes {
            for c in 0..3 {
                let x = node.x[c].to_f64();
                if !x.is_finite() {
                    return None;
                }
                (low[c], high[c]) = (low[c].min(x), high[c].max(x));
            }
        }
        let extents: [f64; 3] = std::array::from_fn(|c| high[c] - low[c]);
        let longest = extents.into_iter().fold(0.0, f64::max);
        if !(longest > 0.0 && longest.is_finite()) {
            return None;
        }
        let cells = |size: f64| extents.map(|e| (e / size) as usize + 1);
        let mut size_m = longest;
        while cells(size_m / FINER).into_iter().product::<usize>() <= nodes.len() {
            size_m /= FINER;
        }
        let mut grid =
            Self { low, size_m, cells: cells(size_m), starts: Vec::new(), nodes: Vec::new() };
        grid.fill(nodes);
        let fullest = grid.starts.windows(2).map(|w| (w[1] - w[0]) as usize).max().unwrap_or(0);
        (fullest <= nodes.len() / CROWD).then_some(grid)
    }

    /// Sorts nodes by cell.
    fn fill(&mut self, nodes: &[Node<T>]) {
        let of: Vec<usize> = nodes.iter().map(|n| self.index(self.cell(&n.x))).collect();
        self.starts = vec![0; self.cells.iter().product::<usize>() + 1];
        of.iter().for_each(|&cell| self.starts[cell + 1] += 1);
        for k in 1..self.starts.len() {
            self.starts[k] += self.starts[k - 1];
        }
        let mut next = self.starts.clone();
        self.nodes = vec![([T::ZERO; 3], 0); nodes.len()];
        for ((node, cell), index) in nodes.iter().zip(of).zip(0..) {
            let [x, y, z, _] = node.x;
            self.nodes[next[cell] as usize] = ([x, y, z], index);
            next[cell] += 1;
        }
    }

    /// The cell of a place, of the outermost for one outside.
    fn cell(&self, at: &Quad<T>) -> [usize; 3] {
        std::array::from_fn(|c| {
            // Saturates, and no number is 0.
            let index = ((at[c].to_f64() - self.low[c]) / self.size_m) as usize;
            index.min(self.cells[c] - 1)
        })
    }

    fn index(&self, [x, y, z]: [usize; 3]) -> usize {
        (x * self.cells[1] + y) * self.cells[2] + z
    }

    /// The nearest node; `None` if the cells around the target are empty or hold only distant
    /// nodes.
    pub(super) fn nearest(&self, target: &Quad<T>) -> Option<u32> {
        let cell = self.cell(target);
        let (square, index) = self.nearest_within(target, cell, 1)?;
        // A node `reach` cells away is at least `reach` cell edges away.
        let reach = square.to_f64().sqrt() / ((1.0 - ROUNDING) * self.size_m);
        if reach < 1.0 {
            return Some(index);
        }
        let in_reach = || self.nearest_within(target, cell, reach as usize + 1);
        (reach < MOST_CELLS).then(in_reach).flatten().map(|(_, index)| index)
    }

    /// The nearest node in cells up to `reach` from a cell, and the square of its distance.
    fn nearest_within(&self, target: &Quad<T>, cell: [usize; 3], reach: usize) -> Option<(T, u32)> {
        let first: [usize; 3] = std::array::from_fn(|c| cell[c].saturating_sub(reach));
        let last: [usize; 3] = std::array::from_fn(|c| (cell[c] + reach).min(self.cells[c] - 1));
        let mut best: Option<(T, u32)> = None;
        for x in first[0]..=last[0] {
            for y in first[1]..=last[1] {
                let run = self.starts[self.index([x, y, first[2]])] as usize
                    ..self.starts[self.index([x, y, last[2]]) + 1] as usize;
                for &(at, index) in &self.nodes[run] {
                    let (x, y, z) = (at[0] - target[0], at[1] - target[1], at[2] - target[2]);
                    let square = x * x + y * y + z * z;
                    let is_nearer = best.is_none_or(|(least, winner)| {
                        square < least || (square == least && index < winner)
                    });
                    if is_nearer {
                        best = Some((square, index));
                    }
                }
            }
        }
        best
    }
}
