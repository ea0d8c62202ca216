use std::collections::BTreeSet;

use super::*;

/// Goes that quarters of warps need for the states of their triplets' ends.
fn goes(ends: &[[u32; 3]], order: &[usize]) -> usize {
    let quarter = |lanes: &[usize], end: usize| {
        let mut banks = [const { BTreeSet::new() }; 8];
        lanes.iter().for_each(|&t| {
            banks[ends[t][end] as usize % 8].insert(ends[t][end]);
        });
        banks.iter().map(BTreeSet::len).max().unwrap_or(0)
    };
    order.chunks(8).map(|lanes| (0..3).map(|end| quarter(lanes, end)).sum::<usize>()).sum()
}

#[test]
fn all_triplets_come_once_and_in_fewer_goes() {
    // A grid of 24 x 24 nodes, bent along both axes.
    let node = |x: u32, y: u32| 24 * y + x;
    let ends: Vec<[u32; 3]> = (0..24)
        .flat_map(|y| (1..23).map(move |x| (x, y)))
        .flat_map(|(x, y)| {
            [
                [node(x - 1, y), node(x, y), node(x + 1, y)],
                [node(y, x - 1), node(y, x), node(y, x + 1)],
            ]
        })
        .collect();
    let order = arrange(&ends);
    let all: BTreeSet<usize> = order.iter().copied().collect();
    assert!(order.len() == ends.len() && all.len() == ends.len());
    let plain: Vec<usize> = (0..ends.len()).collect();
    assert!(goes(&ends, &order) < goes(&ends, &plain));
    assert!(arrange(&[]).is_empty());
}

#[test]
fn each_lane_takes_the_best_of_those_considered_and_the_earliest_of_several() {
    let mut bits = 7_u32;
    let mut node = || {
        bits = bits.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        bits >> 24
    };
    let ends: Vec<[u32; 3]> = (0..700).map(|_| [node(), node(), node()]).collect();
    let mut left: Vec<usize> = (0..ends.len()).collect();
    let mut reads = [Reads::default(); 3];
    for (lane, taken) in arrange(&ends).into_iter().enumerate() {
        reads.iter_mut().for_each(|r| r.next_lane(lane));
        let worth = |t: usize| reads.iter().zip(ends[t]).map(|(r, e)| r.gain(e)).sum::<u32>();
        let considered = &left[..left.len().min(CONSIDERED)];
        let best = considered.iter().map(|&t| worth(t)).max();
        assert_eq!(considered.iter().find(|&&t| Some(worth(t)) == best), Some(&taken));
        left.retain(|&t| t != taken);
        reads.iter_mut().zip(ends[taken]).for_each(|(r, end)| r.take(end));
    }
}
