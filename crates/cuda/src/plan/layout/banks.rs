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
        let mut used_by_half = [None; 2 * BANKS];
        for quarter in 0..WARP / TOGETHER {
            let mut used = [None; BANKS];
            if quarter % 2 == 0 {
                used_by_half = [None; 2 * BANKS];
            }
            let lanes_of = slot.iter_mut().enumerate().skip(quarter * TOGETHER).take(TOGETHER);
            for (lane, taken) in lanes_of {
                let node = lane / lanes;
                let Some(own) = first.get_mut(node) else { continue };
                let from = if own.is_empty() { &mut then[node] } else { own };
                *taken = take(from, &mut used, &mut used_by_half);
            }
        }
        out.push(slot);
    }
    out
}

/// Takes a half-spring that is read along with another lane's, or else one whose banks are free,
/// from the bank that has most of them left; any if none is.
fn take(
    from: &mut Vec<Half>,
    used: &mut [Option<u32>; BANKS],
    used_by_half: &mut [Option<u32>; 2 * BANKS],
) -> Option<Half> {
    let bank = |h: &Half| h.1 as usize % BANKS;
    let half_bank = |h: &Half| h.1 as usize % (2 * BANKS);
    let mut left = [0_u32; BANKS];
    from.iter().for_each(|h| left[bank(h)] += 1);
    let gain = |of: Option<u32>, h: &Half| match of {
        Some(other) if other == h.1 => 2,
        None => 1,
        Some(_) => 0,
    };
    let rank = |i: usize| {
        let h = &from[i];
        let gains = 3 * gain(used[bank(h)], h) + gain(used_by_half[half_bank(h)], h);
        (gains, left[bank(h)], std::cmp::Reverse(i))
    };
    let best = (0..from.len()).max_by_key(|&i| rank(i))?;
    let taken = from.swap_remove(best);
    used[bank(&taken)].get_or_insert(taken.1);
    used_by_half[half_bank(&taken)].get_or_insert(taken.1);
    Some(taken)
}

#[cfg(test)]
mod tests;
