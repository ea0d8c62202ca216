use proptest::prelude::*;

use super::*;

/// Slots of references to triplets below a number of them, a few an endpoint.
fn rows() -> impl Strategy<Value = (usize, Vec<Vec<Reference>>)> {
    (0_u32..4).prop_flat_map(|log| {
        let lanes = 1_usize << log;
        let end = prop::collection::vec(
            (0_u32..400, 0_u32..3).prop_map(|(t, role)| reference(t, role)),
            0..20,
        );
        (Just(lanes), prop::collection::vec(end, 0..=WARP / lanes))
    })
}

proptest! {
    #[test]
    fn every_reference_comes_once_to_a_lane_of_its_endpoint((lanes, ends) in rows()) {
        let slots = arrange(lanes, ends.clone());
        let longest = ends.iter().map(Vec::len).max().unwrap_or(0);
        prop_assert_eq!(slots.len(), longest.div_ceil(lanes));
        for (end, mut expected) in ends.into_iter().enumerate() {
            let of = |slot: &Slot| slot[end * lanes..(end + 1) * lanes].to_vec();
            let mut found: Vec<Reference> =
                slots.iter().flat_map(of).filter(|&r| r != NO_ARM).collect();
            found.sort_unstable();
            expected.sort_unstable();
            prop_assert_eq!(found, expected);
        }
    }
}

#[test]
fn references_in_different_banks_share_a_slot() {
    // Any order but that of the lanes: each has one reference to each bank.
    let ends: Vec<Vec<Reference>> = (0..WARP as u32)
        .map(|lane| (0..WARP as u32).map(|t| reference(t + lane * 32, 1)).collect())
        .collect();
    for slot in arrange(1, ends) {
        let mut banks: Vec<usize> = slot.iter().map(|&r| bank_of(r)).collect();
        banks.sort_unstable();
        assert!(banks.iter().copied().eq(0..WARP));
    }
}

/// Banks of the lanes of a slot, found as [`Matching`] finds them but by lists of banks.
fn matched(lanes: usize, ends: &[Vec<Reference>], left: &[u32; WARP]) -> Vec<Option<usize>> {
    fn seat(
        lane: usize,
        choices: &[Vec<usize>],
        tried: &mut Vec<usize>,
        of: &mut [Option<usize>],
    ) -> bool {
        for &bank in &choices[lane] {
            if tried.contains(&bank) {
                continue;
            }
            tried.push(bank);
            let other = of.iter().position(|b| *b == Some(bank));
            if other.is_none_or(|other| seat(other, choices, tried, of)) {
                of[lane] = Some(bank);
                return true;
            }
        }
        false
    }
    let choices = (0..ends.len() * lanes).map(|lane| {
        let mut banks: Vec<usize> = ends[lane / lanes].iter().map(|&r| bank_of(r)).collect();
        banks.sort_unstable_by_key(|&bank| (std::cmp::Reverse(left[bank]), bank));
        banks.dedup();
        banks
    });
    let choices: Vec<_> = choices.collect();
    let mut of = vec![None; choices.len()];
    let mut order: Vec<usize> = (0..choices.len()).collect();
    order.sort_by_key(|&lane| std::cmp::Reverse(ends[lane / lanes].len()));
    for lane in order.into_iter().filter(|lane| lane % lanes < ends[lane / lanes].len()) {
        // A lane that has to move has found another bank before its own is given away.
        seat(lane, &choices, &mut Vec::new(), &mut of);
    }
    of
}

proptest! {
    #[test]
    fn lanes_have_the_banks_that_lists_of_banks_would_give_them((lanes, ends) in rows()) {
        let mut left = [0; WARP];
        ends.iter().flatten().for_each(|&r| left[bank_of(r)] += 1);
        let ranks = Ranks::new(&left);
        let lane_in_rank = Matching::new(lanes, &ends, &ranks).fill();
        let bank = |lane: usize| {
            let rank = lane_in_rank.iter().position(|l| *l == Some(lane))?;
            ranks.of_bank.iter().position(|&r| r as usize == rank)
        };
        let found: Vec<_> = (0..ends.len() * lanes).map(bank).collect();
        prop_assert_eq!(found, matched(lanes, &ends, &left));
    }
}
