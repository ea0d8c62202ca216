use proptest::prelude::*;

use super::*;

/// Slots of references of triplets below so many, a few an endpoint.
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
