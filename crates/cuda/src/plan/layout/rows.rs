//! Half-springs in rows: a warp works on 32 / lanes nodes together, each lane on every lanes-th
//! half-spring of its node. A slot is one half-spring for each of the 32 lanes; slots come in
//! pairs.

use super::{Incidence, Layout, NONE, PAIR_SUMS, SUMS_APART, banks};

/// Lanes of a warp.
pub(super) const WARP: usize = 32;
/// Threads of a block that keep its multiprocessor busy.
const BUSY_THREADS: usize = 512;
/// Fewer half-springs than this a lane are not worth a shuffle more, in a block that is busy and in
/// one that is not.
const FEWEST_SLOTS_BUSY: usize = 6;
const FEWEST_SLOTS: usize = 3;

/// A half-spring: spring, other end by local index, whether it reports the gradient.
pub(super) type Half = (u32, u32, bool);

/// Lanes that share a node in a part of `nodes`: as many as the threads allow.
pub(super) fn lanes_for(nodes: usize, incidence: &Incidence, threads: u32) -> u32 {
    let ends = incidence.starts.len().saturating_sub(1).max(1);
    let valence = incidence.springs.len() / ends;
    let mut lanes = 1;
    while lanes < WARP {
        let more = (nodes * 2 * lanes).next_multiple_of(WARP);
        let fewest = if more > BUSY_THREADS { FEWEST_SLOTS_BUSY } else { FEWEST_SLOTS };
        if more > threads as usize || valence / (2 * lanes) < fewest {
            break;
        }
        lanes *= 2;
    }
    lanes as u32
}

/// Adds rows to a layout.
pub(super) struct Rows<'a> {
    pub(super) lanes: usize,
    pub(super) layout: &'a mut Layout,
}

impl Rows<'_> {
    /// Rows for `count` endpoints, which have these local indices and half-springs; how many there
    /// are.
    pub(super) fn add(
        &mut self,
        count: usize,
        local: impl Fn(usize) -> u32,
        halves: impl Fn(usize) -> Vec<Half>,
    ) -> u32 {
        let a_row = WARP / self.lanes;
        let rows = count.div_ceil(a_row);
        for row in 0..rows {
            let ends: Vec<Vec<Half>> =
                (row * a_row..((row + 1) * a_row).min(count)).map(&halves).collect();
            // A lane without an endpoint uses the first.
            let selves = (0..a_row).map(|k| row * a_row + k);
            let selves: Vec<u32> = selves.map(|i| local(if i < count { i } else { 0 })).collect();
            self.add_row(&ends, &selves);
        }
        rows as u32
    }

    /// Pairs of half-springs so far, those that fill up included.
    pub(super) fn pairs(&self) -> u32 {
        (self.layout.springs.len() / 2) as u32
    }

    /// Ends the rows of a share.
    pub(super) fn end(&mut self) {
        let pairs = self.pairs() / WARP as u32;
        self.layout.rows.push(pairs);
        self.layout.sum_rows.push(self.layout.sum_pairs);
    }

    fn add_row(&mut self, ends: &[Vec<Half>], selves: &[u32]) {
        let lanes = self.lanes;
        let layout = &mut *self.layout;
        layout.rows.push((layout.springs.len() / (2 * WARP)) as u32);
        layout.sum_rows.push(layout.sum_pairs);
        // Those that report gradients come first, so that few slots need sums.
        let owners: Vec<Vec<Half>> = ends.iter().map(|e| pick(e, true)).collect();
        let others: Vec<Vec<Half>> = ends.iter().map(|e| pick(e, false)).collect();
        let pairs_for = |most: usize| most.div_ceil(2 * lanes);
        let total = pairs_for(ends.iter().map(Vec::len).max().unwrap_or(0));
        let sum_pairs = pairs_for(owners.iter().map(Vec::len).max().unwrap_or(0));
        layout.max_row_pairs = layout.max_row_pairs.max(total as u32);
        layout.max_sum_pairs = layout.max_sum_pairs.max(sum_pairs as u32);
        let slots = banks::arrange(lanes, owners, others, 2 * total);
        for (at, pair) in (0_u32..).zip(slots.chunks(2)) {
            for lane in 0..WARP {
                for (h, slot) in pair.iter().enumerate() {
                    // What fills up a slot joins an endpoint to itself: that exerts nothing,
                    // dashpot or not.
                    let filler = (NONE, selves[lane / lanes], false);
                    let (spring, other, owns) = slot[lane].unwrap_or(filler);
                    layout.springs.push(spring);
                    layout.others.push(other);
                    if owns && let Some(sums) = layout.sum_of.get_mut(spring as usize) {
                        *sums = first_sum(layout.sum_pairs + at, h, lane);
                    }
                }
            }
        }
        layout.sum_pairs += sum_pairs as u32;
    }
}

/// First sum of a half-spring: of one half of a pair, in a lane.
fn first_sum(pair: u32, half: usize, lane: usize) -> u32 {
    pair * PAIR_SUMS + half as u32 * 3 * SUMS_APART + lane as u32
}

fn pick(halves: &[Half], owns: bool) -> Vec<Half> {
    halves.iter().copied().filter(|h| h.2 == owns).collect()
}
