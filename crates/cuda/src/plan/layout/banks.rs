//! Assignment of half-springs to slots and lanes. A quarter of a warp reads eight float4s of shared
//! memory per access, without conflicts only if they lie in different banks: indices that differ
//! modulo 8. Half a warp reads sixteen float2s per access: indices that differ modulo 16.

use super::{
    NONE,
    rows::{Half, WARP},
};

/// Lanes whose reads of 16 bytes are served together.
const TOGETHER: usize = 8;
/// Groups of banks of 16 bytes.
const BANKS: usize = 8;

/// A slot: what each lane of the warp takes.
pub(super) type Slot = [Option<Half>; WARP];

/// Deals the half-springs of a row's nodes to at least `slots` slots of `lanes` lanes a node:
/// `first` fill the first ones, `then` the rest.
pub(super) fn arrange(
    lanes: usize,
    first: Vec<Vec<Half>>,
    then: Vec<Vec<Half>>,
    slots: usize,
) -> Vec<Slot> {
    let mut left: usize = first.iter().chain(&then).map(Vec::len).sum();
    let mut first: Vec<Undealt> = first.into_iter().map(Undealt::new).collect();
    let mut then: Vec<Undealt> = then.into_iter().map(Undealt::new).collect();
    let mut out = Vec::with_capacity(slots);
    while out.len() < slots || left > 0 {
        let mut slot: Slot = [None; WARP];
        let mut reads = Reads::default();
        for (lane, taken) in slot.iter_mut().enumerate() {
            reads.next_lane(lane);
            let node = lane / lanes;
            let Some(own) = first.get_mut(node) else { continue };
            let from = if own.halves.is_empty() { &mut then[node] } else { own };
            *taken = from.take(&mut reads);
            left -= usize::from(taken.is_some());
        }
        out.push(slot);
    }
    out
}

/// Half-springs of a node that are to be dealt.
struct Undealt {
    halves: Vec<Half>,
    /// Number of them in each bank.
    in_bank: [u32; BANKS],
}

impl Undealt {
    fn new(halves: Vec<Half>) -> Self {
        let mut in_bank = [0; BANKS];
        halves.iter().for_each(|h| in_bank[h.1 as usize % BANKS] += 1);
        Self { halves, in_bank }
    }

    /// Takes a half-spring that is read along with another lane's, or else one with free banks,
    /// from the bank that has most of them left; any if no bank is free. The first of several.
    fn take(&mut self, reads: &mut Reads) -> Option<Half> {
        let (mut best, mut most) = (0, 0);
        for (i, half) in self.halves.iter().enumerate() {
            // There are fewer springs at a node than 1 << 24.
            let worth = reads.gain(half.1) << 24 | self.in_bank[half.1 as usize % BANKS];
            if worth > most {
                (best, most) = (i, worth);
            }
        }
        if most == 0 {
            return None;
        }
        let taken = self.halves.swap_remove(best);
        self.in_bank[taken.1 as usize % BANKS] -= 1;
        reads.take(taken.1);
        Some(taken)
    }
}

/// States that the lanes of a warp read together, by bank.
#[derive(Clone, Copy)]
pub(super) struct Reads {
    /// Local index that is read, [`NONE`] for unread banks.
    by_quarter: [u32; BANKS],
    by_half: [u32; 2 * BANKS],
}

impl Default for Reads {
    fn default() -> Self {
        Self { by_quarter: [NONE; BANKS], by_half: [NONE; 2 * BANKS] }
    }
}

impl Reads {
    /// Moves to a lane: the first of a quarter or half of a warp reads alone.
    pub(super) fn next_lane(&mut self, lane: usize) {
        if lane.is_multiple_of(TOGETHER) {
            self.by_quarter = [NONE; BANKS];
        }
        if lane.is_multiple_of(2 * TOGETHER) {
            self.by_half = [NONE; 2 * BANKS];
        }
    }

    /// Most that [`Reads::gain`] says.
    pub(super) const MOST: u32 = 8;

    /// Worth of reading the state of a local index: most where another lane reads the same, nothing
    /// where it waits for others.
    pub(super) fn gain(&self, local: u32) -> u32 {
        // Without branches, for this is asked of every half-spring again and again.
        let of = |used: u32| 2 * u32::from(used == local) + u32::from(used == NONE);
        let at = local as usize;
        3 * of(self.by_quarter[at % BANKS]) + of(self.by_half[at % (2 * BANKS)])
    }

    /// Reads it.
    pub(super) fn take(&mut self, local: u32) {
        let at = local as usize;
        for used in [&mut self.by_quarter[at % BANKS], &mut self.by_half[at % (2 * BANKS)]] {
            if *used == NONE {
                *used = local;
            }
        }
    }
}

#[cfg(test)]
mod tests;
