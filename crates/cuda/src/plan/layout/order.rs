//! Order of a block's triplets. A warp works on 32 of them together and reads the states of their
//! ends from shared memory: in few accesses only if those lie in different banks, as those of
//! half-springs do ([`banks`](super::banks)).

use super::banks::Reads;

/// Triplets that are considered for a lane. Neighbours in the graph stay near each other.
const CONSIDERED: usize = 64;

/// Indices of triplets with these ends, in the order in which lanes take them.
pub(super) fn arrange(ends: &[[u32; 3]]) -> Vec<usize> {
    let mut left: Vec<usize> = (0..ends.len()).rev().collect();
    let mut order = Vec::with_capacity(ends.len());
    let mut reads = [Reads::default(); 3];
    while !left.is_empty() {
        reads.iter_mut().for_each(|r| r.next_lane(order.len()));
        let first = left.len().saturating_sub(CONSIDERED);
        // The earliest of the best: they stand in reverse.
        let (mut best, mut most) = (left.len() - 1, 0);
        for at in (first..left.len()).rev() {
            let ends = ends[left[at]];
            let gain = (0..3).map(|role| reads[role].gain(ends[role])).sum::<u32>();
            if gain > most {
                (best, most) = (at, gain);
                if most == 3 * Reads::MOST {
                    break;
                }
            }
        }
        let taken = left.remove(best);
        reads.iter_mut().zip(ends[taken]).for_each(|(r, end)| r.take(end));
        order.push(taken);
    }
    order
}

#[cfg(test)]
mod tests;
