//! Shares of the parts in the cells of a frame: from strokes in the first labelled frame, and from the
//! frame before in all others.

use bendtwin_core::Point;
use kiddo::{ImmutableKdTree, SquaredEuclidean};
use rayon::prelude::*;

use crate::{
    cells::{Cells, NONE},
    colors::{Colors, bin},
    looks::Looks,
    part::{BACKGROUND, HAND, OBJECT, PARTS, Shares, UNKNOWN, certainty, only, shares},
    scene::Shot,
};

/// Sweeps of the random walk.
const SWEEPS: usize = 40;
/// Chance with which a walk ends in a cell whose own evidence is certain, and in any.
const HELD: f32 = 0.2;
const LEAST_HELD: f32 = 0.01;
/// Length of the way from a stroke that counts as much as a factor of e in colour [m], and beyond which
/// it no longer grows.
const WAY_M: f32 = 0.06;
const MOST_WAY_M: f32 = 0.3;
/// Weight of ways in the rounds of labelling the first frame, in which colours become known.
pub(crate) const WAY_WEIGHTS: [f32; 6] = [1.0, 0.6, 0.4, 0.3, 0.2, 0.2];
/// Radius around a stroke within which the first colours are taken [m].
const FIRST_WAY_M: f32 = 0.025;
/// Weight of what cells were in the frame before.
const BEFORE_WEIGHT: f32 = 1.5;
/// Distance in space [m] that a difference of colours of 255 counts as, when cells are found again.
const COLOR_M: f32 = 0.06;
/// Cells of the frame before that are compared, and their distance that counts as much as a factor of e
/// [m].
const NEIGHBOURS: usize = 6;
const FOUND_M: f32 = 0.015;
/// Weight of a telling nothing among them.
const NOT_FOUND: f32 = 0.3;
/// Length over which a later stroke overrules what was known before [m].
const CORRECTED_M: f32 = 0.04;
/// Weight of a later stroke where it lies.
const CORRECTION: f32 = 4.0;
/// Evidence for the background of what is connected to nothing that was object or hand.
const APART: f32 = 1.5;

/// Cells of a labelled frame, to find them again in the next.
pub(crate) struct Labelled {
    pub(crate) cells: Vec<(Point, [f32; 3])>,
    pub(crate) shares: Vec<Shares>,
}

/// Marked cells of each part.
pub(crate) type Seeds = [Vec<u32>; PARTS];

impl Labelled {
    pub(crate) fn new(shot: &Shot, shares: Vec<Shares>) -> Self {
        let cells = shot.cells.cells.iter().map(|cell| (cell.place, cell.color)).collect();
        Self { cells, shares }
    }

    /// Places of the cells that are object or hand rather than background.
    pub(crate) fn places(&self) -> impl Iterator<Item = Point> + '_ {
        let both = self.cells.iter().zip(&self.shares);
        both.filter(|(_, shares)| shares[BACKGROUND] < 0.5).map(|((place, _), _)| *place)
    }

    /// Shares that cells of another frame had in this one, by the cells that lie near and look alike.
    fn found_again(&self, cells: &Cells) -> Vec<Shares> {
        let row = |place: Point, color: [f32; 3]| -> [f32; 6] {
            let [r, g, b] = color.map(|c| c * COLOR_M / 255.0);
            [place[0], place[1], place[2], r, g, b]
        };
        let rows: Vec<[f32; 6]> = self.cells.iter().map(|(p, c)| row(*p, *c)).collect();
        let Some(tree) = (!rows.is_empty())
            .then(|| ImmutableKdTree::<f32, 6>::new_from_slice(&rows).ok())
            .flatten()
        else {
            return cells.unknown();
        };
        let again = |cell: &crate::cells::Cell| -> Shares {
            let query = row(cell.place, cell.color);
            let near = std::num::NonZeroUsize::MIN.saturating_add(NEIGHBOURS - 1);
            let found = tree.query(&query).nearest_n::<SquaredEuclidean<f32>>(near).execute();
            let (mut sum, mut weight) = (UNKNOWN.map(|s| s * NOT_FOUND), NOT_FOUND);
            for near in found {
                let w = (-near.distance / (2.0 * FOUND_M * FOUND_M)).exp();
                let theirs = self.shares[near.item as usize];
                (0..PARTS).for_each(|k| sum[k] += w * theirs[k]);
                weight += w;
            }
            sum.map(|s| s / weight)
        };
        cells.cells.par_iter().map(again).collect()
    }
}

/// Marked cells, given the marked pixels of each camera by their parts.
pub(crate) fn seeds(shot: &Shot, marked: &[Vec<(usize, usize)>]) -> Seeds {
    let mut seeds = Seeds::default();
    for (of_pixel, marked) in shot.of_pixel.iter().zip(marked) {
        for (at, part) in marked {
            let cell = of_pixel.get(*at).copied().unwrap_or(NONE);
            if cell != NONE {
                seeds[*part].push(cell);
            }
        }
    }
    for part in &mut seeds {
        part.sort_unstable();
        part.dedup();
    }
    seeds
}

/// Shares in the first labelled frame, in a round of `0..WAY_WEIGHTS.len()`.
pub(crate) fn begin(shot: &Shot, looks: &Looks, seeds: &Seeds, round: usize) -> Vec<Shares> {
    let weight = WAY_WEIGHTS[round.min(WAY_WEIGHTS.len() - 1)];
    let ways: [Vec<f32>; PARTS] =
        std::array::from_fn(|part| shot.cells.ways(seeds[part].iter().copied(), MOST_WAY_M));
    let colors = shot.color_logs(looks);
    let local = (0..shot.cells.len()).map(|i| {
        let mut logs = colors[i];
        logs[BACKGROUND] += shot.cells.cells[i].backdrop;
        for part in [OBJECT, HAND] {
            logs[part] -= weight * ways[part][i].min(MOST_WAY_M) / WAY_M;
        }
        // Near a stroke on the background it is as near as others, elsewhere somewhat far.
        logs[BACKGROUND] -= weight * ways[BACKGROUND][i].min(0.5 * MOST_WAY_M) / WAY_M;
        if ways[OBJECT][i].is_infinite() && ways[HAND][i].is_infinite() {
            logs[BACKGROUND] += APART;
        }
        shares(logs)
    });
    walk(shot, local.collect(), seeds)
}

/// Cells near the strokes of a part, and nearer to them than to others, from which the first colours
/// are taken: shares are 1 there and 0 elsewhere.
pub(crate) fn first(shot: &Shot, seeds: &Seeds) -> Vec<Shares> {
    let ways: [Vec<f32>; PARTS] =
        std::array::from_fn(|part| shot.cells.ways(seeds[part].iter().copied(), 3.0 * FIRST_WAY_M));
    let of = |i: usize| {
        let all: [f32; PARTS] = std::array::from_fn(|part| ways[part][i]);
        let mut taken = [0.0; PARTS];
        for part in [OBJECT, HAND] {
            let others = (0..PARTS).filter(|k| *k != part).map(|k| all[k]);
            let nearest = others.fold(f32::INFINITY, f32::min);
            if all[part] <= FIRST_WAY_M && all[part] < 0.5 * nearest {
                taken[part] = 1.0;
            }
        }
        taken
    };
    (0..shot.cells.len()).map(of).collect()
}

/// Shares in a frame after one that is labelled.
pub(crate) fn follow(shot: &Shot, looks: &Looks, before: &Labelled, seeds: &Seeds) -> Vec<Shares> {
    let known = before.found_again(&shot.cells);
    let colors = shot.color_logs(looks);
    let ways: [Vec<f32>; PARTS] =
        std::array::from_fn(|part| shot.cells.ways(seeds[part].iter().copied(), 3.0 * CORRECTED_M));
    let attached = attached(&shot.cells, &known);
    let local = (0..shot.cells.len()).map(|i| {
        let mut logs = colors[i];
        logs[BACKGROUND] += shot.cells.cells[i].backdrop;
        let near: [f32; PARTS] =
            std::array::from_fn(|k| (-(ways[k][i] / CORRECTED_M).powi(2)).exp());
        let corrected = near.iter().copied().fold(0.0, f32::max);
        for k in 0..PARTS {
            logs[k] += (1.0 - corrected) * BEFORE_WEIGHT * (known[i][k] + 0.02).ln();
            logs[k] += CORRECTION * near[k];
        }
        if !attached[i] {
            logs[BACKGROUND] += APART;
        }
        shares(logs)
    });
    walk(shot, local.collect(), seeds)
}

/// `true` for cells that are connected to one that was object or hand.
fn attached(cells: &Cells, known: &[Shares]) -> Vec<bool> {
    let mut attached: Vec<bool> = known.iter().map(|k| k[OBJECT] + k[HAND] > 0.6).collect();
    let mut queue: Vec<usize> = (0..attached.len()).filter(|i| attached[*i]).collect();
    while let Some(cell) = queue.pop() {
        for (other, _) in cells.links(cell) {
            if !std::mem::replace(&mut attached[*other as usize], true) {
                queue.push(*other as usize);
            }
        }
    }
    attached
}

fn walk(shot: &Shot, mut local: Vec<Shares>, seeds: &Seeds) -> Vec<Shares> {
    let mut held: Vec<f32> =
        local.iter().map(|shares| LEAST_HELD + HELD * certainty(shares)).collect();
    for (part, seeds) in seeds.iter().enumerate() {
        for seed in seeds {
            (local[*seed as usize], held[*seed as usize]) = (only(part), 1.0);
        }
    }
    shot.cells.diffuse(&local, &held, SWEEPS)
}

/// Colours of the parts in the cells of a frame.
pub(crate) fn colors(shot: &Shot, shares: &[Shares]) -> [Colors; PARTS] {
    let mut colors: [Colors; PARTS] = std::array::from_fn(|_| Colors::default());
    for (view, of_pixel) in shot.views.iter().zip(&shot.of_pixel) {
        let Some(view) = view else { continue };
        for (at, cell) in of_pixel.iter().enumerate().filter(|(_, cell)| **cell != NONE) {
            let shares = shares[*cell as usize];
            for part in [OBJECT, HAND] {
                if shares[part] > 0.6 {
                    colors[part].add(bin(view.colors[at]), shares[part]);
                }
            }
        }
    }
    colors
}
