//! Assignment of half-springs to slots and lanes. A quarter of a warp reads eight float4s of shared
//! memory at once, and in one go only if they lie in different banks: indices that differ modulo 8.
//! Half a warp reads sixteen float2s at once: indices that differ modulo 16.

use super::rows::{Half, WARP};

/// Lanes whose reads of 16 bytes are served together.
const TOGETHER: usize = 8;
/// Groups of banks of 16 bytes.
const BANKS: usize = 8;

/// One slot: what each lane of the warp takes.
pub(super) type Slot = [Option<Half>; WARP];

/// Deals the half-springs of a row's nodes to at least `slots` slots of `lanes` lanes a node:
/// `first` fill the first ones, `then` what is left.
pub(super) fn arrange(
    lanes: usize,
    mut first: Vec<Vec<Half>>,
    mut then: Vec<Vec<Half>>,
    slots: usize,
) -> Vec<Slot> {
    let mut out = Vec::with_capacity(slots);
    while out.len() < slots || first.iter().chain(&then).any(|n| !n.is_empty()) {
        let mut slot: Slot = [None; WARP];
        let mut reads = Reads::default();
        for (lane, taken) in slot.iter_mut().enumerate() {
            reads.next_lane(lane);
            let node = lane / lanes;
            let Some(own) = first.get_mut(node) else { continue };
            let from = if own.is_empty() { &mut then[node] } else { own };
            *taken = take(from, &mut reads);
        }
        out.push(slot);
    }
    out
}

/// Takes a half-spring that is read along with another lane's, or else one whose banks are free,
/// from the bank that has most of them left; any if none is.
fn take(from: &mut Vec<Half>, reads: &mut Reads) -> Option<Half> {
    let bank = |h: &Half| h.1 as usize % BANKS;
    let mut left = [0_u32; BANKS];
    from.iter().for_each(|h| left[bank(h)] += 1);
    let rank = |i: usize| {
        let h = &from[i];
        (reads.gain(h.1), left[bank(h)], std::cmp::Reverse(i))
    };
    let best = (0..from.len()).max_by_key(|&i| rank(i))?;
    let taken = from.swap_remove(best);
    reads.take(taken.1);
    Some(taken)
}

/// States that the lanes of a warp read together, by bank.
#[derive(Clone, Copy, Default)]
pub(super) struct Reads {
    by_quarter: [Option<u32>; BANKS],
    by_half: [Option<u32>; 2 * BANKS],
}

impl Reads {
    /// Goes on to a lane: the first of a quarter or half of a warp reads alone.
    pub(super) fn next_lane(&mut self, lane: usize) {
        if lane.is_multiple_of(TOGETHER) {
            self.by_quarter = [None; BANKS];
        }
        if lane.is_multiple_of(2 * TOGETHER) {
            self.by_half = [None; 2 * BANKS];
        }
    }

    /// Worth of reading the state of a local index: most where another lane reads the same, nothing
    /// where it waits for others.
    pub(super) fn gain(&self, local: u32) -> u32 {
        let of = |used: Option<u32>| match used {
            Some(other) if other == local => 2,
            None => 1,
            Some(_) => 0,
        };
        let at = local as usize;
        3 * of(self.by_quarter[at % BANKS]) + of(self.by_half[at % (2 * BANKS)])
    }

    /// Reads it.
    pub(super) fn take(&mut self, local: u32) {
        let at = local as usize;
        self.by_quarter[at % BANKS].get_or_insert(local);
        self.by_half[at % (2 * BANKS)].get_or_insert(local);
    }
}

#[cfg(test)]
mod tests;
