use super::*;

/// Reads that follow each other because their banks collide, over those that none could do without.
fn collisions(slots: &[Slot]) -> f64 {
    let (mut served, mut least) = (0, 0);
    for quarter in slots.iter().flat_map(|s| s.chunks(TOGETHER)) {
        let mut by_bank = vec![std::collections::BTreeSet::new(); BANKS];
        for half in quarter.iter().flatten() {
            by_bank[half.1 as usize % BANKS].insert(half.1);
        }
        served += by_bank.iter().map(std::collections::BTreeSet::len).max().unwrap_or(0);
        least += 1;
    }
    served as f64 / f64::from(least)
}

/// A row of a chain in which every node is joined to the 17 before and behind it.
fn chain(lanes: usize) -> Vec<Vec<Half>> {
    let node = |i: u32| {
        (1..=17).flat_map(move |d| [(d, 100 + i - d, false), (100 + d, 100 + i + d, false)])
    };
    (0..(WARP / lanes) as u32).map(|i| node(i).collect()).collect()
}

#[test]
fn every_half_spring_is_dealt_once() {
    for lanes in [1, 2, 4, 32] {
        let halves = chain(lanes);
        let slots = arrange(lanes, vec![Vec::new(); halves.len()], halves.clone(), 3);
        for (node, own) in halves.iter().enumerate() {
            let lanes_of = node * lanes..(node + 1) * lanes;
            let mut dealt: Vec<Half> =
                slots.iter().flat_map(|s| s[lanes_of.clone()].iter().flatten().copied()).collect();
            let mut own = own.clone();
            dealt.sort_unstable();
            own.sort_unstable();
            assert_eq!(dealt, own);
        }
    }
}

#[test]
fn banks_rarely_collide() {
    for lanes in [1, 2, 4] {
        let halves = chain(lanes);
        let nobody = vec![Vec::new(); halves.len()];
        let found = collisions(&arrange(lanes, nobody, halves, 1));
        assert!(found < 1.2, "{lanes} lanes: {found}");
    }
}

#[test]
fn each_lane_takes_the_best_of_its_node_and_the_first_of_several() {
    for lanes in [1, 2, 8] {
        let mut left = chain(lanes);
        let slots = arrange(lanes, vec![Vec::new(); left.len()], left.clone(), 2);
        for slot in slots {
            let mut reads = Reads::default();
            for (lane, taken) in slot.iter().enumerate() {
                reads.next_lane(lane);
                let own = &mut left[lane / lanes];
                let in_bank = |h: &Half| {
                    own.iter().filter(|o| o.1 as usize % BANKS == h.1 as usize % BANKS).count()
                };
                let worth = |h: &Half| (reads.gain(h.1), in_bank(h));
                let best = own.iter().map(worth).max();
                let wanted = own.iter().position(|h| Some(worth(h)) == best);
                assert_eq!(wanted.map(|at| own[at]), *taken);
                if let Some(at) = wanted {
                    reads.take(own.swap_remove(at).1);
                }
            }
        }
    }
}
