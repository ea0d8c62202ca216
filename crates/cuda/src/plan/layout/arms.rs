//! References of endpoints to their triplets, dealt to the lanes of a row: slot by slot, so that a
//! warp reads its references in one go, and what they refer to in different banks as far as that is
//! possible.
//!
//! A reference is the place of the first component of what a triplet exerts on the endpoint: 32
//! triplets stand together, for each role 32 numbers of each component, so that its bank is that of
//! its triplet. A slot is a matching of lanes and banks; banks and lanes with many references left go
//! first, so that few of them are left over in the end.

use super::{NO_ARM, rows::WARP};

/// Ends of a triplet, and components of a vector.
const ROLES: u32 = 3;
const COMPONENTS: u32 = 3;

/// A reference; see above.
pub(super) type Reference = u32;

/// Reference to the force of triplet `t` of a share on one of its ends, by role: 0 for i, 1 for k,
/// 2 for j.
pub(super) fn reference(t: u32, role: u32) -> Reference {
    let warp = WARP as u32;
    (t / warp * ROLES + role) * COMPONENTS * warp + t % warp
}

/// References of a slot by lane, [`NO_ARM`] for lanes without one.
pub(super) type Slot = [Reference; WARP];

fn bank_of(reference: Reference) -> usize {
    reference as usize % WARP
}

/// Deals the references of a row's endpoints to as few slots of `lanes` lanes an endpoint as there
/// can be.
pub(super) fn arrange(lanes: usize, mut ends: Vec<Vec<Reference>>) -> Vec<Slot> {
    let longest = ends.iter().map(Vec::len).max().unwrap_or(0);
    let mut left_in_bank = [0_u32; WARP];
    ends.iter().flatten().for_each(|&r| left_in_bank[bank_of(r)] += 1);
    let slots = longest.div_ceil(lanes);
    (0..slots)
        .map(|slot| {
            let ranks = Ranks::new(&left_in_bank);
            let lane_in_rank = Matching::new(lanes, &ends, &ranks).fill();
            let mut taken: Slot = [NO_ARM; WARP];
            let mut take = |ends: &mut Vec<Vec<Reference>>, lane: usize, at: usize| {
                let reference = ends[lane / lanes].swap_remove(at);
                left_in_bank[bank_of(reference)] -= 1;
                taken[lane] = reference;
            };
            let mut seated = 0_u32;
            for bank in 0..WARP {
                let Some(lane) = lane_in_rank[ranks.of_bank[bank] as usize] else { continue };
                seated |= 1 << lane;
                let own = &ends[lane / lanes];
                if let Some(at) = own.iter().position(|&r| bank_of(r) == bank) {
                    take(&mut ends, lane, at);
                }
            }
            // References that would not fit into the remaining slots are placed now, in any bank.
            let room = (slots - slot - 1) * lanes;
            for lane in (0..ends.len() * lanes).filter(|&lane| seated >> lane & 1 == 0) {
                if ends[lane / lanes].len() > room {
                    take(&mut ends, lane, 0);
                }
            }
            taken
        })
        .collect()
}

/// Banks by the references that are left in them, those with most first.
struct Ranks {
    /// Rank of each bank.
    of_bank: [u8; WARP],
}

impl Ranks {
    fn new(left_in_bank: &[u32; WARP]) -> Self {
        let mut banks: [u8; WARP] = std::array::from_fn(|bank| bank as u8);
        banks.sort_by_key(|&bank| std::cmp::Reverse(left_in_bank[bank as usize]));
        let mut of_bank = [0; WARP];
        for (rank, &bank) in (0_u8..).zip(&banks) {
            of_bank[bank as usize] = rank;
        }
        Self { of_bank }
    }
}

/// Lanes of a slot and the banks that they read, one each, by rank.
struct Matching {
    lanes: usize,
    /// Number of references that each endpoint still has.
    counts: Vec<usize>,
    /// Ranks of their banks, a bit for each.
    wanted: Vec<u32>,
    lane_in_rank: [Option<usize>; WARP],
}

impl Matching {
    fn new(lanes: usize, ends: &[Vec<Reference>], ranks: &Ranks) -> Self {
        let bit = |&r: &Reference| 1_u32 << ranks.of_bank[bank_of(r)];
        Self {
            lanes,
            counts: ends.iter().map(Vec::len).collect(),
            wanted: ends.iter().map(|own| own.iter().map(bit).fold(0, |all, b| all | b)).collect(),
            lane_in_rank: [None; WARP],
        }
    }

    /// Finds a bank for as many lanes as possible; the lane at each rank.
    fn fill(mut self) -> [Option<usize>; WARP] {
        let mut order: Vec<usize> = (0..self.counts.len() * self.lanes).collect();
        order.sort_by_key(|&lane| std::cmp::Reverse(self.counts[lane / self.lanes]));
        for lane in order {
            // Lanes of an endpoint do not take more than it has.
            if lane % self.lanes < self.counts[lane / self.lanes] {
                self.seat(lane, &mut 0);
            }
        }
        self.lane_in_rank
    }

    /// Finds a bank for a lane; others may have to move. `tried` has a bit for each rank.
    fn seat(&mut self, lane: usize, tried: &mut u32) -> bool {
        let wanted = self.wanted[lane / self.lanes];
        loop {
            let open = wanted & !*tried;
            if open == 0 {
                return false;
            }
            let rank = open.trailing_zeros() as usize;
            *tried |= 1 << rank;
            let free = match self.lane_in_rank[rank] {
                None => true,
                Some(other) => self.seat(other, tried),
            };
            if free {
                self.lane_in_rank[rank] = Some(lane);
                return true;
            }
        }
    }
}

#[cfg(test)]
mod tests;
