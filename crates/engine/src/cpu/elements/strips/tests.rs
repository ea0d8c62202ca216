use super::*;

/// Nodes on a cubic grid, joined within two spacings.
fn grid(side: i32) -> Vec<[u32; 2]> {
    let place = |i: u32| [i as i32 % side, i as i32 / side % side, i as i32 / side / side];
    let near = |a: u32, b: u32| {
        let (a, b) = (place(a), place(b));
        (0..3).map(|c| (a[c] - b[c]).pow(2)).sum::<i32>() <= 4
    };
    let n = (side * side * side) as u32;
    (0..n).flat_map(|a| (a + 1..n).filter(move |&b| near(a, b)).map(move |b| [a, b])).collect()
}

fn elements(order: &Strips) -> Vec<usize> {
    let lanes = |b: usize| (0..LANES).filter_map(move |l| order.at(b, l));
    let mut all: Vec<usize> = (0..order.blocks()).flat_map(lanes).collect();
    all.sort_unstable();
    all
}

#[test]
fn every_element_stands_once_beside_its_owner() {
    let springs = grid(6);
    let shared = share(&springs, 216);
    let order = Strips::new(shared.clone(), 216);
    assert_eq!(elements(&order), (0..springs.len()).collect::<Vec<_>>());
    let owner_of = |s: usize| shared.iter().find(|o| o.element as usize == s).unwrap().owner;
    for strip in &order.strips {
        for b in strip.blocks() {
            for l in 0..LANES {
                assert!(order.at(b, l).is_none_or(|s| owner_of(s) == strip.owners[l]));
            }
        }
    }
}

#[test]
fn few_lanes_stay_empty() {
    let springs = grid(8);
    let order = Strips::new(share(&springs, 512), 512);
    let filled = springs.len() as f64 / (order.blocks() * LANES) as f64;
    assert!(filled > 0.9, "{filled}");
    // One centre of many: its elements are spread over lanes.
    let star = |element: u32| OwnedElement { owner: 0, others: [1 + element], element };
    let order = Strips::new((0..100).map(star).collect(), 101);
    assert_eq!((elements(&order).len(), order.blocks()), (100, 13));
}

#[test]
fn steps_keep_out_of_each_others_way() {
    let springs = grid(8);
    let shared = share(&springs, 512);
    let order = Strips::new(shared.clone(), 512);
    let mut other = vec![0; springs.len()];
    shared.iter().for_each(|s| other[s.element as usize] = s.others[0]);
    let mut twice = 0;
    for b in 0..order.blocks() {
        let mut seen: Vec<u32> =
            (0..LANES).filter_map(|l| order.at(b, l)).map(|s| other[s]).collect();
        seen.sort_unstable();
        twice += seen.windows(2).filter(|w| w[0] == w[1]).count();
    }
    assert!(twice * 50 < springs.len(), "{twice} of {}", springs.len());
}

#[test]
fn nothing_to_order_is_fine() {
    let order = Strips::new(share(&[], 0), 0);
    assert_eq!((order.blocks(), order.strips.len()), (0, 0));
    assert_eq!(order.at(0, 0), None);
}
