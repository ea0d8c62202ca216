mod halos;

use std::collections::BTreeSet;

use bendtwin_engine_kit::{RandomOptions, random_model};

use super::*;

fn graphs() -> Vec<Graph> {
    let sizes = [0, 1, 5, 60, 400];
    let each = sizes.into_iter().map(|nodes| {
        let options = RandomOptions { nodes, controls: 3, pins: 2, ..RandomOptions::default() };
        Graph::clone(&random_model(nodes as u64, &options).graph)
    });
    each.collect()
}

fn layouts() -> Vec<(Graph, Layout)> {
    let cuts = [(1, 64), (1, 1024), (4, 128), (16, 512)];
    let each = graphs().into_iter().flat_map(|graph| {
        cuts.map(|(blocks, threads)| {
            let layout = Layout::new(&graph, blocks, threads).expect("it is small");
            (graph.clone(), layout)
        })
    });
    each.collect()
}

/// Endpoint of the graph that a block knows by a local index.
fn endpoint(graph: &Graph, layout: &Layout, share: &Share, local: u32) -> u32 {
    if local >= layout.control_base {
        return graph.node_count() as u32 + local - layout.control_base;
    }
    assert!(local < share.local, "local index {local} of {}", share.local);
    layout.nodes[(share.nodes + local) as usize]
}

/// Half-springs that a row's lanes of one end hold: (spring, other end, whether its sums are here).
fn halves(
    graph: &Graph,
    layout: &Layout,
    share: &Share,
    first_row: u32,
    index: u32,
) -> BTreeSet<(u32, u32, bool)> {
    let lanes = layout.lanes as usize;
    let a_row = 32 / lanes;
    let row = (share.row + first_row) as usize + index as usize / a_row;
    let mut found = BTreeSet::new();
    for (at, pair) in (layout.rows[row]..layout.rows[row + 1]).enumerate() {
        for half in 0..2 * lanes {
            let e = pair as usize * 64 + index as usize % a_row * 2 * lanes + half;
            let spring = layout.springs[e];
            if spring != NONE {
                let other = endpoint(graph, layout, share, layout.others[e]);
                let sums = layout.sum_rows[row] + at as u32;
                let lane = (index as usize % a_row * lanes + half / 2) as u32;
                let here = sums * PAIR_SUMS + half as u32 % 2 * 3 * SUMS_APART + lane;
                let reports =
                    sums < layout.sum_rows[row + 1] && layout.sum_of[spring as usize] == here;
                assert!(found.insert((spring, other, reports)), "a half-spring twice");
            }
        }
    }
    found
}

/// The triplet and role that a reference means.
fn triplet_and_role(reference: u32) -> (u32, u32) {
    (reference / 288 * 32 + reference % 32, reference % 288 / 96)
}

/// References to triplets of an endpoint: an own node, or a control point behind them.
fn references(layout: &Layout, share: &Share, index: u32) -> Vec<u32> {
    let lanes = layout.lanes as usize;
    let (first_row, index) = match index.checked_sub(share.own) {
        None => (0, index as usize),
        Some(control) => (share.rows, control as usize),
    };
    let row = (share.row + first_row) as usize + index * lanes / 32;
    let own = |slot: u32| {
        let at = slot as usize * 32 + index * lanes % 32;
        layout.arm_refs[at..at + lanes].to_vec()
    };
    let slots = layout.arm_rows[row]..layout.arm_rows[row + 1];
    slots.flat_map(own).filter(|&reference| reference != NO_ARM).collect()
}

#[test]
fn every_node_has_all_its_half_springs_and_every_spring_reports_once() {
    for (graph, layout) in layouts() {
        let n = graph.node_count() as u32;
        let mut reports = vec![0; graph.springs.len()];
        let mut seen = vec![false; n as usize];
        for share in &layout.shares {
            for own in 0..share.own {
                let node = layout.nodes[(share.nodes + own) as usize];
                assert!(!std::mem::replace(&mut seen[node as usize], true));
                let found = halves(&graph, &layout, share, 0, own);
                let expected: BTreeSet<(u32, u32)> = graph
                    .springs
                    .iter()
                    .enumerate()
                    .filter_map(|(s, &[a, b])| match node {
                        i if i == a => Some((s as u32, b)),
                        i if i == b => Some((s as u32, a)),
                        _ => None,
                    })
                    .collect();
                assert!(found.iter().map(|h| (h.0, h.1)).eq(expected.iter().copied()));
                found.iter().filter(|h| h.2).for_each(|h| reports[h.0 as usize] += 1);
            }
        }
        assert!(seen.into_iter().all(|s| s));
        assert!(reports.into_iter().all(|r| r == 1));
    }
}

#[test]
fn control_points_have_their_half_springs_across_the_blocks() {
    for (graph, layout) in layouts() {
        let n = graph.node_count() as u32;
        for c in 0..graph.control_count() as u32 {
            let all: Vec<_> = layout
                .shares
                .iter()
                .flat_map(|share| halves(&graph, &layout, share, share.rows, c))
                .map(|h| h.0)
                .collect();
            let expected: Vec<u32> = (0..graph.springs.len() as u32)
                .filter(|&s| graph.springs[s as usize][1] == n + c)
                .collect();
            let mut sorted = all.clone();
            sorted.sort_unstable();
            assert_eq!(sorted, expected);
        }
    }
}

#[test]
fn what_fills_up_a_row_joins_an_endpoint_to_itself() {
    for (graph, layout) in layouts() {
        let a_row = 32 / layout.lanes;
        for share in &layout.shares {
            for row in 0..share.rows + share.control_rows {
                let at = (share.row + row) as usize;
                for e in layout.rows[at] * 64..layout.rows[at + 1] * 64 {
                    let place = e % 64 / 2 / layout.lanes;
                    let own = match row.checked_sub(share.rows) {
                        None if row * a_row + place < share.own => row * a_row + place,
                        None => 0,
                        Some(row) if row * a_row + place < layout.controls => {
                            layout.control_base + row * a_row + place
                        }
                        Some(_) => layout.control_base,
                    };
                    let fills = layout.springs[e as usize] == NONE;
                    assert!(!fills || layout.others[e as usize] == own, "{}", graph.springs.len());
                }
            }
        }
    }
}

#[test]
fn sums_are_apart() {
    for (_, layout) in layouts() {
        let parts =
            layout.sum_of.iter().flat_map(|&first| (0..3).map(move |k| first + k * SUMS_APART));
        let mut seen = BTreeSet::new();
        assert!(parts.clone().all(|p| p < layout.sum_pairs * PAIR_SUMS && seen.insert(p)));
        for share in &layout.shares {
            let rows = &layout.sum_rows[share.row as usize..][..=share.rows as usize];
            assert!(rows.windows(2).all(|w| w[1] - w[0] <= layout.max_sum_pairs));
        }
    }
}

#[test]
fn owners_send_a_node_exactly_to_the_halos_that_have_it() {
    for (_, layout) in layouts() {
        let mut expected = BTreeSet::new();
        for (block, share) in layout.shares.iter().enumerate() {
            for halo in share.own..share.local {
                let node = layout.nodes[(share.nodes + halo) as usize];
                expected.insert((node, block as u32, halo));
            }
        }
        let mut found = BTreeSet::new();
        for share in &layout.shares {
            for own in 0..share.own {
                let at = (share.export_start + own) as usize;
                for e in layout.exports[at]..layout.exports[at + 1] {
                    let there = layout.export_refs[e as usize];
                    let node = layout.nodes[(share.nodes + own) as usize];
                    assert!(found.insert((node, there >> 16, there & 0xffff)));
                }
            }
        }
        assert_eq!(found, expected);
    }
}

#[test]
fn triplets_reach_all_their_ends_and_report_once() {
    for (graph, layout) in layouts() {
        let n = graph.node_count() as u32;
        let mut reports = vec![0; graph.triplets.len()];
        let mut arms = BTreeSet::new();
        for share in &layout.shares {
            for t in share.triplet..share.triplet + share.triplets {
                let (of, local) = (layout.triplet_of[t as usize], layout.triplets[t as usize]);
                let ends =
                    [local.i, local.j, local.k].map(|e| endpoint(&graph, &layout, share, e.into()));
                assert_eq!(ends, graph.triplets[of as usize]);
                reports[of as usize] += u32::from(local.owned);
            }
            for index in 0..share.own + layout.controls {
                let end = match index.checked_sub(share.own) {
                    Some(control) => n + control,
                    None => layout.nodes[(share.nodes + index) as usize],
                };
                for reference in references(&layout, share, index) {
                    let (t, role) = triplet_and_role(reference);
                    let of = layout.triplet_of[(share.triplet + t) as usize];
                    let [i, j, k] = graph.triplets[of as usize];
                    assert_eq!([i, k, j][role as usize], end);
                    assert!(arms.insert((of, end)), "an arm twice");
                }
            }
        }
        let wanted = |t: &[u32; 3]| t.iter().any(|&e| e < n);
        for (t, ends) in graph.triplets.iter().enumerate().filter(|(_, t)| wanted(t)) {
            assert_eq!(reports[t], 1);
            assert!(ends.iter().all(|&e| arms.contains(&(t as u32, e))));
        }
    }
}

#[test]
fn pins_are_known_wherever_their_nodes_are() {
    for (graph, layout) in layouts() {
        for share in &layout.shares {
            let span = share.pin as usize..(share.pin + share.pins) as usize;
            for pin in &layout.local_pins[span] {
                let node = layout.nodes[(share.nodes + pin.local) as usize];
                assert_eq!(node, graph.pins[pin.pin as usize].node);
            }
            let local = (0..share.local).map(|i| layout.nodes[(share.nodes + i) as usize]);
            let pinned = local.filter(|&i| graph.pins.iter().any(|p| p.node == i)).count();
            assert_eq!(pinned, share.pins as usize);
        }
    }
}

#[test]
fn rods_turn_at_their_inner_nodes_where_a_block_has_them_all() {
    let options = RandomOptions { rod: true, pins: 4, ..RandomOptions::default() };
    let graph = Graph::clone(&random_model(3, &options).graph);
    let layout = Layout::new(&graph, 1, 256).expect("it is small");
    let share = layout.shares[0];
    assert_eq!(layout.rod_turns, [share.triplets, share.triplets + graph.rods[0].len() as u32 - 2]);
    let mut arms = BTreeSet::new();
    for index in 0..share.own {
        let refs = references(&layout, &share, index);
        let node = layout.nodes[(share.nodes + index) as usize];
        let parts = refs.into_iter().map(triplet_and_role);
        arms.extend(parts.map(|(t, role)| (t, role, node)));
    }
    for (t, ends) in (share.triplets..).zip(graph.rods[0].windows(3)) {
        let local = layout.triplets[(share.triplet + t) as usize];
        assert_eq!(
            [local.i, local.j, local.k].map(|e| endpoint(&graph, &layout, &share, e.into())),
            *ends
        );
        assert_eq!(local.owned, 0, "it has no sums of a triplet");
        for (role, end) in [(0, ends[0]), (1, ends[2]), (2, ends[1])] {
            assert!(arms.contains(&(t, role, end)), "{end} does not hear of {t}");
        }
    }
    assert!(Layout::new(&graph, 4, 128).expect("it is small").rod_turns.is_empty());
}
