use bendtwin_engine_kit::{RandomOptions, random_model};

use super::*;

#[test]
fn a_node_reports_half_of_its_springs() {
    for (seed, nodes) in [(1, 2), (2, 5), (3, 60), (4, 401)] {
        let options = RandomOptions { nodes, controls: 3, ..RandomOptions::default() };
        let graph = Graph::clone(&random_model(seed, &options).graph);
        let n = graph.node_count();
        let (mut all, mut reported, mut held) = (vec![0; n], vec![0; n], vec![0; n]);
        for (&[a, b], first) in graph.springs.iter().zip(first_ends(&graph)) {
            if b as usize >= n {
                assert!(first, "control points report nothing");
                held[a as usize] += 1;
                continue;
            }
            [a, b].iter().for_each(|&e| all[e as usize] += 1);
            reported[if first { a } else { b } as usize] += 1;
        }
        for i in 0..n {
            let most = (all[i] + 1) / 2;
            assert!(reported[i] <= most, "node {i}: {} of {}", reported[i], all[i]);
            assert!(all[i] - reported[i] <= most);
        }
    }
}
