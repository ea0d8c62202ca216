//! Properties that `team.cuh` relies on where blocks wait for bytes alone: a block writes into
//! another's halo once it has received from it, so it must also have received from all readers of
//! its earlier writes.

use super::*;

/// Graphs without geometry: any endpoints may be joined.
fn tangles() -> Vec<Graph> {
    let mut state = 1_u64;
    let mut below = move |limit: usize| {
        state =
            state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        ((state >> 33) % limit as u64) as u32
    };
    let sizes = [(1, 1, 2), (3, 2, 8), (40, 3, 30), (90, 1, 400), (200, 40, 60)];
    let each = sizes.map(|(n, c, elements)| {
        let options = RandomOptions { nodes: n, controls: c, pins: 1, ..RandomOptions::default() };
        let mut graph = Graph::clone(&random_model(n as u64, &options).graph);
        graph.springs.clear();
        graph.triplets.clear();
        for _ in 0..elements {
            let (spring, triplet) =
                ([below(n), below(n + c)], [below(n + c), below(n + c), below(n + c)]);
            if spring[0] != spring[1] {
                graph.springs.push(spring);
            }
            let [i, j, k] = triplet;
            if i != j && j != k && i != k {
                graph.triplets.push(triplet);
            }
        }
        assert_eq!(graph.check(), Ok(()));
        graph
    });
    each.to_vec()
}

/// Graphs in up to 16 shares, some of them empty.
fn cut() -> Vec<(Graph, Layout)> {
    let graphs = graphs().into_iter().chain(tangles());
    let each = graphs.flat_map(|graph| {
        [2, 4, 8, 16].map(|blocks| {
            let layout = Layout::new(&graph, blocks, 128).expect("it is small");
            (graph.clone(), layout)
        })
    });
    each.collect()
}

fn owners(graph: &Graph, layout: &Layout) -> Vec<usize> {
    let mut owners = vec![usize::MAX; graph.node_count()];
    for (block, share) in layout.shares.iter().enumerate() {
        for &node in &layout.nodes[share.nodes as usize..][..share.own as usize] {
            owners[node as usize] = block;
        }
    }
    owners
}

fn halos(layout: &Layout) -> Vec<BTreeSet<u32>> {
    let halo = |s: &Share| (s.own..s.local).map(|i| layout.nodes[(s.nodes + i) as usize]).collect();
    layout.shares.iter().map(halo).collect()
}

#[test]
fn nodes_that_an_element_joins_are_in_each_others_halos() {
    for (graph, layout) in cut() {
        let (owners, halos) = (owners(&graph, &layout), halos(&layout));
        let springs = graph.springs.iter().map(<[u32; 2]>::as_slice);
        for ends in springs.chain(graph.triplets.iter().map(<[u32; 3]>::as_slice)) {
            let nodes: Vec<u32> =
                ends.iter().copied().filter(|&e| (e as usize) < owners.len()).collect();
            for &reader in &nodes {
                let (block, halo) = (owners[reader as usize], &halos[owners[reader as usize]]);
                for &read in &nodes {
                    assert!(owners[read as usize] == block || halo.contains(&read));
                }
            }
        }
    }
}

#[test]
fn a_block_sends_to_those_it_receives_from() {
    for (graph, layout) in cut() {
        let (owners, halos) = (owners(&graph, &layout), halos(&layout));
        let receives = |block: usize| -> BTreeSet<usize> {
            halos[block].iter().map(|&node| owners[node as usize]).collect()
        };
        for (block, share) in layout.shares.iter().enumerate() {
            let from = layout.exports[share.export_start as usize] as usize;
            let to = layout.exports[(share.export_start + share.own) as usize] as usize;
            let sent: BTreeSet<usize> =
                layout.export_refs[from..to].iter().map(|there| (there >> 16) as usize).collect();
            assert_eq!(sent, receives(block));
            assert!(!sent.contains(&block));
        }
    }
}

#[test]
fn a_halo_receives_as_often_as_it_has_nodes() {
    for (_, layout) in cut() {
        for (block, share) in (0_u32..).zip(&layout.shares) {
            let received = layout.export_refs.iter().filter(|&there| there >> 16 == block);
            assert_eq!(received.count() as u32, share.local - share.own);
        }
    }
}

/// A node that reads the halo is sent to the owner of what was read, after the read.
#[test]
fn only_elements_of_own_nodes_read_the_halo() {
    for (_, layout) in cut() {
        for share in &layout.shares {
            let triplets = &layout.triplets[share.triplet as usize..][..share.triplets as usize];
            assert!(
                triplets.iter().all(|t| [t.i, t.j, t.k].iter().any(|&e| u32::from(e) < share.own))
            );
            let rows = |row: u32| layout.rows[(share.row + row) as usize] as usize * 64;
            let (first, end) = (rows(share.rows), rows(share.rows + share.control_rows));
            let in_halo = |&other: &u32| (share.own..layout.control_base).contains(&other);
            assert!(!layout.others[first..end].iter().any(in_halo), "a control point reads a halo");
        }
    }
}
