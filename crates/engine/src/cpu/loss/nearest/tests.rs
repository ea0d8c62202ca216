use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::*;

fn node(x: f32) -> Node<f32> {
    Node { x: [x, 0.0, 0.0, 0.0], v: [0.0; 4] }
}

#[test]
fn every_answer_is_a_node_however_far_the_target() {
    for count in [1, 5, LANES, LANES + 1] {
        let nodes: Vec<_> = (0..count).map(|i| node(i as f32)).collect();
        let targets = [-1e15, -1e3, 0.4, 1e3, 1e15, 3e38].map(|x| [x, x, 1e15, 0.0]);
        assert!(nearest(&nodes, &targets).iter().all(|&i| (i as usize) < count), "{count} nodes");
    }
}

#[test]
fn ties_go_to_the_lower_index() {
    let nodes = [node(1.0), node(-1.0), node(1.0)];
    assert_eq!(nearest(&nodes, &[[0.0; 4], [1.0, 0.0, 0.0, 0.0]]), [0, 0]);
}

/// Nodes in space, in a plane, on a lattice where many are equally near, and in one heap; targets
/// among them, beside them, far away and at no place.
#[test]
fn a_grid_answers_as_brute_force_does() {
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let scales: [[f32; 3]; 3] = [[0.3, 0.2, 0.1], [0.3, 0.2, 0.0], [0.3, 0.0, 0.0]];
    for (scale, step) in scales.into_iter().flat_map(|s| [(s, 0.0), (s, 0.02)]) {
        let mut place = |reach: f32, from: f32| -> Quad<f32> {
            let mut at = |c: usize| {
                let x = scale[c] * (from + (reach - from) * rng.random::<f32>());
                if step > 0.0 { (x / step).round() * step } else { x }
            };
            [at(0), at(1), at(2), 0.0]
        };
        let nodes: Vec<_> = (0..1200).map(|_| Node { x: place(1.0, 0.0), v: [0.0; 4] }).collect();
        let mut targets: Vec<_> = (0..800).map(|_| place(1.05, -0.05)).collect();
        targets.extend((0..200).map(|_| place(9.0, -8.0)));
        targets.extend([[0.15, 0.1, 0.4, 0.0], [f32::NAN; 4], [f32::INFINITY; 4], [1e30; 4]]);
        assert!(nodes.len() * targets.len() >= GRID_PAIRS);
        let expected = by_brute_force(&nodes, &targets);
        assert_eq!(nearest(&nodes, &targets), expected, "{scale:?}, {step}");
        let Some(grid) = Grid::new(&nodes) else {
            // Few places of a lattice on a line have many nodes each.
            assert!(scale[1] == 0.0 && step > 0.0, "{scale:?}, {step}");
            continue;
        };
        let near = targets[..800].iter().filter(|t| grid.nearest(t).is_some()).count();
        assert!(near > 600, "only {near} of 800 are near: {scale:?}, {step}");
    }
}

#[test]
fn nodes_at_one_place_or_at_none_have_no_grid() {
    assert!(Grid::new(&vec![node(2.0); 100]).is_none());
    let mut nodes: Vec<_> = (0..100).map(|i| node(i as f32)).collect();
    assert!(Grid::new(&nodes).is_some());
    nodes[7] = node(f32::NAN);
    assert!(Grid::new(&nodes).is_none());
    // All but one are in the same cell.
    nodes[7] = node(1e9);
    assert!(Grid::new(&nodes).is_none());
}
