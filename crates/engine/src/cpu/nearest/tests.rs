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
