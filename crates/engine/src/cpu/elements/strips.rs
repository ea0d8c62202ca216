//! The order in which elements are evaluated. Every element is owned by one of its endpoints; eight
//! owners side by side, a lane each, make a strip, whose steps are blocks of one element of each.
//! So an owner's state is read once for all its elements and its forces stay in registers until the
//! strip ends; only the other endpoints are read and added to in every step.
//!
//! The order depends on the graph alone, therefore so do the sums' roundings.

use std::ops::Range;

use crate::cpu::arithmetic::{Index, LANES};

/// Rows of similar length are grouped within a window of this many successive rows: wide enough to
/// find some, narrow enough to stay close in memory.
const WINDOW: usize = 8 * LANES;
/// Number of an owner's remaining elements that are considered for the next step.
const CHOICE: usize = 32;
/// A slot without an element.
const EMPTY: u32 = u32::MAX;

/// Eight owners and the blocks with their elements.
#[derive(Clone, Debug)]
pub(crate) struct Strip {
    /// A lane each; a lane without one has endpoint 0 and no elements.
    pub(crate) owners: Index,
    first: u32,
    end: u32,
}

impl Strip {
    /// Blocks of the strip.
    #[inline(always)]
    pub(crate) fn blocks(&self) -> Range<usize> {
        self.first as usize..self.end as usize
    }
}

/// The order of one kind of elements.
#[derive(Debug, Default)]
pub(crate) struct Strips {
    pub(crate) strips: Vec<Strip>,
    /// Element of every lane of every block.
    slots: Vec<Index>,
}

/// An element as the order sees it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct OwnedElement<const OTHERS: usize> {
    pub(crate) owner: u32,
    pub(crate) others: [u32; OTHERS],
    pub(crate) element: u32,
}

impl Strips {
    /// Orders elements by their endpoints.
    pub(crate) fn new<const OTHERS: usize>(
        mut elements: Vec<OwnedElement<OTHERS>>,
        endpoints: usize,
    ) -> Self {
        elements.sort_unstable_by_key(|e| (e.owner, e.others, e.element));
        let mut rows = rows(&elements);
        for window in rows.chunks_mut(WINDOW) {
            window.sort_by_key(|row| std::cmp::Reverse(row.len()));
        }
        let mut order = Self::default();
        let mut used = vec![0; endpoints];
        for rows in rows.chunks(LANES) {
            order.push(rows, &mut used);
        }
        order
    }

    /// Blocks.
    pub(crate) fn blocks(&self) -> usize {
        self.slots.len()
    }

    /// The element in a lane of a block, if there is one.
    pub(crate) fn at(&self, block: usize, lane: usize) -> Option<usize> {
        let slot = *self.slots.get(block)?.get(lane)?;
        (slot != EMPTY).then_some(slot as usize)
    }

    /// Adds a strip. In each step every owner takes the element whose others were added to the
    /// longest ago, so that no sum waits for the one before it.
    fn push<const OTHERS: usize>(&mut self, rows: &[&[OwnedElement<OTHERS>]], used: &mut [u32]) {
        let first = self.slots.len();
        let mut owners = [0; LANES];
        let mut waiting: Vec<Vec<OwnedElement<OTHERS>>> =
            rows.iter().map(|row| row.to_vec()).collect();
        for (owner, row) in owners.iter_mut().zip(&waiting) {
            *owner = row.first().map_or(0, |e| e.owner);
        }
        while waiting.iter().any(|row| !row.is_empty()) {
            let mut block = [EMPTY; LANES];
            let now = self.slots.len() as u32 + 1;
            for (slot, row) in block.iter_mut().zip(&mut waiting) {
                let last_use = |e: &OwnedElement<OTHERS>| e.others.map(|o| used[o as usize]);
                let near = row.iter().take(CHOICE).enumerate();
                let best = near.min_by_key(|(_, e)| last_use(e).into_iter().max());
                let Some((at, _)) = best else { continue };
                let chosen = row.remove(at);
                chosen.others.iter().for_each(|&o| used[o as usize] = now);
                *slot = chosen.element;
            }
            self.slots.push(block);
        }
        self.strips.push(Strip { owners, first: first as u32, end: self.slots.len() as u32 });
    }
}

/// Each owner's elements; an owner with far more than others has several rows of them.
fn rows<const OTHERS: usize>(elements: &[OwnedElement<OTHERS>]) -> Vec<&[OwnedElement<OTHERS>]> {
    let owners: Vec<_> = elements.chunk_by(|a, b| a.owner == b.owner).collect();
    let mean = elements.len().div_ceil(owners.len().max(1));
    let most = (2 * mean).min(elements.len().div_ceil(LANES)).max(1);
    let split = |all: &'_ [OwnedElement<OTHERS>]| all.len().div_ceil(all.len().div_ceil(most));
    owners.iter().flat_map(|all| all.chunks(split(all))).collect()
}

/// Gives every spring to one of its ends such that neighbours own about equally many.
pub(crate) fn share(springs: &[[u32; 2]], endpoints: usize) -> Vec<OwnedElement<1>> {
    let mut order: Vec<u32> = (0..springs.len() as u32).collect();
    order.sort_unstable_by_key(|&s| (springs[s as usize], s));
    let mut owned = vec![0_u32; endpoints];
    let mut shared: Vec<OwnedElement<1>> = order
        .into_iter()
        .map(|element| {
            let [a, b] = springs[element as usize];
            let (owner, other) =
                if owned[a as usize] <= owned[b as usize] { (a, b) } else { (b, a) };
            owned[owner as usize] += 1;
            OwnedElement { owner, others: [other], element }
        })
        .collect();
    for _ in 0..PASSES {
        for spring in &mut shared {
            let (owner, other) = (spring.owner, spring.others[0]);
            if owned[owner as usize] > owned[other as usize] + 1 {
                owned[owner as usize] -= 1;
                owned[other as usize] += 1;
                *spring = OwnedElement { owner: other, others: [owner], ..*spring };
            }
        }
    }
    shared
}

/// Passes in which springs go from the end that owns more to the end that owns fewer.
const PASSES: usize = 8;

#[cfg(test)]
mod tests;
