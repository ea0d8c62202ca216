//! Cells of space in which the cameras see something that may be object or hand: what one camera
//! knows about a place, all know.

use std::collections::{BinaryHeap, HashMap};

use bendtwin_core::Point;

use crate::{
    part::{Shares, UNKNOWN},
    view::color_square,
};

/// Side of a cell [m].
pub(crate) const SIDE_M: f32 = 0.006;
/// Difference of two colours at which neighbours hang together by a third, of 255.
const COLOR_EDGE: f32 = 32.0;
/// Least connection of neighbours: textures are no borders.
const MIN_CONNECTION: f32 = 0.1;
/// No cell.
pub(crate) const NONE: u32 = u32::MAX;

/// A cell.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Cell {
    /// Mean of the points in it [m].
    pub(crate) place: Point,
    /// Mean of their colours, of 255.
    pub(crate) color: [f32; 3],
    /// Number of pixels.
    pub(crate) count: f32,
    /// Mean evidence for the background, apart from colour, as a logarithm.
    pub(crate) backdrop: f32,
}

/// Cells of a frame and their neighbours.
#[derive(Debug, Default)]
pub(crate) struct Cells {
    pub(crate) cells: Vec<Cell>,
    by_key: HashMap<[i32; 3], u32>,
    /// Neighbours of cell i are `links[starts[i]..starts[i + 1]]`, with the strength of the
    /// connection.
    starts: Vec<u32>,
    links: Vec<(u32, f32)>,
}

impl Cells {
    /// Adds a pixel's point and returns its cell.
    pub(crate) fn add(&mut self, place: Point, color: [u8; 3], backdrop: f32) -> u32 {
        let key = place.map(|x| (x / SIDE_M).floor() as i32);
        let next = self.cells.len() as u32;
        let index = *self.by_key.entry(key).or_insert(next);
        if index == next {
            self.cells.push(Cell::default());
        }
        let cell = &mut self.cells[index as usize];
        for a in 0..3 {
            cell.place[a] += place[a];
            cell.color[a] += f32::from(color[a]);
        }
        cell.backdrop += backdrop;
        cell.count += 1.0;
        index
    }

    /// Ends adding: means instead of sums, and neighbours.
    pub(crate) fn settle(&mut self) {
        for cell in &mut self.cells {
            let n = cell.count.max(1.0);
            cell.place = cell.place.map(|x| x / n);
            cell.color = cell.color.map(|x| x / n);
            cell.backdrop /= n;
        }
        let mut keys = vec![[0; 3]; self.cells.len()];
        self.by_key.iter().for_each(|(key, index)| keys[*index as usize] = *key);
        let around =
            || (-1..=1).flat_map(|x| (-1..=1).flat_map(move |y| (-1..=1).map(move |z| [x, y, z])));
        self.starts = vec![0];
        for (index, key) in keys.iter().enumerate() {
            for step in around() {
                let there = [key[0] + step[0], key[1] + step[1], key[2] + step[2]];
                let Some(&other) = self.by_key.get(&there) else { continue };
                if other as usize != index {
                    let strength = self.connection(index, other as usize);
                    self.links.push((other, strength));
                }
            }
            self.starts.push(self.links.len() as u32);
        }
    }

    fn connection(&self, a: usize, b: usize) -> f32 {
        let [a, b] = [a, b].map(|i| self.cells[i].color.map(|x| x as u8));
        let alike = (-color_square(a, b) / (COLOR_EDGE * COLOR_EDGE)).exp();
        MIN_CONNECTION + (1.0 - MIN_CONNECTION) * alike
    }

    pub(crate) fn len(&self) -> usize {
        self.cells.len()
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.cells.is_empty()
    }

    /// Neighbours of a cell and the strengths of their connections.
    pub(crate) fn links(&self, cell: usize) -> &[(u32, f32)] {
        &self.links[self.starts[cell] as usize..self.starts[cell + 1] as usize]
    }

    /// Shares of each cell that agree with its evidence and with its neighbours: a random walker that
    /// starts in a cell, ends there with the chance `held`, and otherwise moves to a neighbour;
    /// where it ends, it takes a part by the evidence `local` (Grady, "Random walks for image
    /// segmentation", 2006, with priors).
    pub(crate) fn diffuse(&self, local: &[Shares], held: &[f32], sweeps: usize) -> Vec<Shares> {
        let mut shares = local.to_vec();
        for sweep in 0..sweeps {
            let mut update = |i: usize| {
                let (mut sum, mut weight) = ([0.0; 3], 0.0);
                for &(other, strength) in self.links(i) {
                    let theirs = shares[other as usize];
                    (0..3).for_each(|k| sum[k] += strength * theirs[k]);
                    weight += strength;
                }
                if weight > 0.0 {
                    let (stay, go) = (held[i], (1.0 - held[i]) / weight);
                    shares[i] = std::array::from_fn(|k| stay * local[i][k] + go * sum[k]);
                }
            };
            // There and back, so that news travels fast both ways.
            if sweep % 2 == 0 {
                (0..self.cells.len()).for_each(&mut update);
            } else {
                (0..self.cells.len()).rev().for_each(&mut update);
            }
        }
        shares
    }

    /// Lengths of the shortest ways from the seeds to all cells within `most_m` [m], longer where
    /// colours change; infinite beyond.
    pub(crate) fn ways(&self, seeds: impl IntoIterator<Item = u32>, most_m: f32) -> Vec<f32> {
        let mut lengths = vec![f32::INFINITY; self.cells.len()];
        let mut queue = BinaryHeap::new();
        for seed in seeds {
            lengths[seed as usize] = 0.0;
            queue.push(Step { length: 0.0, cell: seed });
        }
        while let Some(Step { length, cell }) = queue.pop() {
            if length > lengths[cell as usize] {
                continue;
            }
            let here = self.cells[cell as usize].place;
            for &(other, strength) in self.links(cell as usize) {
                let there = self.cells[other as usize].place;
                let step: f32 = (0..3).map(|a| (here[a] - there[a]).powi(2)).sum::<f32>().sqrt();
                let next = length + step * (1.5 - strength).max(0.5);
                if next < lengths[other as usize] && next <= most_m {
                    lengths[other as usize] = next;
                    queue.push(Step { length: next, cell: other });
                }
            }
        }
        lengths
    }

    /// `true` for cells that are reached from the seeds over gaps up to about a width [m].
    pub(crate) fn together(&self, seeds: impl IntoIterator<Item = u32>, gap_m: f32) -> Vec<bool> {
        let key = |cell: usize| self.cells[cell].place.map(|x| (x / gap_m).floor() as i32);
        let mut blocks: HashMap<[i32; 3], Vec<u32>> = HashMap::new();
        for cell in 0..self.cells.len() {
            blocks.entry(key(cell)).or_default().push(cell as u32);
        }
        let mut reached = vec![false; self.cells.len()];
        let mut queue: Vec<[i32; 3]> = seeds.into_iter().map(|seed| key(seed as usize)).collect();
        while let Some([x, y, z]) = queue.pop() {
            let around =
                (-1..=1).flat_map(|i| (-1..=1).flat_map(move |j| (-1..=1).map(move |k| [i, j, k])));
            for [i, j, k] in around {
                let there = [x + i, y + j, z + k];
                // A block is visited once.
                let Some(cells) = blocks.remove(&there) else { continue };
                cells.iter().for_each(|cell| reached[*cell as usize] = true);
                queue.push(there);
            }
        }
        reached
    }

    /// Shares that tell nothing, for every cell.
    pub(crate) fn unknown(&self) -> Vec<Shares> {
        vec![UNKNOWN; self.cells.len()]
    }
}

/// A cell on the way, the nearest first.
struct Step {
    length: f32,
    cell: u32,
}

impl PartialEq for Step {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other).is_eq()
    }
}

impl Eq for Step {}

impl PartialOrd for Step {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Step {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        other.length.total_cmp(&self.length).then(other.cell.cmp(&self.cell))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::part::{HAND, OBJECT, likeliest, only};

    /// A row of cells, dark up to the middle and light from there.
    fn row(n: usize) -> Cells {
        let mut cells = Cells::default();
        for i in 0..n {
            let gray = if 2 * i < n { 40 } else { 200 };
            cells.add([(i as f32 + 0.5) * SIDE_M, 0.001, 0.001], [gray; 3], 0.0);
        }
        cells.settle();
        cells
    }

    #[test]
    fn two_seeds_divide_a_row_where_its_colour_changes() {
        let cells = row(40);
        let mut local = cells.unknown();
        let mut held = vec![0.0; 40];
        // Not as far from the middle.
        for (at, part) in [(8, OBJECT), (34, HAND)] {
            (local[at], held[at]) = (only(part), 1.0);
        }
        let shares = cells.diffuse(&local, &held, 400);
        for (i, shares) in shares.iter().enumerate() {
            assert_eq!(likeliest(shares), if i < 20 { OBJECT } else { HAND }, "{i}: {shares:?}");
        }
    }

    #[test]
    fn ways_go_along_the_cells_and_end_at_gaps() {
        let mut cells = Cells::default();
        for x in [0.003, 0.009, 0.015, 0.033] {
            cells.add([x, 0.001, 0.001], [9; 3], 0.0);
        }
        cells.settle();
        let ways = cells.ways([0], 1.0);
        assert!((ways[2] - 0.5 * 0.012).abs() < 1e-6, "{ways:?}");
        assert!(ways[3].is_infinite());
        assert!(cells.ways([0], 0.004)[2].is_infinite());
        assert_eq!(cells.together([0], 0.02), [true; 4]);
        assert_eq!(cells.together([0], 0.008), [true, true, true, false]);
    }
}
