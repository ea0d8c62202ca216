//! Shares of the parts in the cells of a frame: from strokes in the first labelled frame, and from the
//! frame before in all others.

use bendtwin_core::Point;
use kiddo::{ImmutableKdTree, SquaredEuclidean};
use rayon::prelude::*;

use crate::{
    cells::{Cells, NONE},
    colors::{Colors, bin},
    looks::Looks,
    part::{BACKGROUND, HAND, OBJECT, PARTS, Shares, UNKNOWN, certainty, likeliest, only, shares},
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
/// Evidence for the background of what is connected to nothing that was object or hand: of what has come
/// in front of the backdrop, and of what stands there, however alike it looks.
const APART: f32 = 1.5;
const STANDS_APART: f32 = 8.0;
/// Mean evidence for the background below which a thing has come.
const COME: f32 = -1.0;
/// Cells that are too few for a thing.
const FEW_CELLS: usize = 12;
/// Share of object and hand from which a cell was one of them; where nothing is known it is 2/3.
const ATTACHED: f32 = 0.75;
/// Gaps that do not set things apart in the first frame: a hand hides what is behind it [m].
const GAP_M: f32 = 0.03;

/// Cells of a labelled frame, to find them again in the next.
#[derive(Clone)]
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
    let marked = [OBJECT, HAND].into_iter().flat_map(|part| &seeds[part]);
    let together = shot.cells.together(marked.copied(), GAP_M);
    let local = (0..shot.cells.len()).map(|i| {
        let mut logs = colors[i];
        logs[BACKGROUND] += shot.cells.cells[i].backdrop;
        for part in [OBJECT, HAND] {
            logs[part] -= weight * ways[part][i].min(MOST_WAY_M) / WAY_M;
        }
        // Near a stroke on the background it is as near as others, elsewhere somewhat far.
        logs[BACKGROUND] -= weight * ways[BACKGROUND][i].min(0.5 * MOST_WAY_M) / WAY_M;
        if !together[i] {
            logs[BACKGROUND] += STANDS_APART;
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
    let logs = |i: usize| {
        let mut logs = colors[i];
        logs[BACKGROUND] += shot.cells.cells[i].backdrop;
        let near: [f32; PARTS] =
            std::array::from_fn(|k| (-(ways[k][i] / CORRECTED_M).powi(2)).exp());
        let corrected = near.iter().copied().fold(0.0, f32::max);
        for k in 0..PARTS {
            logs[k] += (1.0 - corrected) * BEFORE_WEIGHT * (known[i][k] + 0.02).ln();
            logs[k] += CORRECTION * near[k];
        }
        logs
    };
    let mut local: Vec<Shares> = (0..shot.cells.len()).map(logs).collect();
    let apart = apart(&shot.cells, &known, |i| likeliest(&local[i]) != BACKGROUND);
    for (logs, apart) in local.iter_mut().zip(apart) {
        logs[BACKGROUND] += apart;
        *logs = shares(*logs);
    }
    walk(shot, local, seeds)
}

/// Evidence for the background of cells of things that were neither object nor hand: little of a thing
/// that is mostly in front of the backdrop and so has come, much of one that stands there, and none of
/// one that was object or hand. Things are connected cells for which `is_thing` holds.
fn apart(cells: &Cells, known: &[Shares], is_thing: impl Fn(usize) -> bool) -> Vec<f32> {
    let mut evidence: Vec<Option<f32>> = vec![None; cells.len()];
    for start in 0..cells.len() {
        if evidence[start].is_some() || !is_thing(start) {
            continue;
        }
        evidence[start] = Some(0.0);
        let mut thing = vec![start];
        let mut next = 0;
        while let Some(&cell) = thing.get(next) {
            next += 1;
            for (other, _) in cells.links(cell) {
                let other = *other as usize;
                if is_thing(other) && evidence[other].replace(0.0).is_none() {
                    thing.push(other);
                }
            }
        }
        let were = thing.iter().filter(|i| known[**i][OBJECT] + known[**i][HAND] > ATTACHED);
        // A few cells that were labelled by mistake do not carry a whole thing with them.
        if were.count() >= FEW_CELLS.min(thing.len().div_ceil(4)) {
            continue;
        }
        let [sum, count] = thing.iter().fold([0.0; 2], |[sum, count], cell| {
            let cell = &cells.cells[*cell];
            [sum + cell.count * cell.backdrop, count + cell.count]
        });
        let has_come = thing.len() >= FEW_CELLS && sum < COME * count;
        let of_thing = if has_come { APART } else { STANDS_APART };
        thing.iter().for_each(|cell| evidence[*cell] = Some(of_thing));
    }
    evidence.into_iter().map(Option::unwrap_or_default).collect()
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
