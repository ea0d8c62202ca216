//! Half-springs in rows: a warp works on 32 / lanes nodes at once, each lane on every lanes-th half-spring
//! of its node. A slot is one half-spring for each of the 32 lanes; slots come in pairs.

use super::{Incidence, Layout, NONE, banks};

/// Lanes of a warp.
pub(super) const WARP: usize = 32;
/// A block of so many threads keeps its multiprocessor busy.
const BUSY_THREADS: usize = 512;
/// Fewer half-springs than this a lane are not worth a shuffle more, in a block that is busy and in one that is not.
const FEWEST_SLOTS_BUSY: usize = 6;
const FEWEST_SLOTS: usize = 3;

/// A half-spring: spring, other end by local index, whether it reports the gradient.
pub(super) type Half = (u32, u32, bool);

/// How many lanes share a node in a part of so many nodes: as many as the threads allow.
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
    /// Rows for `count` endpoints, which have these local indices and half-springs; how many there are.
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
            // A lane without an endpoint looks at the first.
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
    }

    fn add_row(&mut self, ends: &[Vec<Half>], selves: &[u32]) {
        let lanes = self.lanes;
        let layout = &mut *self.layout;
        layout.rows.push((layout.springs.len() / (2 * WARP)) as u32);
        // Those that report gradients come first, so that few slots need sums.
        let owners: Vec<Vec<Half>> = ends.iter().map(|e| pick(e, true)).collect();
        let others: Vec<Vec<Half>> = ends.iter().map(|e| pick(e, false)).collect();
        let pairs_for = |most: usize| most.div_ceil(2 * lanes);
        let total = pairs_for(ends.iter().map(Vec::len).max().unwrap_or(0));
        let owner_pairs = pairs_for(owners.iter().map(Vec::len).max().unwrap_or(0));
        layout.max_row_pairs = layout.max_row_pairs.max(total as u32);
        layout.max_owner_pairs = layout.max_owner_pairs.max(owner_pairs as u32);
        let slots = banks::arrange(lanes, owners, others, 2 * total);
        for pair in slots.chunks(2) {
            let halves = (0..WARP).flat_map(|lane| pair.iter().map(move |slot| (lane, slot[lane])));
            for (lane, half) in halves {
                // What fills up a slot joins an endpoint to itself: that exerts nothing, dashpot or not.
                let (spring, other, owns) = half.unwrap_or((NONE, selves[lane / lanes], false));
                layout.springs.push(spring);
                layout.others.push(other);
                layout.spring_of.push(if owns { spring as i32 } else { -1 });
            }
        }
    }
}

fn pick(halves: &[Half], owns: bool) -> Vec<Half> {
    halves.iter().copied().filter(|h| h.2 == owns).collect()
}
