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

/// References of one slot by lane, [`NO_ARM`] where there is none.
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
            let mut matching =
                Matching { lanes, ends: &ends, left_in_bank, lane_in_bank: [None; WARP] };
            matching.fill();
            let lane_in_bank = matching.lane_in_bank;
            let mut taken: Slot = [NO_ARM; WARP];
            let mut take = |ends: &mut Vec<Vec<Reference>>, lane: usize, at: usize| {
                let reference = ends[lane / lanes].swap_remove(at);
                left_in_bank[bank_of(reference)] -= 1;
                taken[lane] = reference;
            };
            for (bank, lane) in lane_in_bank.iter().enumerate() {
                let Some(lane) = *lane else { continue };
                let own = &ends[lane / lanes];
                if let Some(at) = own.iter().position(|&r| bank_of(r) == bank) {
                    take(&mut ends, lane, at);
                }
            }
            // What would not fit into the slots that are left comes now, whatever its bank.
            let room = (slots - slot - 1) * lanes;
            let seated = |lane: usize| lane_in_bank.contains(&Some(lane));
            for lane in (0..ends.len() * lanes).filter(|&lane| !seated(lane)) {
                if ends[lane / lanes].len() > room {
                    take(&mut ends, lane, 0);
                }
            }
            taken
        })
        .collect()
}

/// Lanes of a slot and the banks that they read, one each.
struct Matching<'a> {
    lanes: usize,
    /// References that endpoints still have.
    ends: &'a [Vec<Reference>],
    left_in_bank: [u32; WARP],
    lane_in_bank: [Option<usize>; WARP],
}

impl Matching<'_> {
    /// Finds a bank for as many lanes as possible.
    fn fill(&mut self) {
        let mut order: Vec<usize> = (0..self.ends.len() * self.lanes).collect();
        order.sort_by_key(|&lane| std::cmp::Reverse(self.ends[lane / self.lanes].len()));
        for lane in order {
            // Lanes of an endpoint do not take more than it has.
            if lane % self.lanes < self.ends[lane / self.lanes].len() {
                self.seat(lane, &mut 0);
            }
        }
    }

    /// Finds a bank for a lane; others may have to move. `tried` has a bit for each bank.
    fn seat(&mut self, lane: usize, tried: &mut u32) -> bool {
        let own = &self.ends[lane / self.lanes];
        let mut banks: Vec<usize> = own.iter().map(|&r| bank_of(r)).collect();
        banks.sort_unstable_by_key(|&bank| (std::cmp::Reverse(self.left_in_bank[bank]), bank));
        banks.dedup();
        for bank in banks {
            if *tried >> bank & 1 == 1 {
                continue;
            }
            *tried |= 1 << bank;
            let free = match self.lane_in_bank[bank] {
                None => true,
                Some(other) => self.seat(other, tried),
            };
            if free {
                self.lane_in_bank[bank] = Some(lane);
                return true;
            }
        }
        false
    }
}

#[cfg(test)]
mod tests;
