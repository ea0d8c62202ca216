use bendtwin_engine_kit::{RandomOptions, random_model};

use super::*;

#[test]
fn every_node_is_in_one_part_and_work_is_even() {
    let graph = random_model(3, &RandomOptions { nodes: 300, ..RandomOptions::default() }).graph;
    let mut degree = vec![0_usize; 300];
    graph.springs.iter().flatten().filter(|&&e| e < 300).for_each(|&e| degree[e as usize] += 1);
    for parts in [1, 2, 3, 8, 16] {
        let cut = partition(&graph, parts);
        assert_eq!(cut.len(), parts);
        let mut all: Vec<u32> = cut.concat();
        all.sort_unstable();
        assert!(all.into_iter().eq(0..300));
        let node_work = NODE_WORK as usize;
        let work = |p: &Vec<u32>| p.iter().map(|&i| degree[i as usize] + node_work).sum::<usize>();
        let (least, most) =
            (cut.iter().map(work).min().unwrap_or(0), cut.iter().map(work).max().unwrap_or(0));
        assert!(most <= least + 100, "{parts} parts: {least} to {most}");
    }
}

#[test]
fn fewer_nodes_than_parts_leave_parts_empty() {
    let graph = random_model(3, &RandomOptions { nodes: 3, ..RandomOptions::default() }).graph;
    let cut = partition(&graph, 8);
    assert_eq!(cut.len(), 8);
    assert_eq!(cut.concat().len(), 3);
}
