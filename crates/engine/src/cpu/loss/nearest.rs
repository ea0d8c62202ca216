//! Nearest surface point of each target, by brute force over lanes where they are few, which is faster
//! than sorting them for every frame, and through a grid where they are many. Ties go to the lower
//! index.

mod grid;

use pulp::{Arch, Simd, WithSimd};

use self::grid::Grid;
use crate::cpu::arithmetic::{LANES, Lane, Node, Quad, Real};

/// Pairs of nodes and targets from which on a grid is faster.
const GRID_PAIRS: usize = 1 << 20;

/// Index of the nearest of `nodes` for each target; empty if there are no nodes.
pub(crate) fn nearest<T: Real>(nodes: &[Node<T>], targets: &[Quad<T>]) -> Vec<u32> {
    let is_large = nodes.len().saturating_mul(targets.len()) >= GRID_PAIRS;
    let Some(grid) = is_large.then(|| Grid::new(nodes)).flatten() else {
        return by_brute_force(nodes, targets);
    };
    let near: Vec<Option<u32>> = targets.iter().map(|t| grid.nearest(t)).collect();
    let far = |(target, found): (&Quad<T>, &Option<u32>)| found.is_none().then_some(*target);
    let far: Vec<Quad<T>> = targets.iter().zip(&near).filter_map(far).collect();
    let mut others = by_brute_force(nodes, &far).into_iter();
    near.into_iter().filter_map(|found| found.or_else(|| others.next())).collect()
}

fn by_brute_force<T: Real>(nodes: &[Node<T>], targets: &[Quad<T>]) -> Vec<u32> {
    if nodes.is_empty() {
        return Vec::new();
    }
    let blocks = nodes
        .chunks(LANES)
        .map(|chunk| {
            let mut block = [[T::ZERO; LANES]; 3];
            for l in 0..LANES {
                // A block that is not full repeats its last node: ties go to the lower index.
                let node = &chunk[l.min(chunk.len() - 1)];
                for c in 0..3 {
                    block[c][l] = node.x[c];
                }
            }
            block
        })
        .collect();
    Arch::new().dispatch(Search { blocks, targets })
}

struct Search<'a, T> {
    blocks: Vec<[Lane<T>; 3]>,
    targets: &'a [Quad<T>],
}

impl<T: Real> WithSimd for Search<'_, T> {
    type Output = Vec<u32>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> Vec<u32> {
        let mut found = Vec::with_capacity(self.targets.len());
        for t in self.targets {
            // A target farther than this from every node gets node 0.
            let mut best = [T::from_f64(1e30); LANES];
            let mut best_block = [0_u32; LANES];
            for (index, b) in self.blocks.iter().enumerate() {
                let index = index as u32;
                for l in 0..LANES {
                    let (x, y, z) = (b[0][l] - t[0], b[1][l] - t[1], b[2][l] - t[2]);
                    let square = x * x + y * y + z * z;
                    let nearer = square < best[l];
                    best[l] = if nearer { square } else { best[l] };
                    best_block[l] = if nearer { index } else { best_block[l] };
                }
            }
            let mut winner = (best[0], best_block[0] * LANES as u32);
            for l in 1..LANES {
                let index = best_block[l] * LANES as u32 + l as u32;
                if best[l] < winner.0 || (best[l] == winner.0 && index < winner.1) {
                    winner = (best[l], index);
                }
            }
            found.push(winner.1);
        }
        found
    }
}

#[cfg(test)]
mod tests;
